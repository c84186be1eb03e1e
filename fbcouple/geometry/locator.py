"""In which tetrahedron a point lies, and its weights at the corners.

A point that is well inside the tetrahedron that it was in before is still there; else a walk through the sides starts
at the tetrahedron nearest to the middle of the point's bin, so that the answer depends on the point alone. Where a walk
ends at a wall (around a corner of the region) a tree gives more to try.
"""

from __future__ import annotations

import numpy as np
import scipy

from fbcouple.geometry.tetrahedra import Tetrahedra, find_neighbours
from fbcouple.physics.compiler import njit

ROUNDING = 1e-9
"""How far below zero a weight may be: a point on a wall."""
_WELL_INSIDE = 1e-6
"""Weights above it at all corners: no other tetrahedron can be taken for the one that holds the point."""
_LONGEST_WALK = 200
_TRIED = 256
_AT_ONCE = 4096


class Locator:
    """Finds points in the tetrahedra of `cells` (all of them if None)."""

    def __init__(self, parts: Tetrahedra, cells: np.ndarray | None = None) -> None:
        corners = parts.corners if cells is None else parts.corners[np.isin(parts.owners, cells)]
        self.corners = np.ascontiguousarray(corners, dtype=np.int64)
        origin = parts.nodes[corners[:, 0]]
        edges = parts.nodes[corners[:, 1:]] - origin[:, None]
        inverse = np.linalg.inv(edges.transpose(0, 2, 1))
        self._frames = np.ascontiguousarray(np.concatenate([origin, inverse.reshape(-1, 9)], axis=1))
        self._neighbours = find_neighbours(corners)
        middles = origin + edges.sum(axis=1) / 4.0
        self._tree = scipy.spatial.cKDTree(middles)
        self._lay_bins(middles)
        corners = parts.nodes[self.corners].reshape(-1, 3)
        margin = 1e-6 * np.ptp(corners, axis=0).max()
        self._box = corners.min(axis=0) - margin, corners.max(axis=0) + margin

    def _lay_bins(self, middles: np.ndarray) -> None:
        """Bins, about one a tetrahedron, and the start of the walk in each."""
        self._low = middles.min(axis=0)
        extent = np.maximum(np.ptp(middles, axis=0), 1e-12 + 1e-3 * float(np.ptp(middles, axis=0).max()))
        edge = (float(np.prod(extent)) / len(middles)) ** (1.0 / 3.0)
        shape = np.maximum(np.ceil(extent / edge), 1).astype(np.int64)
        self._scale = shape / extent
        axes = [low + (np.arange(n) + 0.5) / scale for low, n, scale in zip(self._low, shape, self._scale, strict=True)]
        centres = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
        self._starts = self._tree.query(centres)[1].reshape(shape)

    def locate(self, points: np.ndarray, found: np.ndarray, weights: np.ndarray) -> int:
        """Fill `found` (n,) with the tetrahedron and `weights` (n, 4) at its corners of each of `points` (n, 3) [m].

        `found` comes with the tetrahedra that are looked at first, or -1: they change how long it takes alone.
        Returns the first point that lies in none, or -1; weights are never below zero and add up to one.
        """
        box = self._low, self._scale, self._starts
        _walk(points, *box, self._frames, self._neighbours, found, weights)
        for p in np.flatnonzero(found < 0):
            if not np.isfinite(points[p]).all():
                return int(p)
            near = self._tree.query(points[p], min(_TRIED, len(self.corners)))[1]
            if not _try(points[p], np.atleast_1d(near), self._frames, found, weights, p) and not _try(
                points[p], np.arange(len(self.corners)), self._frames, found, weights, p
            ):
                return int(p)
        return -1

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Does a tetrahedron hold the point? (n,) for `points` (n, 3) [m]."""
        return self.find_cells(points) >= 0

    def find_cells(self, points: np.ndarray) -> np.ndarray:
        """The cell that holds each of `points` (n, 3) [m], -1 where none does."""
        points = np.ascontiguousarray(points, dtype=float)
        found, weights = np.full(len(points), -1), np.empty((len(points), 4))
        _walk(points, self._low, self._scale, self._starts, self._frames, self._neighbours, found, weights)
        low, high = self._box
        left = np.flatnonzero((found < 0) & np.all((points >= low) & (points <= high), axis=1))
        for first in range(0, len(left), _AT_ONCE):
            rows = left[first : first + _AT_ONCE]
            near = self._tree.query(points[rows], min(_TRIED, len(self.corners)))[1].reshape(len(rows), -1)
            _try_each(points, near, self._frames, found, weights, rows)
        return np.where(found >= 0, self.corners[found, 0], -1)


@njit(inline="always")
def _weigh(point, frame, w):
    x, y, z = point[0] - frame[0], point[1] - frame[1], point[2] - frame[2]
    w[1] = frame[3] * x + frame[4] * y + frame[5] * z
    w[2] = frame[6] * x + frame[7] * y + frame[8] * z
    w[3] = frame[9] * x + frame[10] * y + frame[11] * z
    w[0] = 1.0 - w[1] - w[2] - w[3]


@njit(inline="always")
def _keep(w, row):
    """Weights that rounding put below zero become zero; the sum stays one."""
    total = 0.0
    for k in range(4):
        row[k] = max(w[k], 0.0)
        total += row[k]
    for k in range(4):
        row[k] /= total


@njit(cache=True, error_model="numpy")
def _walk(points, low, scale, starts, frames, neighbours, found, weights):
    """Walk to each point; `found` is -1 where a walk ends at a side with nothing beyond.

    All of a step is in numbers of their own: an array for four weights costs as much as the walk.
    """
    for p in range(len(points)):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        here, needed = found[p], _WELL_INSIDE
        found[p] = -1
        for _ in range(_LONGEST_WALK):
            if here < 0:
                here, needed = _find_start(x, y, z, low, scale, starts), -ROUNDING
            f = frames[here]
            dx, dy, dz = x - f[0], y - f[1], z - f[2]
            a = f[3] * dx + f[4] * dy + f[5] * dz
            b = f[6] * dx + f[7] * dy + f[8] * dz
            c = f[9] * dx + f[10] * dy + f[11] * dz
            rest = 1.0 - a - b - c
            side, least = (1, a) if a < rest else (0, rest)
            side, least = (2, b) if b < least else (side, least)
            side, least = (3, c) if c < least else (side, least)
            if least >= needed:
                found[p] = here
                _keep((rest, a, b, c), weights[p])
                break
            is_walk = needed < 0.0
            here = neighbours[here, side] if is_walk else -1
            if is_walk and here < 0:
                break


@njit(inline="always")
def _find_start(x, y, z, low, scale, starts):
    i = _find_bin(x, low[0], scale[0], starts.shape[0])
    j = _find_bin(y, low[1], scale[1], starts.shape[1])
    return starts[i, j, _find_bin(z, low[2], scale[2], starts.shape[2])]


@njit(inline="always")
def _find_bin(coordinate, low, scale, count):
    return min(max(int(np.floor((coordinate - low) * scale)), 0), count - 1)


@njit(cache=True)
def _try(point, candidates, frames, found, weights, p):
    """The candidate that holds the point, if one does."""
    w = np.empty(4)
    for here in candidates:
        _weigh(point, frames[here], w)
        if w.min() >= -ROUNDING:
            found[p] = here
            _keep(w, weights[p])
            return True
    return False


@njit(cache=True)
def _try_each(points, candidates, frames, found, weights, rows):
    """`_try` for each of the `rows`, with its own row of candidates."""
    for n in range(len(rows)):
        _try(points[rows[n]], candidates[n], frames, found, weights, rows[n])
