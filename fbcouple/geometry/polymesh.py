"""A mesh of polyhedra as OpenFOAM numbers it: faces between cells first, then the faces of each patch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fbcouple.geometry.ragged import Ragged

Patches = dict[str, tuple[int, int]]
_FLAT = 1e-6
"""Part of a face's width by which its points may be off a plane: files hold them with ten digits, or six."""


@dataclass(frozen=True)
class PolyMesh:
    """Points (n, 3) [m], faces as rows of points, the cell that owns each face and, of the inner ones, its neighbour.

    The normal of a face points out of its owner. `patches`: name -> first face and number of faces.
    """

    points: np.ndarray
    faces: Ragged
    owner: np.ndarray
    neighbour: np.ndarray
    patches: Patches

    @property
    def count(self) -> int:
        """Number of cells; the last one may own no face."""
        return int(max(self.owner.max(initial=-1), self.neighbour.max(initial=-1))) + 1

    @property
    def low(self) -> np.ndarray:
        """Lower corner [m] of the box around the mesh, shape (3,)."""
        return self.points.min(axis=0)

    @property
    def high(self) -> np.ndarray:
        """Upper corner [m] of the box around the mesh, shape (3,)."""
        return self.points.max(axis=0)

    def list_patch(self, name: str) -> np.ndarray:
        """Faces of the patch `name`."""
        first, count = self.patches[name]
        return np.arange(first, first + count)

    def cut_faces(self, faces: np.ndarray) -> np.ndarray:
        """Triangles (n, 3, 3) [m] of these faces: a triangle as it is, any other about the mean of its points."""
        return self.list_triangles(faces)[0]

    def list_triangles(self, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The triangles of `cut_faces`, and which of `faces` each is part of, (n,)."""
        rows = self.faces.take(faces)
        corners = self.points[rows.values]
        means = np.add.reduceat(corners, rows.starts[:-1], axis=0) / rows.lengths[:, None]
        face = np.repeat(np.arange(len(faces)), rows.lengths)
        following = np.arange(len(rows.values)) + 1
        following[rows.starts[1:] - 1] = rows.starts[:-1]
        fans = np.stack([means[face], corners, corners[following]], axis=1)
        whole = rows.lengths == 3
        triangles = corners[np.repeat(whole, rows.lengths)].reshape(-1, 3, 3)
        parts = np.concatenate([triangles, fans[~whole[face]]])
        return parts, np.concatenate([np.flatnonzero(whole), face[~whole[face]]])

    def find_vectors(self, faces: np.ndarray) -> np.ndarray:
        """Area vectors (n, 3) [m2] of these faces, out of their owners."""
        rows = self.faces.take(faces)
        corners = self.points[rows.values]
        following = np.arange(len(rows.values)) + 1
        following[rows.starts[1:] - 1] = rows.starts[:-1]
        first = np.repeat(corners[rows.starts[:-1]], rows.lengths, axis=0)
        return 0.5 * np.add.reduceat(np.cross(corners - first, corners[following] - first), rows.starts[:-1], axis=0)

    def find_area(self, name: str) -> float:
        """Area [m2] of the patch `name`: the sum over its faces, also where it is curved."""
        return self.sum_areas(self.list_patch(name))

    def sum_areas(self, faces: np.ndarray) -> float:
        """Area [m2] of `faces` together."""
        return float(np.linalg.norm(self.find_vectors(faces), axis=1).sum())

    @cached_property
    def is_rectilinear(self) -> bool:
        """Are all cells bricks along the axes: six faces, each of four points in a plane across an axis?"""
        faces = np.bincount(self.owner, minlength=self.count) + np.bincount(self.neighbour, minlength=self.count)
        if not (np.all(faces == 6) and np.all(self.faces.lengths == 4)):
            return False
        widths = np.stack([np.ptp(axis[self.faces.values].reshape(-1, 4), axis=1) for axis in self.points.T])
        return bool(np.all(widths.min(axis=0) <= _FLAT * widths.max(axis=0)))

    @property
    def volume(self) -> float:
        """Volume [m3] inside the patches (divergence theorem)."""
        outer = np.arange(len(self.neighbour), len(self.owner))
        a, b, c = (self.cut_faces(outer) - self.low).transpose(1, 0, 2)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
