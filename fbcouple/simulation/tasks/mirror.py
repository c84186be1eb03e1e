"""Samples averaged with their mirror images in the middle planes of a bed that is its own mirror image."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI

AXES = ("x", "y")
VECTORS: dict[str, tuple[int, ...]] = {"solids": (2,), "gas": (1, 4)}
"""Phase -> the first columns of the vectors in its rows: their component across the plane changes its sign."""


class MirrorImages:
    """Which cell of which rank is the image of each of this rank's cells, an axis at a time."""

    def __init__(self, comm: MPI.Comm, cells: tuple[int, int, int], owned: np.ndarray, axes: Sequence[str]) -> None:
        """`owned` (n, 3): index triples of this rank's cells in a box of `cells`; `axes`: those of AXES whose middle
        plane is a mirror (collective)."""
        self._comm, self._axes = comm, [AXES.index(axis) for axis in axes]
        own = _number(owned, cells)
        others = comm.allgather(own)
        self._sent, self._taken = [], []
        for axis in self._axes:
            image = owned.copy()
            image[:, axis] = cells[axis] - 1 - image[:, axis]
            wanted = _number(image, cells)
            # Of each rank the cells whose images are here, and here those whose images are there, in the same order.
            self._sent.append([_find(own, _mirror(numbers, cells, axis)) for numbers in others])
            self._taken.append([np.flatnonzero(np.isin(wanted, numbers)) for numbers in others])

    def average(self, phase: str, rows: np.ndarray) -> np.ndarray:
        """The mean of `rows` (cells, columns) of a phase and those of their images (collective)."""
        for axis, sent, taken in zip(self._axes, self._sent, self._taken, strict=True):
            image = np.empty_like(rows)
            for places, values in zip(taken, self._comm.alltoall([rows[these] for these in sent]), strict=True):
                image[places] = values
            for first in VECTORS.get(phase, ()):
                image[:, first + axis] *= -1.0
            rows = 0.5 * (rows + image)
        return rows


def _number(cells: np.ndarray, shape: tuple[int, int, int]) -> np.ndarray:
    return np.ravel_multi_index(tuple(cells.T), shape)


def _mirror(numbers: np.ndarray, shape: tuple[int, int, int], axis: int) -> np.ndarray:
    cells = list(np.unravel_index(numbers, shape))
    cells[axis] = shape[axis] - 1 - cells[axis]
    return np.ravel_multi_index(tuple(cells), shape)


def _find(own: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Rows of `own` that hold what is `asked` and there, in the order in which it is asked."""
    order = np.argsort(own)
    at = np.minimum(np.searchsorted(own, asked, sorter=order), len(own) - 1)
    return order[at][own[order[at]] == asked] if len(own) else np.empty(0, dtype=np.int64)
