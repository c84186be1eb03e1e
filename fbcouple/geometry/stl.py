"""The surface of a mesh as triangles in an STL file, the walls of LIGGGHTS."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from fbcouple.geometry.polymesh import PolyMesh

ALIKE = 1e-9
"""Part of the box around a mesh that may be missing in one that fills it: rounding."""
_SQUARES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
"""Sides of a box by its corners, whose bits are x, y and z: anticlockwise from outside."""


def list_walls(mesh: PolyMesh) -> np.ndarray:
    """The triangles (n, 3, 3) [m] of all patches, anticlockwise from inside; of a mesh that fills the box around it the
    twelve of the box: contacts with many small ones cost several times as much."""
    if abs(mesh.volume / float(np.prod(mesh.high - mesh.low)) - 1.0) > ALIKE:
        return mesh.cut_faces(np.arange(len(mesh.neighbour), len(mesh.owner)))[:, ::-1]
    bits = np.array([[corner >> axis & 1 for axis in range(3)] for corner in range(8)])
    corners = np.where(bits, mesh.high, mesh.low)
    return np.array([corners[[d, b, a]] for a, *rest in _SQUARES for b, d in itertools.pairwise(rest)])


def write_surface(mesh: PolyMesh) -> Iterator[str]:
    """Lines of a text STL file of the walls, normals into the mesh; every digit is kept."""
    triangles = list_walls(mesh)
    a, b, c = triangles.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    yield "solid walls\n"
    for normal, corners in zip(normals.tolist(), triangles.tolist(), strict=True):
        lines = "".join(f"      vertex {x!r} {y!r} {z!r}\n" for x, y, z in corners)
        nx, ny, nz = normal
        yield f"  facet normal {nx!r} {ny!r} {nz!r}\n    outer loop\n{lines}    endloop\n  endfacet\n"
    yield "endsolid walls\n"
