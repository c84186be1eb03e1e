"""The surface of a mesh as triangles in an STL file, the walls of LIGGGHTS."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fbcouple.geometry.polymesh import PolyMesh


def write_surface(mesh: PolyMesh) -> Iterator[str]:
    """Lines of a text STL file of all patches, normals into the mesh; every digit is kept."""
    triangles = mesh.cut_faces(np.arange(len(mesh.neighbour), len(mesh.owner)))[:, ::-1]
    a, b, c = triangles.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    yield "solid walls\n"
    for normal, corners in zip(normals.tolist(), triangles.tolist(), strict=True):
        lines = "".join(f"      vertex {x!r} {y!r} {z!r}\n" for x, y, z in corners)
        nx, ny, nz = normal
        yield f"  facet normal {nx!r} {ny!r} {nz!r}\n    outer loop\n{lines}    endloop\n  endfacet\n"
    yield "endsolid walls\n"
