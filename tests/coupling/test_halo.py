"""The halo exchange in one process: local grids that hold every stencil, forward and reverse as each other's
transposes."""

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.coupling.box.halo import HaloExchange, LocalGrid, find_local_grid
from fbcouple.coupling.box.trilinear import Weights
from fbcouple.errors import SolverError
from fbcouple.geometry.grid import Grid

GRID = Grid((6, 3, 5), (0.06, 0.06, 0.1))
BLOCK = LocalGrid(GRID, (1, 0, 2), (5, 3, 4))


@pytest.fixture
def owned(rng):
    """All cells of the grid, in an order of their own as OpenFOAM's are."""
    cells = np.stack(np.meshgrid(*map(np.arange, GRID.cells), indexing="ij"), axis=-1).reshape(-1, 3)
    return rng.permutation(cells)


@pytest.fixture(params=[LocalGrid(GRID, (0, 0, 0), GRID.cells), BLOCK], ids=["whole", "block"])
def halo(request, owned):
    return HaloExchange(MPI.COMM_SELF, request.param, owned)


def is_local(local, owned):
    return np.all((owned >= local.low) & (owned < local.high), axis=1)


def test_forward_puts_every_cell_in_its_place(halo, owned, rng, inside):
    cells = rng.standard_normal((len(owned), 2))
    field = halo.local.make_field(2)
    halo.forward(cells, field)
    for cell, value in zip(owned, cells, strict=True):
        place = tuple(cell - halo.local.low)
        if (cell >= halo.local.low).all() and (cell < halo.local.high).all():
            assert (inside(field)[place] == value).all()


def test_forward_leaves_the_extra_upper_layers_alone(halo, owned):
    field = halo.local.make_field(1)
    field[:] = 7.0
    halo.forward(np.zeros((len(owned), 1)), field)
    assert not field[:-1, :-1, :-1].any()
    assert (field[-1] == 7.0).all() and (field[:, -1] == 7.0).all() and (field[:, :, -1] == 7.0).all()


def test_reverse_of_a_forward_is_the_local_cells(halo, owned, rng):
    cells, back = rng.standard_normal((len(owned), 3)), np.full((len(owned), 3), np.nan)
    field = halo.local.make_field(3)
    halo.forward(cells, field)
    halo.reverse(field, back)
    expected = np.where(is_local(halo.local, owned)[:, None], cells, 0.0)
    assert (back == expected).all()


def test_reverse_is_the_transpose_of_forward(halo, owned, rng, inside):
    cells = rng.standard_normal((len(owned), 1))
    field, forwarded = halo.local.make_field(1), halo.local.make_field(1)
    field[:] = rng.standard_normal(field.shape)
    reversed_ = np.empty((len(owned), 1))
    halo.forward(cells, forwarded)
    halo.reverse(field, reversed_)
    assert np.sum(inside(field * forwarded)) == pytest.approx(np.sum(reversed_ * cells), rel=1e-13)


def test_one_process_sends_no_message(halo, owned):
    assert halo.messages == 0 and halo.owned_count == len(owned)


def test_a_cell_that_nobody_owns_is_an_error(owned):
    missing = owned[np.any(owned != BLOCK.low, axis=1)]
    with pytest.raises(SolverError, match="24 cells of its local grid, 23 found"):
        HaloExchange(MPI.COMM_SELF, BLOCK, missing)
    elsewhere = owned[np.any(owned != (0, 0, 0), axis=1)]
    assert HaloExchange(MPI.COMM_SELF, BLOCK, elsewhere).owned_count == GRID.count - 1


def test_a_patch_holds_the_stencils_of_its_particles_and_is_no_larger_than_that(rng):
    for _ in range(200):
        ends = np.sort(rng.random((2, 3)), axis=0) * GRID.size
        reach = rng.uniform(0.0, 0.02)
        local = find_local_grid(GRID, *ends, reach, 0)
        corners = np.clip([ends[0] - reach, ends[1] + reach], 0.0, GRID.size)
        Weights(local).locate(np.vstack([corners, rng.uniform(*corners, (50, 3))]))
        # Stencils lie between the cells half a cell off both ends: one cell more at most on each side.
        first = np.floor((ends[0] - reach) / GRID.spacing - 0.5)
        last = np.floor((ends[1] + reach) / GRID.spacing - 0.5) + 1
        assert (np.array(local.low) == np.clip(first, 0, GRID.cells)).all()
        assert (np.array(local.high) == np.clip(last + 1, 0, GRID.cells)).all()


def test_widening_adds_cells_up_to_the_walls():
    low, high = np.array([0.025, 0.03, 0.05]), np.array([0.034, 0.03, 0.05])
    narrow, wide = find_local_grid(GRID, low, high, 0.0, 0), find_local_grid(GRID, low, high, 0.0, 1)
    assert (narrow.low, narrow.high) == ((2, 1, 2), (4, 3, 4))
    assert (wide.low, wide.high) == ((1, 0, 1), (5, 3, 5))
    widest = find_local_grid(GRID, low, high, 0.0, 20)
    assert (widest.low, widest.high) == ((0, 0, 0), GRID.cells)
