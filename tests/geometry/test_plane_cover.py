"""What rectangles and circles cover of polygons: exact against closed forms, and as parts that make up the whole."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fbcouple.geometry.plane_cover import Circle, Rectangle, cross_each_other, integrate_parabola, measure_cover

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
BACKGROUND = Rectangle((0.0, 0.0), (1.0, 1.0))


def tile(n):
    """Triangles that fill the unit square: n x n squares, each cut in two."""
    for i in range(n):
        for j in range(n):
            a, b, c, d = (np.array([(i + p) / n, (j + q) / n]) for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
            yield np.array([a, b, c])
            yield np.array([a, c, d])


SHAPES = [
    Rectangle((0.13, 0.21), (0.58, 0.77)),
    Circle((0.47, 0.55), 0.31),
    Circle((0.5, 0.5), 0.5),
    Rectangle((0.0, 0.4), (1.0, 0.6)),
]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("n", [1, 3, 7])
def test_parts_of_a_shape_make_up_its_area(shape, n):
    parts = [measure_cover(triangle, shape) for triangle in tile(n)]
    assert min(parts) > -1e-15 and sum(parts) == pytest.approx(shape.area, rel=1e-13)


def test_a_quarter_of_a_circle():
    assert measure_cover(SQUARE, Circle((0.0, 0.0), 1.0)) == pytest.approx(math.pi / 4.0, rel=1e-15)
    assert measure_cover(SQUARE, Circle((1.0, 1.0), 0.25)) == pytest.approx(math.pi / 64.0, rel=1e-14)
    assert measure_cover(SQUARE, Circle((2.5, 0.5), 1.0)) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    "above",
    [
        [SHAPES[0]],
        [SHAPES[1]],
        [SHAPES[0], Circle((0.8, 0.9), 0.07)],
        [Circle((0.47, 0.55), 0.11), SHAPES[1]],
        [SHAPES[1], SHAPES[1], Rectangle((0.1, 0.1), (0.5, 0.5))],
    ],
)
def test_shapes_on_top_and_what_they_leave_make_up_the_whole(above):
    shapes = [BACKGROUND, *above]
    for polygon in [SQUARE, *tile(3)]:
        parts = [measure_cover(polygon, shape, shapes[n + 1 :]) for n, shape in enumerate(shapes)]
        area = 1.0 if polygon is SQUARE else 1.0 / 18.0
        assert min(parts) > -1e-15 and sum(parts) == pytest.approx(area, rel=1e-13)


def test_a_ring_is_what_the_inner_circle_leaves():
    outer, inner = Circle((0.5, 0.5), 0.4), Circle((0.45, 0.5), 0.1)
    assert measure_cover(SQUARE, outer, [inner]) == pytest.approx(math.pi * (0.16 - 0.01), rel=1e-14)
    assert measure_cover(SQUARE, inner, [outer]) == 0.0


def test_circles_that_cross_are_told():
    assert cross_each_other(Circle((0.0, 0.0), 1.0), Circle((1.0, 0.0), 0.5))
    assert not cross_each_other(Circle((0.0, 0.0), 1.0), Circle((0.2, 0.0), 0.5))
    assert not cross_each_other(Circle((0.0, 0.0), 1.0), Circle((2.0, 0.0), 0.5))


@pytest.mark.parametrize("shape", SHAPES)
def test_parts_of_a_parabola_make_up_the_area(shape):
    assert sum(integrate_parabola(triangle, shape) for triangle in tile(5)) == pytest.approx(shape.area, rel=1e-13)


def test_a_parabola_is_highest_in_the_middle():
    tiny = 0.5 + 1e-4 * (SQUARE - 0.5)
    assert integrate_parabola(tiny, Circle((0.5, 0.5), 0.5)) / 1e-8 == pytest.approx(2.0, rel=1e-6)
    assert integrate_parabola(tiny, BACKGROUND) / 1e-8 == pytest.approx(2.25, rel=1e-6)
