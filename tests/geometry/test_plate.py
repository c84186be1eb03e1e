"""Plates with holes: their area, and neighbours that share whole edges."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from fbcouple.geometry.plane_cover import Circle, Rectangle
from fbcouple.geometry.plate import cut_plate, measure_distances, outline, overlap

SIZE = (0.1, 0.05)
HOLES = {
    "none": [],
    "slot": [Rectangle((0.02, 0.01), (0.03, 0.04))],
    "at the edges": [Rectangle((0.0, 0.0), (0.03, 0.04)), Rectangle((0.06, 0.0), (0.1, 0.05))],
    "across": [Rectangle((0.02, 0.0), (0.03, 0.05)), Circle((0.06, 0.02), 0.01)],
    "round, beside each other": [
        Circle((0.06, 0.012), 0.01),
        Circle((0.061, 0.037), 0.012),
        Circle((0.02, 0.02), 0.02),
    ],
}


@pytest.mark.parametrize("name", HOLES)
def test_area_is_what_the_holes_leave_and_no_edge_is_cut(name):
    holes = HOLES[name]
    triangles = cut_plate(SIZE, holes)
    (ax, ay), (bx, by) = ((triangles[:, n] - triangles[:, 0]).T for n in (1, 2))
    areas = 0.5 * (ax * by - ay * bx)
    assert areas.min() > 0.0 and areas.sum() == pytest.approx(0.005 - sum(hole.area for hole in holes), rel=1e-9)
    edges = Counter(
        frozenset((tuple(start), tuple(end)))
        for corners in np.round(triangles, 13).tolist()
        for start, end in zip(corners, corners[1:] + corners[:1], strict=True)
    )
    assert max(edges.values()) <= 2
    rims = [outline(hole) for hole in holes]
    for edge, count in edges.items():
        middle = np.mean(list(edge), axis=0)
        at_edge = min(np.abs(middle).min(), np.abs(middle - SIZE).min()) < 1e-12
        assert count == 2 or at_edge or any(lies_on(rim, middle) for rim in rims), "a free edge within the plate"


def lies_on(rim, point):
    start, end = rim, np.roll(rim, -1, axis=0)
    lengths = [np.linalg.norm(part, axis=1) for part in (end - start, point - start, point - end)]
    return np.abs(lengths[0] - lengths[1] - lengths[2]).min() < 1e-12


def test_a_hole_as_large_as_the_plate_leaves_nothing():
    assert cut_plate(SIZE, [Rectangle((0.0, 0.0), SIZE)]).shape == (0, 3, 2)


def test_shapes_that_overlap():
    slot = Rectangle((0.02, 0.01), (0.03, 0.04))
    assert overlap(slot, Rectangle((0.029, 0.0), (0.05, 0.05))) and not overlap(slot, Rectangle((0.03, 0.0), SIZE))
    for one, other in (
        (slot, Circle((0.035, 0.02), 0.006)),
        (Circle((0.01, 0.02), 0.006), Circle((0.02, 0.02), 0.006)),
    ):
        assert overlap(one, other) and overlap(other, one)
    assert not overlap(slot, Circle((0.04, 0.02), 0.009)) and overlap(slot, Circle((0.025, 0.02), 0.001))


def test_distances():
    points = np.array([[0.025, 0.02], [0.035, 0.02], [0.033, 0.044]])
    assert measure_distances(Rectangle((0.02, 0.01), (0.03, 0.04)), points) == pytest.approx([0.0, 0.005, 0.005])
    assert measure_distances(Circle((0.025, 0.02), 0.005), points[:2]) == pytest.approx([0.0, 0.005])
