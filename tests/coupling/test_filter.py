"""The filter against eq. 33 as a matrix, and what it keeps: constants, totals, symmetry, variance."""

import numpy as np
import pytest

from fbcouple.coupling.box.filter import filtered
from fbcouple.coupling.box.halo import LocalGrid, find_local_grid
from fbcouple.geometry.grid import Grid

SHAPES = [(7, 5, 6), (4, 1, 5), (2, 2, 2), (1, 1, 1)]


@pytest.fixture
def apply(inside):
    """Filter `values` (x, y, z, c); the extra upper layers, which are nobody's, hold nan."""

    def filter_values(local, values, passes=1):
        field = local.make_field(values.shape[-1])
        field[:] = np.nan
        inside(field)[:] = values
        return inside(filtered(field, passes, local.make_field(values.shape[-1])))

    return filter_values


def matrix(n):
    """Eq. 33 along one axis: (1/4, 1/2, 1/4), the quarter that would leave through a wall stays in the wall's cell."""
    rows = 0.5 * np.eye(n) + 0.25 * (np.eye(n, k=1) + np.eye(n, k=-1))
    rows[0, 0] += 0.25
    rows[-1, -1] += 0.25
    return rows


@pytest.mark.parametrize("passes", [0, 1, 2, 5])
@pytest.mark.parametrize("cells", SHAPES)
def test_is_the_product_of_the_three_matrices(apply, whole, rng, cells, passes):
    values = rng.standard_normal((*cells, 2))
    powers = [np.linalg.matrix_power(matrix(n), passes) for n in cells]
    expected = np.einsum("ia,jb,kc,abcm->ijkm", *powers, values)
    assert apply(whole(cells), values, passes) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("cells", SHAPES)
def test_a_constant_stays_next_to_walls_too(apply, whole, cells):
    values = np.full((*cells, 1), 0.37)
    assert apply(whole(cells), values, 3) == pytest.approx(values, rel=1e-15)


@pytest.mark.parametrize("passes", [1, 4])
@pytest.mark.parametrize("cells", SHAPES)
def test_the_total_stays(apply, whole, rng, cells, passes):
    """Eq. 34: the solids volume of the bed is the same before and after."""
    values = rng.random((*cells, 3))
    before = values.sum(axis=(0, 1, 2))
    assert apply(whole(cells), values, passes).sum(axis=(0, 1, 2)) == pytest.approx(before, rel=1e-12)


@pytest.mark.parametrize("passes", [1, 2, 3])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_each_pass_adds_half_a_cell_squared_of_variance_along_each_axis(apply, whole, passes, axis):
    local = whole((9, 9, 9))
    values = np.zeros((9, 9, 9, 1))
    values[4, 4, 4] = 1.0
    profile = apply(local, values, passes).sum(axis=tuple({0, 1, 2, 3} - {axis}))
    x = local.grid.centres(axis)
    mean = profile @ x
    assert mean == pytest.approx(x[4], rel=1e-14)
    assert profile @ (x - mean) ** 2 == pytest.approx(0.5 * passes * local.grid.spacing[axis] ** 2, rel=1e-12)


@pytest.mark.parametrize("cells", SHAPES)
def test_is_symmetric(apply, whole, rng, cells):
    """<a, F b> = <F a, b>: reading through the filter is the transpose of writing through it."""
    local, a, b = whole(cells), rng.standard_normal((*cells, 1)), rng.standard_normal((*cells, 1))
    left, right = np.sum(a * apply(local, b, 2)), np.sum(apply(local, a, 2) * b)
    assert left == pytest.approx(right, abs=1e-13 * np.abs(a).sum())


def test_components_do_not_mix(apply, whole):
    values = np.zeros((5, 5, 5, 2))
    values[2, 2, 2, 1] = 1.0
    filtered = apply(whole((5, 5, 5)), values)
    assert not filtered[..., 0].any() and filtered[2, 2, 2, 1] == 0.125


@pytest.mark.parametrize("passes", [1, 2, 3])
def test_a_widened_patch_filters_as_the_whole_grid_does(apply, rng, passes):
    """The edges of a local grid inside the domain reflect wrongly, `passes` cells deep: what is written for the
    particles' box comes out right everywhere, what is read is right where their stencils are."""
    grid = Grid((16, 12, 14), (0.16, 0.12, 0.14))
    low, high = np.array([0.061, 0.0, 0.052]), np.array([0.083, 0.041, 0.07])
    box, domain = find_local_grid(grid, low, high, 0.0, 0), LocalGrid(grid, (0, 0, 0), grid.cells)
    local = find_local_grid(grid, low, high, 0.0, passes)
    assert local.low[0] > 0 and local.low[1] == 0 and all(np.less(local.high, grid.cells)), "edges inside the domain"
    here = tuple(slice(a, b) for a, b in zip(local.low, local.high, strict=True))
    stencils = tuple(slice(a, b) for a, b in zip(box.low, box.high, strict=True))
    inner = tuple(
        slice(a - p, b - p) for a, b, p in zip(box.low, box.high, local.low, strict=True)
    )  # the stencils' cells, counted from the local grid's first

    written = np.zeros((*grid.cells, 1))
    written[stencils] = rng.random(written[stencils].shape)
    everywhere = apply(domain, written, passes)
    mine = np.zeros_like(everywhere)
    mine[here] = apply(local, written[here], passes)
    assert mine == pytest.approx(everywhere, abs=1e-15)

    read = rng.standard_normal((*grid.cells, 1))
    assert apply(local, read[here], passes)[inner] == pytest.approx(apply(domain, read, passes)[stencils], abs=1e-15)
