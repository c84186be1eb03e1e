"""Trilinear weights: exact for linear fields, the wall's cell up to the wall, and an error for a particle that left."""

import itertools

import numpy as np
import pytest

from fbcouple.coupling.box.corners import Stencil, corner_offsets
from fbcouple.coupling.box.halo import LocalGrid, find_local_grid
from fbcouple.coupling.box.trilinear import Weights
from fbcouple.coupling.kernels import write_volume
from fbcouple.errors import DivergedError
from fbcouple.geometry.grid import Grid

SHAPES = [(5, 4, 6), (5, 1, 6), (1, 1, 1), (2, 3, 1)]


@pytest.fixture
def read(inside):
    """What the particles of `weights` read of `cells` (x, y, z), which is huge in the extra upper layers."""

    def read_values(local, weights, cells):
        field = local.make_field(1)
        field[:] = 1e300
        inside(field)[..., 0] = cells
        place = np.array(np.unravel_index(weights.base, field.shape[:3]))[::-1]
        total = np.zeros(len(weights.base))
        for corner in itertools.product((0, 1), repeat=3):
            i, j, k = place + np.array(corner)[:, None]
            total += np.where(corner, weights.upper, 1.0 - weights.upper).prod(axis=1) * field[k, j, i, 0]
        return total

    return read_values


def scatter(grid, rng, count=200):
    """Random places in the box, its walls, edges and corners included."""
    places = rng.uniform(-0.3, 1.3, (count, 3))
    return np.clip(places, 0.0, 1.0) * grid.size


@pytest.mark.parametrize("cells", SHAPES)
def test_weights_are_the_hat_functions(read, whole, rng, hats, cells):
    local = whole(cells)
    positions, values = scatter(local.grid, rng), rng.standard_normal(cells)
    weights = Weights(local)
    weights.locate(positions)
    expected = np.einsum("pijk,ijk->p", hats(local.grid, positions), values)
    assert read(local, weights, values) == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("cells", SHAPES)
def test_weights_sum_to_one_and_are_not_negative(whole, rng, cells):
    """What the kernels write to the cells: all of the particle, nothing taken from anywhere."""
    local = whole(cells)
    weights = Weights(local)
    radius = np.array([(3 / (4 * np.pi)) ** (1 / 3)])
    for place in scatter(local.grid, rng, 40):
        weights.locate(place[None])
        field = local.make_field(1)
        stencil = Stencil(weights.base, weights.upper, corner_offsets(local))
        write_volume(stencil, radius, field.reshape(-1, 1))
        assert field.min() >= 0.0 and field.sum() == pytest.approx(1.0, abs=1e-15 * 8)
        assert weights.upper.min() >= 0.0 and weights.upper.max() <= 1.0


def test_linear_fields_are_exact_between_the_outermost_centres(read, whole, rng):
    local = whole((5, 4, 6))
    grid = local.grid
    inner = [grid.centres(axis)[[0, -1]] for axis in range(3)]
    positions = np.column_stack([rng.uniform(*ends, 200) for ends in inner])
    positions[:2] = np.transpose(inner)
    x, y, z = np.meshgrid(*map(grid.centres, range(3)), indexing="ij")
    weights = Weights(local)
    weights.locate(positions)
    expected = 3.0 + positions @ [20.0, -7.0, 11.0]
    assert read(local, weights, 3.0 + 20.0 * x - 7.0 * y + 11.0 * z) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("end", [0, -1])
def test_up_to_the_wall_the_walls_cell_holds(read, whole, axis, end):
    local = whole((4, 4, 4))
    grid = local.grid
    wall = np.array([0.0, grid.size[axis]])[end]
    positions = np.tile([grid.centres(other)[1] for other in range(3)], (3, 1))
    positions[:, axis] = np.linspace(grid.centres(axis)[end], wall, 3)
    values = np.moveaxis(np.zeros((4, 4, 4)), axis, 0)
    values[end] = 1.0
    weights = Weights(local)
    weights.locate(positions)
    assert read(local, weights, np.moveaxis(values, 0, axis)) == pytest.approx(np.ones(3), abs=1e-13)


def test_across_a_single_cell_nothing_changes(read, whole, rng):
    local = whole((3, 1, 3))
    positions = scatter(local.grid, rng)
    middle = positions.copy()
    middle[:, 1] = local.grid.centres(1)[0]
    values = rng.standard_normal((3, 1, 3))
    across, centred = Weights(local), Weights(local)
    across.locate(positions)
    centred.locate(middle)
    assert read(local, across, values) == pytest.approx(read(local, centred, values), abs=1e-15)


def test_a_part_of_the_grid_reads_as_the_whole(read, rng, hats):
    grid = Grid((9, 8, 10), (0.09, 0.16, 0.3))
    low, high = np.array([0.031, 0.05, 0.1]), np.array([0.058, 0.16, 0.2])
    local = find_local_grid(grid, low, high, 0.002, 0)
    assert local.low != (0, 0, 0) and local.high != grid.cells
    positions = rng.uniform(low - 0.002, np.minimum(high + 0.002, grid.size), (200, 3))
    values = rng.standard_normal(grid.cells)
    inside = tuple(slice(a, b) for a, b in zip(local.low, local.high, strict=True))
    weights = Weights(local)
    weights.locate(positions)
    expected = np.einsum("pijk,ijk->p", hats(grid, positions), values)
    assert read(local, weights, values[inside]) == pytest.approx(expected, abs=1e-13)


def test_counts_may_grow_shrink_and_vanish(read, whole, rng):
    local = whole((5, 4, 6))
    weights = Weights(local)
    values = rng.standard_normal(local.grid.cells)
    for count in (3, 50, 0, 7):
        positions = scatter(local.grid, rng, count)
        weights.locate(positions)
        alone = Weights(local)
        alone.locate(positions)
        assert weights.base.shape == (count,) and weights.upper.shape == (count, 3)
        assert (read(local, weights, values) == read(local, alone, values)).all()


@pytest.mark.parametrize(
    "place",
    [(-0.011, 0.05, 0.1), (0.05, 0.136, 0.1), (0.05, 0.05, 0.326), (0.05, 0.05, -3.0), (1e9, 0.05, 0.1)],
)
def test_a_particle_that_left_the_box_is_named_by_its_place(whole, place):
    """More than half a cell outside: no overlap of a contact puts a centre there."""
    weights = Weights(whole((5, 4, 6)))
    words = ", ".join(f"{x:.6g}" for x in place)
    with pytest.raises(DivergedError) as caught:
        weights.locate(np.array([[0.05, 0.05, 0.1], place, [0.01, 0.01, 0.01]]))
    assert f"({words}) m" in str(caught.value) and "smaller step" in str(caught.value)


def test_a_particle_in_the_box_but_out_of_the_patch_is_named_too():
    grid = Grid((10, 4, 4), (0.1, 0.04, 0.04))
    weights = Weights(LocalGrid(grid, (3, 0, 0), (7, 4, 4)))
    weights.locate(np.array([[0.0351, 0.02, 0.02], [0.0649, 0.02, 0.02]]))
    for x in (0.0349, 0.0651, 0.005, 0.095):
        with pytest.raises(DivergedError, match=f"{x:.6g}, 0.02, 0.02"):
            weights.locate(np.array([[x, 0.02, 0.02]]))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_place_that_is_no_number_is_an_error(whole, axis, value):
    positions = np.full((2, 3), 0.03)
    positions[1, axis] = value
    with pytest.raises(DivergedError, match=r"nan|inf"):
        Weights(whole((5, 4, 6))).locate(positions)
