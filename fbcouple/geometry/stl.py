"""Surfaces of triangles in STL files, the walls of LIGGGHTS: those of a mesh, and plates."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.sides import list_side

ALIKE = 1e-9
"""Part of the box around a mesh that may be missing in one that fills it: rounding."""
_SQUARES = {
    "floor": [0, 2, 3, 1],
    "top": [4, 5, 7, 6],
    "front": [0, 1, 5, 4],
    "back": [2, 6, 7, 3],
    "left": [0, 4, 6, 2],
    "right": [1, 3, 7, 5],
}
"""Sides of a box by its corners, whose bits are x, y and z: anticlockwise from outside."""
_NONE = np.empty(0, np.int64)


def list_walls(mesh: PolyMesh, opened: np.ndarray = _NONE) -> np.ndarray:
    """The triangles (n, 3, 3) [m] of all outer faces but for the `opened` ones, anticlockwise from inside; of a mesh
    that fills the box around it two for each side that is whole: contacts with many small ones cost several times as
    much."""
    outer = np.setdiff1d(np.arange(len(mesh.neighbour), len(mesh.owner)), opened)
    if abs(mesh.volume / float(np.prod(mesh.high - mesh.low)) - 1.0) > ALIKE:
        return mesh.cut_faces(outer)[:, ::-1]
    bits = np.array([[corner >> axis & 1 for axis in range(3)] for corner in range(8)])
    corners = np.where(bits, mesh.high, mesh.low)
    found = [np.empty((0, 3, 3))]
    for side, (a, *rest) in _SQUARES.items():
        faces = list_side(mesh, side) if len(opened) else _NONE
        if len(np.intersect1d(faces, opened)):
            found.append(mesh.cut_faces(np.intersect1d(faces, outer))[:, ::-1])
        else:
            found.append(np.array([corners[[d, b, a]] for b, d in itertools.pairwise(rest)]))
    return np.concatenate(found)


def write_surface(triangles: np.ndarray, name: str = "walls") -> Iterator[str]:
    """Lines of a text STL file of `triangles` (n, 3, 3) [m]; every digit is kept."""
    a, b, c = triangles.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    yield f"solid {name}\n"
    for normal, corners in zip(normals.tolist(), triangles.tolist(), strict=True):
        lines = "".join(f"      vertex {x!r} {y!r} {z!r}\n" for x, y, z in corners)
        nx, ny, nz = normal
        yield f"  facet normal {nx!r} {ny!r} {nz!r}\n    outer loop\n{lines}    endloop\n  endfacet\n"
    yield f"endsolid {name}\n"
