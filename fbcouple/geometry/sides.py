"""Outer faces of a mesh in the sides of the box around it, and what shapes on a side cover of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fbcouple.geometry.plane_cover import Shape, measure_cover
from fbcouple.geometry.polymesh import PolyMesh

SIDES = {"floor": (2, 0), "top": (2, 1), "left": (0, 0), "right": (0, 1), "front": (1, 0), "back": (1, 1)}
"""Side -> the axis across it, and whether it is at its low (0) or high (1) end."""
_NEAR = 1e-9
Integrate = Callable[[np.ndarray], float]


def find_axes(side: str) -> tuple[int, int]:
    """The two axes along a side."""
    across = SIDES[side][0]
    one, other = (axis for axis in range(3) if axis != across)
    return one, other


def list_side(mesh: PolyMesh, side: str) -> np.ndarray:
    """Outer faces all of whose points are in a side of the box around the mesh."""
    axis, end = SIDES[side]
    level = (mesh.high if end else mesh.low)[axis]
    near = np.abs(mesh.points[:, axis] - level) <= _NEAR * float(mesh.high[axis] - mesh.low[axis])
    outer = np.arange(len(mesh.neighbour), len(mesh.owner))
    rows = mesh.faces.take(outer)
    return outer[np.logical_and.reduceat(near[rows.values], rows.starts[:-1])]


def list_polygons(mesh: PolyMesh, faces: np.ndarray, side: str) -> list[np.ndarray]:
    """Corners (n, 2) [m] of flat `faces` in the two coordinates of their side, anticlockwise."""
    if not len(faces):
        return []
    rows = mesh.faces.take(faces)
    coordinates = mesh.points[rows.values][:, find_axes(side)]
    polygons = np.split(coordinates, rows.starts[1:-1])
    turned = np.array([_turn(polygon) for polygon in polygons]) < 0.0
    return [polygon[::-1] if back else polygon for polygon, back in zip(polygons, turned, strict=True)]


def _turn(polygon: np.ndarray) -> float:
    """Twice the area of a polygon, below 0 where it is clockwise."""
    x, y = (polygon - polygon[0]).T
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def cover_faces(
    polygons: Sequence[np.ndarray], shape: Shape | None, above: Sequence[Shape], integrate: Integrate | None
) -> np.ndarray:
    """Part of each polygon that `shape`, or without one all of the side, covers, less what those `above` cover.

    integrate: gives the integral over a polygon of a profile whose mean over the shape is 1, which weights it.
    """
    shares = np.zeros(len(polygons))
    for n, polygon in enumerate(polygons):
        if shape is not None and not _touches(polygon, shape):
            continue
        near = [other for other in above if _touches(polygon, other)]
        if integrate is not None:
            shares[n] = integrate(polygon) / (0.5 * _turn(polygon))
        elif not near and (shape is None or bool(shape.has(polygon).all())):
            shares[n] = 1.0
        else:
            shares[n] = _measure(polygon, shape, near) / (0.5 * _turn(polygon))
    return shares


def _measure(polygon: np.ndarray, shape: Shape | None, above: Sequence[Shape]) -> float:
    if shape is None:
        return 0.5 * _turn(polygon) - sum(measure_cover(polygon, one, above[n + 1 :]) for n, one in enumerate(above))
    return measure_cover(polygon, shape, above)


def _touches(polygon: np.ndarray, shape: Shape) -> bool:
    low, high = shape.bounds
    return bool(np.all(polygon.max(axis=0) > low) and np.all(polygon.min(axis=0) < high))
