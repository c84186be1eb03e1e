"""An upright cylinder of tetrahedra or prisms, without a mesher: rings of nearly equal triangles."""

from __future__ import annotations

import numpy as np

from fbcouple.geometry.extrusion import PER_PRISM, extrude
from fbcouple.geometry.polymesh import PolyMesh

_SECTORS = 6


def make_cylinder(diameter: float, height: float, across: int, layers: int, elements: str) -> PolyMesh:
    """A cylinder on z = 0 that touches x = 0 and y = 0, with the patches inlet (floor), outlet (top) and walls.

    across: cells along a diameter, an even number; ring k of `across`/2 has 6 k points and 6 (2 k - 1) triangles of
    nearly one size. elements: "prisms", or "tetrahedra", three of the same volume from each prism.
    """
    rings = across // 2
    flat, triangles = _triangulate(rings)
    flat = 0.5 * diameter * (flat / rings + 1.0)
    return extrude(flat, triangles, height, layers, elements)


def count_cells(across: int, layers: int, elements: str) -> int:
    """Cells of `make_cylinder`."""
    return _SECTORS * (across // 2) ** 2 * layers * PER_PRISM[elements]


def find_section(diameter: float, across: int) -> float:
    """Area [m2] of the polygon that is the floor of `make_cylinder`."""
    sides = _SECTORS * (across // 2)
    return sides / 2.0 * (diameter / 2.0) ** 2 * float(np.sin(2.0 * np.pi / sides))


def make_floor(diameter: float, across: int) -> np.ndarray:
    """Corners (n, 2) [m] of that polygon, anticlockwise."""
    sides = _SECTORS * (across // 2)
    angles = 2.0 * np.pi * np.arange(sides) / sides
    return 0.5 * diameter * (np.column_stack([np.cos(angles), np.sin(angles)]) + 1.0)


def _triangulate(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) of a disc of the radius `rings`, and its triangles (m, 3), anticlockwise."""
    points, triangles = [np.zeros((1, 2))], []
    start, inside = 1, 0
    for k in range(1, rings + 1):
        angles = 2.0 * np.pi * np.arange(_SECTORS * k) / (_SECTORS * k)
        points.append(k * np.column_stack([np.cos(angles), np.sin(angles)]))
        sector, j = (axis.ravel() for axis in np.meshgrid(np.arange(_SECTORS), np.arange(k), indexing="ij"))
        outer = start + sector * k + j
        after = start + (sector * k + j + 1) % (_SECTORS * k)
        inner = inside + (sector * (k - 1) + j) % max(_SECTORS * (k - 1), 1)
        beside = inside + (sector * (k - 1) + j + 1) % max(_SECTORS * (k - 1), 1)
        triangles.append(np.column_stack([outer, after, inner]))
        gap = j < k - 1
        triangles.append(np.column_stack([inner, after, beside])[gap])
        start, inside = start + _SECTORS * k, start
    return np.concatenate(points), np.concatenate(triangles)
