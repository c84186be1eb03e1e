"""How much of a flat polygon lies in a rectangle or a circle, exactly: what an inlet has of each face that it cuts.

Polygons (n, 2) are convex and anticlockwise, in coordinates of their plane.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

_GAUSS = (
    (0.44594849091596489, 0.22338158967801147),
    (0.09157621350977074, 0.10995174365532187),
)
"""Places and weights of the rule of six points on a triangle, exact to the fourth degree (Dunavant 1985)."""
_ROUNDING = 1e-9
"""Part of the width of a shape by which a point may lie beyond its edge and is on it."""


@dataclass(frozen=True)
class Rectangle:
    """From its corner `low` to its corner `high` [m]."""

    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def area(self) -> float:
        """Of it alone [m2]."""
        return (self.high[0] - self.low[0]) * (self.high[1] - self.low[1])

    @property
    def bounds(self) -> np.ndarray:
        """Lower and upper corner of the box around it, (2, 2) [m]."""
        return np.array([self.low, self.high])

    def has(self, points: np.ndarray) -> np.ndarray:
        """Which of `points` (n, 2) are in it or, but for rounding, on its edge."""
        low, high = self.bounds + _ROUNDING * np.array([[-1.0], [1.0]]) * math.sqrt(self.area)
        return np.asarray(np.all((points >= low) & (points <= high), axis=1))


@dataclass(frozen=True)
class Circle:
    """About its `centre` [m]."""

    centre: tuple[float, float]
    radius: float

    @property
    def area(self) -> float:
        """Of it alone [m2]."""
        return math.pi * self.radius**2

    @property
    def bounds(self) -> np.ndarray:
        """Lower and upper corner of the box around it, (2, 2) [m]."""
        return np.array([np.array(self.centre) - self.radius, np.array(self.centre) + self.radius])

    def has(self, points: np.ndarray) -> np.ndarray:
        """Which of `points` (n, 2) are in it or, but for rounding, on its edge."""
        return np.asarray(((points - self.centre) ** 2).sum(axis=1) <= ((1.0 + _ROUNDING) * self.radius) ** 2)


Shape = Rectangle | Circle


def cross_each_other(one: Circle, other: Circle) -> bool:
    """Do two circles cut each other, neither apart nor one within the other?"""
    apart = math.dist(one.centre, other.centre)
    return abs(one.radius - other.radius) < apart < one.radius + other.radius


def measure_cover(polygon: np.ndarray, shape: Shape, above: Sequence[Shape] = ()) -> float:
    """Area [m2] that `shape` covers of the polygon, less what the shapes `above` cover. No two circles may cross."""
    pieces = [polygon]
    if isinstance(shape, Rectangle):
        pieces = [piece for piece in [clip_to(polygon, shape)] if len(piece)]
    for rectangle in (other for other in above if isinstance(other, Rectangle)):
        pieces = [part for piece in pieces for part in _take_away(piece, rectangle)]
    circles = _keep_outermost([other for other in above if isinstance(other, Circle)])
    if isinstance(shape, Rectangle):
        return sum(_find_area(piece) - sum(_cut_circle(piece, other)[0] for other in circles) for piece in pieces)
    if any(_is_within(shape, other) for other in circles):
        return 0.0
    inside = [other for other in circles if _is_within(other, shape)]
    return sum(_cut_circle(piece, shape)[0] - sum(_cut_circle(piece, other)[0] for other in inside) for piece in pieces)


def integrate_parabola(polygon: np.ndarray, shape: Shape) -> float:
    """Integral [m2] over the part of the polygon in `shape` of a parabolic profile whose mean over it is 1: of a circle
    2 (1 - r^2/R^2), of a rectangle 9/4 (1 - x^2)(1 - y^2) from edge to edge -1 to 1."""
    if isinstance(shape, Circle):
        area, moment = _cut_circle(polygon, shape)
        return 2.0 * (area - moment / shape.radius**2)
    piece = clip_to(polygon, shape)
    if not len(piece):
        return 0.0
    low, high = np.array(shape.low), np.array(shape.high)
    scaled = (2.0 * piece - low - high) / (high - low)
    total = 0.0
    for second, third in pairwise(scaled[1:]):
        corners = np.array([scaled[0], second, third])
        size = 0.5 * _cross(second - scaled[0], third - scaled[0])
        for share, weight in _GAUSS:
            for k in range(3):
                shares = np.full(3, share)
                shares[k] = 1.0 - 2.0 * share
                x, y = shares @ corners
                total += size * weight * (1.0 - x * x) * (1.0 - y * y)
    return 2.25 * total * shape.area / 4.0


def find_disc_area(polygon: np.ndarray, circle: Circle) -> float:
    """Area [m2] of the polygon within the circle."""
    return _cut_circle(polygon, circle)[0]


def _cross(a: np.ndarray, b: np.ndarray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _find_area(polygon: np.ndarray) -> float:
    origin = polygon[0]
    return 0.5 * sum(_cross(one - origin, other - origin) for one, other in pairwise(polygon[1:]))


def _halve(polygon: np.ndarray, axis: int, limit: float, sign: float) -> np.ndarray:
    """The part of the polygon where sign (x_axis - limit) <= 0; empty where none of its area is."""
    heights = (sign * (polygon[:, axis] - limit)).tolist()
    if max(heights, default=0.0) <= 0.0:
        return polygon
    if min(heights) >= 0.0:
        return np.empty((0, 2))
    kept = []
    for n, point in enumerate(polygon):
        before, here = heights[n - 1], heights[n]
        if before * here < 0.0:
            kept.append(polygon[n - 1] + before / (before - here) * (point - polygon[n - 1]))
        if here <= 0.0:
            kept.append(point)
    return np.array(kept)


def clip_to(polygon: np.ndarray, rectangle: Rectangle) -> np.ndarray:
    """The part of the polygon in the rectangle; empty where none of its area is."""
    for axis in (0, 1):
        for limit, sign in ((rectangle.low[axis], -1.0), (rectangle.high[axis], 1.0)):
            polygon = _halve(polygon, axis, limit, sign) if len(polygon) else polygon
    return polygon


def _take_away(polygon: np.ndarray, rectangle: Rectangle) -> list[np.ndarray]:
    """Convex parts of the polygon that are not in the rectangle."""
    parts, rest = [], polygon
    for axis in (0, 1):
        for limit, sign in ((rectangle.low[axis], -1.0), (rectangle.high[axis], 1.0)):
            if len(rest):
                parts.append(_halve(rest, axis, limit, -sign))
                rest = _halve(rest, axis, limit, sign)
    return [part for part in parts if len(part)]


def _is_within(inner: Circle, outer: Circle) -> bool:
    return math.dist(inner.centre, outer.centre) <= outer.radius - inner.radius


def _keep_outermost(circles: list[Circle]) -> list[Circle]:
    """Circles that lie within no other of them; of equal ones the last."""
    return [
        circle
        for n, circle in enumerate(circles)
        if not any(
            _is_within(circle, other) and (n < m or not _is_within(other, circle))
            for m, other in enumerate(circles)
            if m != n
        )
    ]


def _cut_circle(polygon: np.ndarray, circle: Circle) -> tuple[float, float]:
    """Area [m2] of the polygon within the circle, and the integral of r^2 over it [m4]: the sum over its edges of what
    the circle has of the triangle between the edge and its centre."""
    corners = (polygon - circle.centre).tolist()
    area = moment = 0.0
    for n, end in enumerate(corners):
        part, square = _cut_triangle(corners[n - 1], end, circle.radius)
        area += part
        moment += square
    return area, moment


def _cut_triangle(a: Sequence[float], b: Sequence[float], radius: float) -> tuple[float, float]:
    (ax, ay), (bx, by) = a, b
    dx, dy = bx - ax, by - ay
    length = dx * dx + dy * dy
    along = ax * dx + ay * dy
    inside = along * along - length * (ax * ax + ay * ay - radius * radius)
    first, last = 1.0, 0.0
    if length > 0.0 and inside > 0.0:
        root = math.sqrt(inside)
        first, last = max((-along - root) / length, 0.0), min((-along + root) / length, 1.0)
    if first >= last:
        angle = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
        return 0.5 * radius**2 * angle, 0.25 * radius**4 * angle
    px, py, qx, qy = ax + first * dx, ay + first * dy, ax + last * dx, ay + last * dy
    angle = math.atan2(ax * py - ay * px, ax * px + ay * py) if first > 0.0 else 0.0
    angle += math.atan2(qx * by - qy * bx, qx * bx + qy * by) if last < 1.0 else 0.0
    cross = px * qy - py * qx
    square = px * px + py * py + px * qx + py * qy + qx * qx + qy * qy
    return 0.5 * radius**2 * angle + 0.5 * cross, 0.25 * radius**4 * angle + cross * square / 12.0
