"""A box of hexahedra, or of tetrahedra or prisms: every square of the floor cut in two, its cut turned from square to
square."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from fbcouple.geometry.extrusion import PATCHES, extrude
from fbcouple.geometry.numbering import build_mesh
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.ragged import pile_up

PER_SQUARE = 2


def make_block(size: tuple[float, float, float], cells: tuple[int, int, int], elements: str) -> PolyMesh:
    """A box from the origin to `size` [m], each of its `cells` cut into two "prisms" or six "tetrahedra"."""
    nx, ny, layers = cells
    y, x = (axis.ravel() for axis in np.meshgrid(np.arange(ny + 1), np.arange(nx + 1), indexing="ij"))
    flat = np.column_stack([size[0] / nx * x, size[1] / ny * y])
    j, i = (axis.ravel() for axis in np.meshgrid(np.arange(ny), np.arange(nx), indexing="ij"))
    low, right = j * (nx + 1) + i, j * (nx + 1) + i + 1
    left, far = low + nx + 1, right + nx + 1
    turned = ((i + j) % 2 == 1)[:, None]
    one = np.where(turned, np.column_stack([low, right, left]), np.column_stack([low, right, far]))
    other = np.where(turned, np.column_stack([right, far, left]), np.column_stack([low, far, left]))
    return extrude(flat, np.concatenate([one, other]), size[2], layers, elements)


CYCLIC = {"x": ("xlo", "xhi"), "y": ("ylo", "yhi")}
"""Patches at the low and the high end of an axis along which the box repeats itself."""


def list_cyclic(periodic: Collection[str]) -> list[tuple[str, str]]:
    """The pairs of cyclic patches of a box that repeats itself along the axes `periodic`."""
    return [pair for axis, pair in CYCLIC.items() if axis in periodic]


def make_hexahedra(
    size: tuple[float, float, float], cells: tuple[int, int, int], periodic: Collection[str] = ()
) -> PolyMesh:
    """The box as blockMesh makes it: cells numbered along x, then y, then z, with the patches inlet (floor), outlet
    (top), walls, and two for each axis of `periodic`."""
    nodes = [np.arange(count + 1) for count in cells]
    z, y, x = (axis.ravel() for axis in np.meshgrid(*reversed(nodes), indexing="ij"))
    points = np.column_stack([x, y, z]) * (np.array(size) / cells)
    k, j, i = (axis.ravel() for axis in np.meshgrid(*(np.arange(n) for n in reversed(cells)), indexing="ij"))
    right, far, up = 1, cells[0] + 1, (cells[0] + 1) * (cells[1] + 1)
    low = i + far * j + up * k
    square = np.stack([low, low + right, low + right + far, low + far], axis=1)
    corners = np.concatenate([square, square + up], axis=1)
    pairs = list_cyclic(periodic)
    kept = [name for pair in pairs for name in pair]
    index = np.column_stack([x, y, z])

    def name(rows: np.ndarray) -> np.ndarray:
        grid_indices = index[rows]
        which = np.full(len(rows), 2)
        for number, (axis, end) in enumerate([(2, 0), (2, cells[2])]):
            which[np.all(grid_indices[:, :, axis] == end, axis=1)] = number
        for number, word in enumerate(kept, start=len(PATCHES)):
            axis = "xy".index(word[0])
            which[np.all(grid_indices[:, :, axis] == (0 if word[1:] == "lo" else cells[axis]), axis=1)] = number
        return which

    mesh = build_mesh(points, [("hexahedron", corners)], (*PATCHES, *kept), name)
    return _line_up(mesh, [high for _, high in pairs])


def _line_up(mesh: PolyMesh, high: list[str]) -> PolyMesh:
    """The mesh with the faces of the patches `high` starting at the point across from where their partners start."""
    rows = mesh.faces.values.reshape(-1, 4).copy()
    for name in high:
        first, count = mesh.patches[name]
        rows[first : first + count] = np.roll(rows[first : first + count], -1, axis=1)
    return replace(mesh, faces=pile_up(mesh.faces.lengths, rows.ravel()))
