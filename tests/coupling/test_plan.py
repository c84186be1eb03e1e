"""The exchange plan in one process: patches that hold every stencil, fetch and deposit as each other's transposes."""

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.coupling.box.halo import Patch, Plan, find_patch
from fbcouple.coupling.box.trilinear import Weights
from fbcouple.errors import SolverError
from fbcouple.geometry.grid import Grid

GRID = Grid((6, 3, 5), (0.06, 0.06, 0.1))
BLOCK = Patch(GRID, (1, 0, 2), (5, 3, 4))


@pytest.fixture
def owned(rng):
    """All cells of the grid, in an order of their own as OpenFOAM's are."""
    cells = np.stack(np.meshgrid(*map(np.arange, GRID.cells), indexing="ij"), axis=-1).reshape(-1, 3)
    return rng.permutation(cells)


@pytest.fixture(params=[Patch(GRID, (0, 0, 0), GRID.cells), BLOCK], ids=["whole", "block"])
def plan(request, owned):
    return Plan(MPI.COMM_SELF, request.param, owned)


def in_patch(patch, owned):
    return np.all((owned >= patch.low) & (owned < patch.high), axis=1)


def test_fetch_puts_every_cell_in_its_place(plan, owned, rng, inside):
    cells = rng.standard_normal((len(owned), 2))
    field = plan.patch.make_field(2)
    plan.fetch(cells, field)
    for cell, value in zip(owned, cells, strict=True):
        place = tuple(cell - plan.patch.low)
        if (cell >= plan.patch.low).all() and (cell < plan.patch.high).all():
            assert (inside(field)[place] == value).all()


def test_fetch_leaves_the_extra_upper_layers_alone(plan, owned):
    field = plan.patch.make_field(1)
    field[:] = 7.0
    plan.fetch(np.zeros((len(owned), 1)), field)
    assert not field[:-1, :-1, :-1].any()
    assert (field[-1] == 7.0).all() and (field[:, -1] == 7.0).all() and (field[:, :, -1] == 7.0).all()


def test_deposit_of_a_fetch_is_the_patchs_cells(plan, owned, rng):
    cells, back = rng.standard_normal((len(owned), 3)), np.full((len(owned), 3), np.nan)
    field = plan.patch.make_field(3)
    plan.fetch(cells, field)
    plan.deposit(field, back)
    expected = np.where(in_patch(plan.patch, owned)[:, None], cells, 0.0)
    assert (back == expected).all()


def test_deposit_is_the_transpose_of_fetch(plan, owned, rng, inside):
    cells = rng.standard_normal((len(owned), 1))
    field, fetched = plan.patch.make_field(1), plan.patch.make_field(1)
    field[:] = rng.standard_normal(field.shape)
    deposited = np.empty((len(owned), 1))
    plan.fetch(cells, fetched)
    plan.deposit(field, deposited)
    assert np.sum(inside(field * fetched)) == pytest.approx(np.sum(deposited * cells), rel=1e-13)


def test_one_process_sends_no_message(plan, owned):
    assert plan.messages == 0 and plan.owned_count == len(owned)


def test_a_cell_that_nobody_owns_is_an_error(owned):
    missing = owned[np.any(owned != BLOCK.low, axis=1)]
    with pytest.raises(SolverError, match="24 cells of its patch, 23 found"):
        Plan(MPI.COMM_SELF, BLOCK, missing)
    elsewhere = owned[np.any(owned != (0, 0, 0), axis=1)]
    assert Plan(MPI.COMM_SELF, BLOCK, elsewhere).owned_count == GRID.count - 1


def test_a_patch_holds_the_stencils_of_its_particles_and_is_no_larger_than_that(rng):
    for _ in range(200):
        ends = np.sort(rng.random((2, 3)), axis=0) * GRID.size
        reach = rng.uniform(0.0, 0.02)
        patch = find_patch(GRID, *ends, reach, 0)
        corners = np.clip([ends[0] - reach, ends[1] + reach], 0.0, GRID.size)
        Weights(patch).locate(np.vstack([corners, rng.uniform(*corners, (50, 3))]))
        # Stencils lie between the cells half a cell off both ends: one cell more at most on each side.
        first = np.floor((ends[0] - reach) / GRID.spacing - 0.5)
        last = np.floor((ends[1] + reach) / GRID.spacing - 0.5) + 1
        assert (np.array(patch.low) == np.clip(first, 0, GRID.cells)).all()
        assert (np.array(patch.high) == np.clip(last + 1, 0, GRID.cells)).all()


def test_widening_adds_cells_up_to_the_walls():
    low, high = np.array([0.025, 0.03, 0.05]), np.array([0.034, 0.03, 0.05])
    narrow, wide = find_patch(GRID, low, high, 0.0, 0), find_patch(GRID, low, high, 0.0, 1)
    assert (narrow.low, narrow.high) == ((2, 1, 2), (4, 3, 4))
    assert (wide.low, wide.high) == ((1, 0, 1), (5, 3, 5))
    widest = find_patch(GRID, low, high, 0.0, 20)
    assert (widest.low, widest.high) == ((0, 0, 0), GRID.cells)
