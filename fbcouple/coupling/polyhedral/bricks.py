"""A mesh from a file may be a plain box of equal hexahedra: then the coupling is the box's own, at a box's cost."""

from __future__ import annotations

import math

import numpy as np
from mpi4py import MPI

from fbcouple.geometry.grid import Grid
from fbcouple.geometry.polyhedra import Polyhedra

ALIKE = 1e-6
"""Part of a cell's edge by which points of such a mesh may be off: files hold them with ten digits, or six."""


def find_grid(comm: MPI.Comm, cells: Polyhedra, volumes: np.ndarray) -> Grid | None:
    """The grid whose cells the `cells` of all ranks are, of `volumes` (n,) [m3]; None if they are those of no box
    along the axes (collective).

    A cell that is as large as the box around it fills it; where all are of one size, each in a place of the grid, and
    as many as it has, there is no other mesh, but for walls without thickness in it: these have points of their own on
    either side, more than the grid has.
    """
    bottom, top = cells.find_bounds() if len(cells) else (np.empty((0, 3)), np.empty((0, 3)))
    low, high = np.full(3, math.inf), np.full(3, -math.inf)
    comm.Allreduce(bottom.min(axis=0, initial=math.inf), low, MPI.MIN)
    comm.Allreduce(top.max(axis=0, initial=-math.inf), high, MPI.MAX)
    edges = top - bottom
    count, spacing = comm.allreduce(len(cells)), comm.allreduce(edges.sum(axis=0))
    spacing = spacing / count
    numbers = np.maximum(np.rint((high - low) / spacing), 1.0)
    spacing = (high - low) / numbers
    offsets = (bottom - low) / spacing
    fits = (
        math.prod(numbers.tolist()) == count
        and bool(np.all(np.abs(edges / spacing - 1.0) <= ALIKE))
        and bool(np.all(np.abs(offsets - np.rint(offsets)) <= ALIKE))
        and bool(np.all(np.abs(volumes / spacing.prod() - 1.0) <= 3.0 * ALIKE))
    )
    if not comm.allreduce(fits, MPI.LAND) or _count_points(comm, cells) != math.prod((numbers + 1.0).tolist()):
        return None
    nx, ny, nz = (int(number) for number in numbers)
    width, depth, height = (high - low).tolist()
    x, y, z = low.tolist()
    return Grid((nx, ny, nz), (width, depth, height), origin=(x, y, z))


def _count_points(comm: MPI.Comm, cells: Polyhedra) -> int:
    """Points of the cells of all ranks, each counted once (collective)."""
    used = np.zeros(comm.allreduce(int(cells.point_ids.max(initial=-1)), MPI.MAX) + 1, np.int8)
    used[cells.point_ids] = 1
    comm.Allreduce(MPI.IN_PLACE, used, MPI.MAX)
    return int(used.sum(dtype=np.int64))
