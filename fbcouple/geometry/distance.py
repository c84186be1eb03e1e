"""Which points are near a surface of triangles."""

from __future__ import annotations

import numpy as np
import scipy

_AT_ONCE = 200_000
"""Pairs of a point and a triangle that are measured together, but for what one point has: memory."""


class Surface:
    """A part of the surface of a region, `triangles` (n, 3, 3) [m]."""

    def __init__(self, triangles: np.ndarray) -> None:
        self._triangles = triangles
        middles = triangles.mean(axis=1)
        self._tree = scipy.spatial.cKDTree(middles)
        self._widest = float(np.linalg.norm(triangles - middles[:, None], axis=2).max())
        self._low, self._high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))

    def is_near(self, points: np.ndarray, reaches: np.ndarray) -> np.ndarray:
        """Is each of `points` (n, 3) within its reach (n,) [m] of the surface?"""
        near = np.zeros(len(points), bool)
        reach = reaches[:, None]
        close = np.flatnonzero(np.all((points > self._low - reach) & (points < self._high + reach), axis=1))
        widened = reaches[close] + self._widest
        counts = self._tree.query_ball_point(points[close], widened, return_length=True)
        ends = np.flatnonzero(np.diff(np.cumsum(counts) // _AT_ONCE)) + 1
        for some, around in zip(np.split(close, ends), np.split(widened, ends), strict=True):
            near[some] = self._measure(points[some], reaches[some], around)
        return near

    def _measure(self, points: np.ndarray, reaches: np.ndarray, around: np.ndarray) -> np.ndarray:
        """The same, of triangles whose middles lie within `around` (n,) [m] of each point."""
        near = np.zeros(len(points), bool)
        found = self._tree.query_ball_point(points, around)
        which = np.repeat(np.arange(len(points)), [len(rows) for rows in found])
        if len(which):
            triangles = self._triangles[np.concatenate([rows for rows in found if rows]).astype(np.int64)]
            near[which[find_distances(points[which], triangles) < reaches[which]]] = True
        return near


def find_distances(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Distance (n,) [m] of each point (n, 3) from its triangle (n, 3, 3): from the plane if its foot is inside, else
    from the nearest edge."""
    following = np.roll(triangles, -1, axis=1)
    edges, away = following - triangles, points[:, None] - triangles
    squares = np.maximum(np.einsum("ijk,ijk->ij", edges, edges), np.finfo(float).tiny)
    part = np.clip(np.einsum("ijk,ijk->ij", away, edges) / squares, 0.0, 1.0)
    nearest = np.linalg.norm(away - part[..., None] * edges, axis=2).min(axis=1)
    normals = np.cross(edges[:, 0], edges[:, 1])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    sides = np.einsum("ijk,ijk->ij", np.cross(edges, away), np.repeat(normals[:, None], 3, axis=1))
    height = np.abs(np.einsum("ij,ij->i", away[:, 0], normals))
    return np.where(np.all(sides >= 0.0, axis=1), height, nearest)
