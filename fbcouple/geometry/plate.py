"""A rectangular plate with holes, as triangles that share whole edges."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from fbcouple.geometry.plane_cover import Circle, Rectangle, Shape

_CORNERS = 24
"""Of the polygon that stands for a circle, of the same area."""
_ROOM = 1.01
"""Radius that holds that polygon, over the circle's, and a little more."""
_DIGITS = 12
"""Coordinates over the length of the plate that agree in so many are one."""

Trapezoid = tuple[float, float, float, float]
"""Between two lines across: lower and upper end on the left one, and on the right one."""


def outline(shape: Shape) -> np.ndarray:
    """Corners (n, 2) [m] of a shape, anticlockwise; of a circle those of a polygon as large."""
    if isinstance(shape, Rectangle):
        (x, y), (right, top) = shape.low, shape.high
        return np.array([[x, y], [right, y], [right, top], [x, top]])
    turns = 2.0 * np.pi * (np.arange(_CORNERS) + 0.5) / _CORNERS
    radius = shape.radius * np.sqrt(2.0 * np.pi / (_CORNERS * np.sin(2.0 * np.pi / _CORNERS)))
    return np.array(shape.centre) + radius * np.column_stack([np.cos(turns), np.sin(turns)])


def cut_plate(size: tuple[float, float], holes: Sequence[Shape]) -> np.ndarray:
    """Triangles (n, 3, 2) [m] of the plate from 0 to `size` around `holes`, which do not overlap; what of them lies
    beyond the plate counts for nothing.

    Strips between the corners' abscissas are cut into trapezoids, and these so that neighbours share whole edges:
    a particle on an edge that only one of two has would be pushed by both.
    """
    scale = max(size)
    polygons = [np.round(np.clip(outline(hole), 0.0, size) / scale, _DIGITS) for hole in holes]
    width, height = (round(edge / scale, _DIGITS) for edge in size)
    lines = np.unique(np.concatenate([[0.0, width], *(polygon[:, 0] for polygon in polygons)])).tolist()
    strips = [_cut_strip(left, right, height, polygons) for left, right in pairwise(lines)]
    ends: list[set[float]] = [set() for _ in lines]
    for n, strip in enumerate(strips):
        for low, high, other_low, other_high in strip:
            ends[n] |= {low, high}
            ends[n + 1] |= {other_low, other_high}
    triangles: list[list[tuple[float, float]]] = []
    for n, strip in enumerate(strips):
        for trapezoid in strip:
            triangles += _join(lines[n], lines[n + 1], trapezoid, sorted(ends[n]), sorted(ends[n + 1]))
    return scale * np.array(triangles).reshape(-1, 3, 2)


def _cut_strip(left: float, right: float, height: float, polygons: Sequence[np.ndarray]) -> list[Trapezoid]:
    """What the polygons leave of a strip from `left` to `right`, from below to above."""
    taken = []
    for polygon in polygons:
        crossing = []
        for start, end in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
            (x, y), (to, up) = sorted([start.tolist(), end.tolist()])
            if x <= left and to >= right and x < to:
                slope = (up - y) / (to - x)
                crossing.append(tuple(round(y + slope * (place - x), _DIGITS) for place in (left, right)))
        if crossing:
            low, high = min(crossing, key=sum), max(crossing, key=sum)
            taken.append((low[0], high[0], low[1], high[1]))
    found: list[Trapezoid] = []
    below = 0.0, 0.0
    for low, high, other_low, other_high in [*sorted(taken, key=sum), (height, height, height, height)]:
        if low > below[0] or other_low > below[1]:
            found.append((below[0], low, below[1], other_low))
        below = high, other_high
    return found


def _join(
    left: float, right: float, trapezoid: Trapezoid, ends: list[float], other_ends: list[float]
) -> list[list[tuple[float, float]]]:
    """Triangles of a trapezoid, anticlockwise, whose sides have corners at all `ends` on them."""
    low, high, other_low, other_high = trapezoid
    one = [(left, y) for y in ends if low <= y <= high]
    other = [(right, y) for y in other_ends if other_low <= y <= other_high]
    triangles, i, j = [], 0, 0
    while i < len(one) - 1 or j < len(other) - 1:
        climbs = j == len(other) - 1 or (i < len(one) - 1 and one[i + 1][1] <= other[j + 1][1])
        tip = one[i + 1] if climbs else other[j + 1]
        triangles.append([one[i], other[j], tip])
        i, j = (i + 1, j) if climbs else (i, j + 1)
    return triangles


def overlap(one: Shape, other: Shape) -> bool:
    """Do two shapes, a circle with room for its polygon, have more than an edge in common?"""
    if isinstance(one, Rectangle) and isinstance(other, Rectangle):
        return bool(np.all(np.maximum(one.low, other.low) < np.minimum(one.high, other.high)))
    circle, rest = (one, other) if isinstance(one, Circle) else (other, one)
    assert isinstance(circle, Circle)
    apart = float(measure_distances(rest, np.array([circle.centre]))[0])
    further = rest.radius if isinstance(rest, Circle) else 0.0
    return apart < _ROOM * circle.radius + (_ROOM - 1.0) * further


def measure_distances(shape: Shape, points: np.ndarray) -> np.ndarray:
    """Distance (n,) [m] of each of `points` (n, 2) from a shape, 0 in it."""
    if isinstance(shape, Circle):
        return np.maximum(np.linalg.norm(points - shape.centre, axis=1) - shape.radius, 0.0)
    low, high = shape.bounds
    return np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0.0), axis=1)
