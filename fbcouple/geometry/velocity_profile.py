"""The velocity over an inlet that points say: its integral over any part of the inlet, for a profile whose mean is 1.

Of a rectangle it is linear on triangles between the points or, where they have one coordinate, on strips; of a circle
linear in the radius. The parts of faces that lie in the inlet add up to the integral over it, to rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import scipy

from fbcouple.errors import CaseError
from fbcouple.geometry.plane_cover import Circle, Rectangle, clip_to, find_disc_area

_GAUSS = np.polynomial.legendre.leggauss(4)
"""Places in -1 to 1, and weights."""
_FINE = 101
"""Radii of a circle at least: what it has of a face grows like a root where the circle first touches it."""
_SLIVER = 1e-12
"""Area of a triangle, over that of all, below which its corners are on one line."""
_NEAR = 1e-6
"""Part of the inlet's length by which points may fall short of its edge."""


@dataclass(frozen=True, eq=False)
class PiecewiseProfile:
    """Over a `rectangle`: convex `pieces` (corners, 2) [m], and on each the plane a + b x + c y, a row (a, b, c)."""

    rectangle: Rectangle
    pieces: tuple[np.ndarray, ...]
    planes: np.ndarray
    beyond: float = 0.0
    """How far the points go beyond the rectangle [m]; what lies there counts nowhere."""
    mean: float = field(init=False)
    """Of the velocity as the points say it [m/s]."""
    peak: float = field(init=False)
    """Its largest value over its mean."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "_lows", np.array([piece.min(axis=0) for piece in self.pieces]))
        object.__setattr__(self, "_highs", np.array([piece.max(axis=0) for piece in self.pieces]))
        (x0, y0), (x1, y1) = self.rectangle.low, self.rectangle.high
        whole = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        parts = self._cut(whole)
        covered = sum(_find_area(part) for part, _ in parts)
        if covered < self.rectangle.area * (1.0 - _NEAR):
            raise CaseError([f"leave {1.0 - covered / self.rectangle.area:.2g} of the rectangle without a velocity"])
        values = [float(np.max(plane[0] + part @ plane[1:])) for part, plane in parts]
        mean = sum(_find_area(part) * _find_mean(part, plane) for part, plane in parts) / self.rectangle.area
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "peak", max(values) / mean if mean > 0.0 else math.inf)

    def integrate(self, polygon: np.ndarray) -> float:
        """Integral [m2] of the profile over what the polygon (n, 2) has of the rectangle."""
        return self._add_up(polygon) / self.mean

    def _add_up(self, polygon: np.ndarray) -> float:
        return sum(_find_area(part) * _find_mean(part, plane) for part, plane in self._cut(polygon))

    def _cut(self, polygon: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """What the polygon has of each piece, with the piece's plane."""
        inside = clip_to(polygon, self.rectangle)
        if not len(inside):
            return []
        near = (self._lows < inside.max(axis=0)).all(axis=1) & (self._highs > inside.min(axis=0)).all(axis=1)
        found = []
        for number in np.flatnonzero(near).tolist():
            part = _clip(inside, self.pieces[number])
            if len(part) > 2:
                found.append((part, self.planes[number]))
        return found

    _lows: np.ndarray = field(init=False, repr=False)
    _highs: np.ndarray = field(init=False, repr=False)


@dataclass(frozen=True, eq=False)
class RadialProfile:
    """Over a `circle`: `speeds` [m/s] at rising `radii` [m], the first 0, the last its own, linear between."""

    circle: Circle
    radii: np.ndarray
    speeds: np.ndarray
    beyond: float = 0.0
    """How far the points go beyond the circle [m]; what lies there counts nowhere."""

    @property
    def mean(self) -> float:
        """Of the velocity as the points say it [m/s]."""
        inner, outer, slow, fast = self.radii[:-1], self.radii[1:], self.speeds[:-1], self.speeds[1:]
        slope = (fast - slow) / (outer - inner)
        parts = (slow - slope * inner) * (outer**2 - inner**2) / 2.0 + slope * (outer**3 - inner**3) / 3.0
        return float(2.0 * parts.sum() / self.circle.radius**2)

    @property
    def peak(self) -> float:
        """Its largest value over its mean."""
        return float(self.speeds.max()) / self.mean if self.mean > 0.0 else math.inf

    def integrate(self, polygon: np.ndarray) -> float:
        """Integral [m2] of the profile over what the polygon (n, 2) has of the circle.

        v(R) A(R) less the integral of v'(r) A(r), where A(r) is the area that it has of the circle of radius r, by
        Gauss' rule between points: at the same radii for all polygons, so that it is exact of their sum.
        """
        farthest = float(np.linalg.norm(polygon - self.circle.centre, axis=1).max())
        nearest = farthest - float(np.linalg.norm(np.ptp(polygon, axis=0)))
        full, radii, speeds = _find_area(polygon), self.radii, self.speeds
        total = float(speeds[-1]) * find_disc_area(polygon, self.circle)
        beyond = min(int(np.searchsorted(radii, farthest)), len(radii) - 1)
        total -= full * float(speeds[-1] - speeds[beyond])
        for n in range(max(int(np.searchsorted(radii, nearest)) - 1, 0), beyond):
            inner, outer = float(radii[n]), float(radii[n + 1])
            nodes = 0.5 * (inner + outer) + 0.5 * (outer - inner) * _GAUSS[0]
            areas = [find_disc_area(polygon, Circle(self.circle.centre, radius)) for radius in nodes.tolist()]
            total -= 0.5 * float(speeds[n + 1] - speeds[n]) * float(np.dot(_GAUSS[1], areas))
        return total / self.mean


Profile = PiecewiseProfile | RadialProfile


def make_radial(circle: Circle, radii: np.ndarray, speeds: np.ndarray) -> RadialProfile:
    """The profile of a circle of `speeds` [m/s] at `radii` [m]. Raises: CaseError (one text)."""
    order = np.argsort(radii, kind="stable")
    radii, speeds = radii[order], speeds[order]
    room = _NEAR * circle.radius
    _require_apart(np.diff(radii), room, "radius")
    if radii[0] < 0.0 or radii[0] > room or radii[-1] < circle.radius - room:
        text = f"radii from {radii[0]:g} to {radii[-1]:g} m are given, and the circle has 0 to {circle.radius:g} m"
        raise CaseError([f"{text}; give the velocity in its middle and on its edge, too."])
    last = float(np.interp(circle.radius, radii, speeds))
    inside, beyond = radii < circle.radius - room, max(float(radii[-1]) - circle.radius, 0.0)
    radii, speeds = np.append(radii[inside], circle.radius), np.append(speeds[inside], last)
    radii[0] = 0.0
    fine = np.union1d(radii, np.linspace(0.0, circle.radius, _FINE))
    return RadialProfile(circle, fine, np.interp(fine, radii, speeds), beyond)


def make_strips(rectangle: Rectangle, axis: int, positions: np.ndarray, speeds: np.ndarray) -> PiecewiseProfile:
    """The profile of a rectangle of `speeds` [m/s] at `positions` [m] along one of its axes, the same along the other.

    Raises: CaseError (one text).
    """
    order = np.argsort(positions, kind="stable")
    positions, speeds = positions[order], speeds[order]
    low, high = rectangle.low[axis], rectangle.high[axis]
    room = _NEAR * (high - low)
    _require_apart(np.diff(positions), room, "position")
    if positions[0] > low + room or positions[-1] < high - room or len(positions) < 2:
        given = f"positions from {positions[0]:g} to {positions[-1]:g} m are given"
        text = f"{given}, and the rectangle has {low:g} to {high:g} m"
        raise CaseError([f"{text}; give the velocity on its edges, too."])
    beyond = max(low - float(positions[0]), float(positions[-1]) - high, 0.0)
    positions[0], positions[-1] = min(positions[0], low), max(positions[-1], high)
    pieces, planes = [], []
    for start, end, slow, fast in zip(positions[:-1], positions[1:], speeds[:-1], speeds[1:], strict=True):
        corners = np.array([rectangle.low, rectangle.low, rectangle.high, rectangle.high])
        corners[:, 1 - axis] = np.array([rectangle.low, rectangle.high])[[0, 1, 1, 0], 1 - axis]
        corners[:, axis] = [start, start, end, end]
        pieces.append(corners if axis else corners[::-1])
        slope = (fast - slow) / (end - start)
        planes.append([slow - slope * start, *((0.0, slope) if axis else (slope, 0.0))])
    return PiecewiseProfile(rectangle, tuple(pieces), np.array(planes), beyond)


def make_triangles(rectangle: Rectangle, positions: np.ndarray, speeds: np.ndarray) -> PiecewiseProfile:
    """The profile of a rectangle of `speeds` [m/s] at `positions` (n, 2) [m]. Raises: CaseError (one text)."""
    if len(np.unique(positions, axis=0)) < len(positions):
        raise CaseError(["a position is given twice; keep one row of it."])
    try:
        mesh = scipy.spatial.Delaunay(positions)
    except (scipy.spatial.QhullError, ValueError):
        text = "the positions lie on one line, or are fewer than three"
        raise CaseError([f"{text}; give points all over the rectangle, or leave the other coordinate out."]) from None
    corners = positions[mesh.simplices]
    edges = corners[:, 1:] - corners[:, :1]
    turns = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    whole = np.abs(turns) > _SLIVER * np.ptp(positions, axis=0).prod()  # points on an edge may be off it by rounding
    corners, values = corners[whole], speeds[mesh.simplices[whole]]
    rows = np.concatenate([np.ones((*corners.shape[:2], 1)), corners], axis=2)
    planes = np.linalg.solve(rows, values[..., None])[..., 0]
    pieces = tuple(piece if turn > 0.0 else piece[::-1] for piece, turn in zip(corners, turns[whole], strict=True))
    low, high = np.array(rectangle.low), np.array(rectangle.high)
    beyond = max(float((low - positions).max()), float((positions - high).max()), 0.0)
    try:
        return PiecewiseProfile(rectangle, pieces, planes, beyond)
    except CaseError as lack:
        raise CaseError([f"the points {lack}; give some on its edges and corners, too."]) from None


def _require_apart(steps: np.ndarray, room: float, name: str) -> None:
    if (steps <= room * 1e-3).any():
        raise CaseError([f"a {name} is given twice; keep one row of it."])


def _find_area(polygon: np.ndarray) -> float:
    x, y = (polygon - polygon[0]).T
    return float(0.5 * (x[1:-1] * y[2:] - x[2:] * y[1:-1]).sum())


def _find_mean(polygon: np.ndarray, plane: np.ndarray) -> float:
    """Mean of a + b x + c y over a polygon."""
    origin = polygon[0]
    x, y = (polygon - origin).T
    areas = x[1:-1] * y[2:] - x[2:] * y[1:-1]
    total = float(areas.sum())
    if total <= 0.0:
        return 0.0
    moments = [float((areas * (w[1:-1] + w[2:])).sum()) / (3.0 * total) for w in (x, y)]
    return float(plane[0] + plane[1] * (origin[0] + moments[0]) + plane[2] * (origin[1] + moments[1]))


def _clip(polygon: np.ndarray, piece: np.ndarray) -> np.ndarray:
    """The part of a convex polygon in a convex anticlockwise `piece`; fewer than three corners where there is none."""
    rows = polygon.tolist()
    for start, end in zip(piece.tolist(), np.roll(piece, -1, axis=0).tolist(), strict=True):
        along, up = end[0] - start[0], end[1] - start[1]
        heights = [along * (y - start[1]) - up * (x - start[0]) for x, y in rows]
        kept = []
        for n, (here, height) in enumerate(zip(rows, heights, strict=True)):
            last, before = rows[n - 1], heights[n - 1]
            if before * height < 0.0:
                part = before / (before - height)
                kept.append([last[0] + part * (here[0] - last[0]), last[1] + part * (here[1] - last[1])])
            if height >= 0.0:
                kept.append(here)
        rows = kept
        if len(rows) < 3:
            return np.empty((0, 2))
    return np.array(rows)
