"""Snapshots of the depth-mean voidage: when they are taken and what they hold."""

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.coupling.box.cells import BoxCells
from fbcouple.geometry.grid import Grid
from fbcouple.simulation.tasks.snapshots import Snapshots

GRID = Grid((4, 3, 5), (0.4, 0.3, 0.5))


def shuffle_cells():
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in GRID.cells), indexing="ij"), axis=-1).reshape(-1, 3)
    return np.random.default_rng(5).permutation(cells)


def test_a_snapshot_is_the_mean_over_the_depth_whatever_the_order_of_the_cells():
    owned = shuffle_cells()
    i, j, k = owned.T
    snapshots = Snapshots(MPI.COMM_SELF, BoxCells(GRID, owned), every=0.1)
    snapshots.take(0.4 + 0.01 * i + 0.1 * k + 0.05 * (j - 1), time=0.0)
    ((time, field),) = snapshots.taken
    assert time == 0.0 and field.shape == (5, 4) and field.dtype == np.float32
    assert field == pytest.approx(0.4 + 0.01 * np.arange(4) + 0.1 * np.arange(5)[:, None], rel=1e-6)


def test_snapshots_are_taken_at_the_first_step_after_each_multiple():
    owned = shuffle_cells()
    snapshots = Snapshots(MPI.COMM_SELF, BoxCells(GRID, owned), every=0.1)
    for time in (0.0, 0.06, 0.09, 0.11, 0.13, 0.19, 0.2, 0.45, 0.49):
        snapshots.take(np.full(len(owned), 0.5), time)
    assert [time for time, _ in snapshots.taken] == [0.0, 0.11, 0.2, 0.45]
