"""A box of tetrahedra or prisms: every square of the floor cut in two, its cut turned from square to square."""

from __future__ import annotations

import numpy as np

from fbcouple.geometry.extrusion import extrude
from fbcouple.geometry.polymesh import PolyMesh

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
