"""Profiles of inlets from points: against closed forms and quadrature, parts that make up the whole, and refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import dblquad

from fbcouple.errors import CaseError
from fbcouple.geometry.plane_cover import Circle, Rectangle, integrate_parabola
from fbcouple.geometry.velocity_profile import make_radial, make_strips, make_triangles
from tests.geometry.test_plane_cover import tile

CIRCLE, RECTANGLE = Circle((0.47, 0.52), 0.31), Rectangle((0.13, 0.21), (0.83, 0.77))
FACE = np.array([[0.6, 0.6], [0.75, 0.6], [0.75, 0.78], [0.6, 0.78]])


def scatter():
    inner = np.random.default_rng(1).uniform(0.1, 0.85, (200, 2))
    positions = np.concatenate([inner, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    return positions, 1.0 + np.sin(9.0 * positions[:, 0]) * positions[:, 1]


def list_profiles():
    radii, positions = np.linspace(0.0, 0.31, 23), scatter()
    return {
        "radial": (make_radial(CIRCLE, radii, 1.0 + np.cos(9.0 * radii)), CIRCLE.area),
        "across": (make_strips(RECTANGLE, 0, np.linspace(0.13, 0.83, 31), np.linspace(0.0, 3.0, 31)), RECTANGLE.area),
        "up": (make_strips(RECTANGLE, 1, np.array([0.7, 0.2, 0.8]), np.array([4.0, 0.0, 1.0])), RECTANGLE.area),
        "triangles": (make_triangles(RECTANGLE, *positions), RECTANGLE.area),
    }


@pytest.mark.parametrize("name", ["radial", "across", "up", "triangles"])
@pytest.mark.parametrize("n", [1, 4, 9])
def test_parts_make_up_the_area_of_the_inlet(name, n):
    profile, area = list_profiles()[name]
    parts = [profile.integrate(triangle) for triangle in tile(n)]
    assert min(parts) > -1e-15 and sum(parts) == pytest.approx(area, rel=1e-12)


def test_a_straight_profile_is_exact_on_any_face():
    """A plane through scattered points, and the same along one coordinate, over a polygon that the rectangle cuts."""
    positions, _ = scatter()
    plane = make_triangles(RECTANGLE, positions, 1.0 + 2.0 * positions[:, 0] + positions[:, 1])
    assert plane.mean == pytest.approx(1.0 + 0.96 + 0.49, rel=1e-13)
    assert plane.peak * plane.mean == pytest.approx(1.0 + 1.66 + 0.77, rel=1e-12)
    inside = 0.15 * 0.17 * (1.0 + 2.0 * 0.675 + 0.685)
    assert plane.integrate(FACE) * plane.mean == pytest.approx(inside, rel=1e-12)
    strips = make_strips(RECTANGLE, 0, np.array([0.83, 0.13]), np.array([2.66, 1.26]))
    assert strips.integrate(FACE) * strips.mean == pytest.approx(0.15 * 0.17 * 2.35, rel=1e-13)


def test_points_that_are_off_an_edge_by_rounding_make_no_slivers():
    """Triangles without area among them gave planes of any slope, or none."""
    rng, edge = np.random.default_rng(3), np.linspace(0.1, 0.4, 32)
    sides = [np.stack([edge, np.full(32, at)], axis=1) for at in (0.1, 0.4)]
    positions = np.concatenate([*sides, *(side[1:-1, ::-1] for side in sides), rng.uniform(0.12, 0.38, (40, 2))])
    positions[:124] = np.nextafter(positions[:124], rng.choice([0.0, 1.0], (124, 2)))
    profile = make_triangles(Rectangle((0.1, 0.1), (0.4, 0.4)), positions, 1.0 + positions[:, 0])
    assert profile.mean == pytest.approx(1.25, rel=1e-9) and profile.peak * profile.mean == pytest.approx(1.4, rel=1e-9)


def test_a_fine_parabola_in_the_radius_is_the_built_in_one():
    radii = np.linspace(0.0, 0.31, 400)
    profile = make_radial(CIRCLE, radii, 1.0 - (radii / 0.31) ** 2)
    assert profile.peak == pytest.approx(2.0, rel=1e-5)
    for face in (FACE, np.array([[0.4, 0.4], [0.6, 0.45], [0.5, 0.7]]), FACE + 0.03):
        assert profile.integrate(face) == pytest.approx(integrate_parabola(face, CIRCLE), rel=2e-5)


def test_a_radial_profile_against_quadrature():
    radii = np.linspace(0.0, 0.31, 7)
    speeds = 1.0 + np.cos(9.0 * radii)
    profile = make_radial(CIRCLE, radii, speeds)
    low, high = FACE[0] - 0.1, FACE[0]  # wholly within the circle
    face = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])

    def speed(y, x):
        return float(np.interp(math.hypot(x - 0.47, y - 0.52), radii, speeds))

    whole, _ = dblquad(speed, low[0], high[0], low[1], high[1], epsabs=1e-7)
    assert profile.integrate(face) * profile.mean == pytest.approx(whole, rel=2e-6)


REFUSED = {
    "short radius": (lambda: make_radial(CIRCLE, np.array([0.0, 0.2]), np.ones(2)), "the circle has 0 to 0.31 m"),
    "no middle": (lambda: make_radial(CIRCLE, np.array([0.1, 0.31]), np.ones(2)), "in its middle and on its edge"),
    "twice": (lambda: make_radial(CIRCLE, np.array([0.0, 0.2, 0.2, 0.31]), np.ones(4)), "a radius is given twice"),
    "short slot": (
        lambda: make_strips(RECTANGLE, 0, np.array([0.2, 0.83]), np.ones(2)),
        "rectangle has 0.13 to 0.83 m",
    ),
    "one place": (lambda: make_strips(RECTANGLE, 0, np.array([0.2]), np.ones(1)), "give the velocity on its edges"),
    "same place": (
        lambda: make_strips(RECTANGLE, 1, np.array([0.2, 0.2, 0.9]), np.ones(3)),
        "a position is given twice",
    ),
    "line": (lambda: make_triangles(RECTANGLE, np.outer(np.arange(5.0), [1.0, 1.0]), np.ones(5)), "lie on one line"),
    "same point": (lambda: make_triangles(RECTANGLE, np.ones((4, 2)), np.ones(4)), "a position is given twice"),
    "gap": (lambda: make_triangles(RECTANGLE, FACE, np.ones(4)), "of the rectangle without a velocity; give some on"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_points_that_make_no_profile_are_refused(name):
    make, words = REFUSED[name]
    with pytest.raises(CaseError, match=words):
        make()
