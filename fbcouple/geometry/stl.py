"""Surfaces of triangles in STL files, the walls of LIGGGHTS: those of a mesh, and plates."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from fbcouple.geometry.baffles import pair_faces
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.sides import list_side

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
    """The triangles (n, 3, 3) [m] of all outer faces but for the `opened` ones, anticlockwise from inside; of the two
    faces of a baffle one, which is a wall from both sides. Of a mesh that fills the box around it two for each side
    that is whole: contacts with many small ones cost several times as much."""
    pairs = pair_faces(mesh)
    outer = np.arange(len(mesh.neighbour), len(mesh.owner))
    wall = np.setdiff1d(outer, opened)
    wall = np.setdiff1d(wall, pairs[np.isin(pairs, wall).all(axis=1), 1])
    sides = {side: list_side(mesh, side) for side in _SQUARES}
    if len(np.setdiff1d(outer, np.concatenate([*sides.values(), pairs.ravel()]))):
        return mesh.cut_faces(wall)[:, ::-1]
    whole = [side for side, faces in sides.items() if not len(np.intersect1d(faces, opened))]
    left = np.setdiff1d(wall, np.concatenate([_NONE, *(sides[side] for side in whole)]))
    return np.concatenate([*(_halve(mesh, side) for side in whole), mesh.cut_faces(left)[:, ::-1]])


def _halve(mesh: PolyMesh, side: str) -> np.ndarray:
    """The two triangles (2, 3, 3) [m] of a side of the box around the mesh, anticlockwise from inside."""
    bits = np.array([[corner >> axis & 1 for axis in range(3)] for corner in range(8)])
    corners = np.where(bits, mesh.high, mesh.low)
    a, *rest = _SQUARES[side]
    return np.array([corners[[d, b, a]] for b, d in itertools.pairwise(rest)])


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
