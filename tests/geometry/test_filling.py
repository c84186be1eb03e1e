"""Volumes below a height from the surface of a mesh, and points near a part of it, against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fbcouple.geometry.block import make_block
from fbcouple.geometry.distance import Surface, find_distances
from fbcouple.geometry.filling import Filling


def list_surface(mesh):
    return mesh.cut_faces(np.arange(len(mesh.neighbour), len(mesh.owner)))


def widen(mesh, ratio):
    """Turn a box into a frustum: its cross-section grows evenly to `ratio` times the floor's edges at the top."""
    z = (mesh.points[:, 2:] - mesh.low[2]) / (mesh.high[2] - mesh.low[2])
    across = mesh.points[:, :2] * (1.0 + (ratio - 1.0) * z)
    return replace(mesh, points=np.column_stack([across, mesh.points[:, 2]]))


@pytest.mark.parametrize("elements", ["prisms", "tetrahedra"])
def test_a_column_fills_evenly_wherever_it_stands(elements):
    mesh = make_block((0.02, 0.03, 0.05), (3, 4, 5), elements)
    filling = Filling(list_surface(replace(mesh, points=mesh.points + np.array([1.0, -2.0, -0.7]))))
    assert (filling.bottom, filling.top) == pytest.approx((-0.7, -0.65))
    for part in (0.0, 0.013, 0.4, 0.77, 1.0):
        assert filling.find_volume(-0.7 + 0.05 * part) == pytest.approx(part * 3e-5, rel=1e-9, abs=1e-18)
        assert filling.find_level(part * 3e-5) == pytest.approx(0.05 * part, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("part", [0.05, 0.3, 0.62, 0.99])
def test_a_vessel_that_widens_fills_as_a_frustum(part):
    """The edges at the height z are a (1 + 2 z/H): V = a^2 H ((1 + 2 s)^3 - 1)/6 up to s H."""
    filling = Filling(list_surface(widen(make_block((0.02, 0.02, 0.05), (3, 3, 4), "tetrahedra"), 3.0)))
    expected = 0.02**2 * 0.05 * ((1.0 + 2.0 * part) ** 3 - 1.0) / 6.0
    assert filling.find_volume(0.05 * part) == pytest.approx(expected, rel=1e-9)
    assert filling.find_level(expected) == pytest.approx(0.05 * part, rel=1e-9)


def test_a_box_on_its_edge_fills_as_a_wedge():
    mesh = make_block((0.02, 0.03, 0.02), (2, 2, 2), "prisms")
    x, y, z = mesh.points.T
    turned = replace(mesh, points=np.column_stack([(x - z) / np.sqrt(2.0), y, (x + z) / np.sqrt(2.0)]))
    filling = Filling(list_surface(turned))
    assert filling.find_volume(0.01) == pytest.approx(0.01**2 * 0.03, rel=1e-9)
    assert filling.find_volume(filling.top - 0.01) == pytest.approx(0.02**2 * 0.03 - 0.01**2 * 0.03, rel=1e-9)


def test_what_does_not_fit_stands_above():
    filling = Filling(list_surface(make_block((0.02, 0.03, 0.05), (2, 2, 2), "prisms")))
    assert filling.find_level(1.5 * filling.volume) == pytest.approx(0.075)


def test_area_of_a_patch_is_that_of_its_faces():
    """Of a curved one too: the wall of a box is closed around, and its area vectors add up to nothing."""
    mesh = make_block((0.02, 0.03, 0.05), (3, 4, 5), "prisms")
    assert mesh.find_area("walls") == pytest.approx(2 * 0.05 * (0.02 + 0.03), rel=1e-12)
    vectors = mesh.find_vectors(mesh.list_patch("walls"))
    assert np.abs(vectors.sum(axis=0)).max() < 1e-18
    assert mesh.find_vectors(mesh.list_patch("inlet")).sum(axis=0) == pytest.approx([0.0, 0.0, -6e-4], abs=1e-18)


TRIANGLE = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]])


@pytest.mark.parametrize(
    ("point", "distance"),
    [
        ((1.0, 1.0, 2.0), 2.0),  # above the inside
        ((2.0, -1.5, 2.0), 2.5),  # beside an edge
        ((-3.0, -4.0, 0.0), 5.0),  # beyond a corner
        ((4.0 + 0.6, 3.0 - 3.0 + 0.8, 0.0), 1.0),  # where an edge and a corner meet
        ((2.0 + 0.6, 1.5 + 0.8, 0.0), 1.0),  # off the long edge
    ],
)
def test_distance_from_a_triangle(point, distance):
    assert find_distances(np.array([point]), TRIANGLE[None])[0] == pytest.approx(distance, rel=1e-12)


def test_points_near_a_patch_are_those_within_their_reach():
    mesh = make_block((0.02, 0.03, 0.05), (3, 4, 5), "tetrahedra")
    outlet = Surface(mesh.cut_faces(mesh.list_patch("outlet")))
    points = np.array([[0.01, 0.01, 0.0495], [0.01, 0.01, 0.0485], [0.0, 0.0, 0.0491], [0.01, 0.01, 0.0]])
    assert outlet.is_near(points, np.full(4, 1e-3)).tolist() == [True, False, True, False]
    assert outlet.is_near(points, np.array([4e-4, 2e-3, 1e-3, 1e-3])).tolist() == [False, True, True, False]
    assert outlet.is_near(points[:0], np.empty(0)).tolist() == []
