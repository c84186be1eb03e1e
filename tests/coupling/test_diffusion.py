"""The diffusion against its matrix and against a Gaussian, and what it keeps: constants, totals, symmetry, variance."""

import math

import numpy as np
import pytest

from fbcouple.coupling.box.diffusion import STEPS, UNSEEN, Diffusion, find_margin
from fbcouple.coupling.box.halo import LocalGrid, find_local_grid
from fbcouple.geometry.grid import Grid

SHAPES = [(7, 5, 6), (4, 1, 5), (2, 2, 2), (1, 1, 1)]
WIDTHS = [0.005, 0.05, 0.3]

every_shape = pytest.mark.parametrize("cells", SHAPES)
every_width = pytest.mark.parametrize("bandwidth", WIDTHS)


@pytest.fixture
def smooth(inside):
    """Smooth `values` (x, y, z, c); the extra upper layers, which are nobody's, hold nan."""

    def smooth_values(local, values, bandwidth):
        field = local.make_field(values.shape[-1])
        field[:] = np.nan
        inside(field)[:] = values
        Diffusion(local, bandwidth).smooth(field)
        return inside(field)

    return smooth_values


def matrix(n, spacing, bandwidth):
    """Backward Euler steps of du/dt = u'' over b^2/4 with no flux through walls, on n cells."""
    flux = np.diff(np.eye(n), axis=0)
    implicit = np.eye(n) + bandwidth**2 / 4 / STEPS / spacing**2 * flux.T @ flux
    return np.linalg.matrix_power(np.linalg.inv(implicit), STEPS)


@every_width
@every_shape
def test_is_the_product_of_the_three_matrices(smooth, whole, rng, cells, bandwidth):
    local, values = whole(cells), rng.standard_normal((*cells, 2))
    axes = [matrix(n, edge, bandwidth) for n, edge in zip(cells, local.grid.spacing, strict=True)]
    expected = np.einsum("ia,jb,kc,abcm->ijkm", *axes, values)
    assert smooth(local, values, bandwidth) == pytest.approx(expected, abs=1e-12)


@every_width
@every_shape
def test_a_constant_stays_next_to_walls_too(smooth, whole, cells, bandwidth):
    values = np.full((*cells, 1), 0.37)
    assert smooth(whole(cells), values, bandwidth) == pytest.approx(values, rel=1e-12)


@every_width
@every_shape
def test_the_total_stays(smooth, whole, rng, cells, bandwidth):
    values = rng.random((*cells, 3))
    after = smooth(whole(cells), values, bandwidth)
    assert after.sum(axis=(0, 1, 2)) == pytest.approx(values.sum(axis=(0, 1, 2)), rel=1e-13)
    assert after.min() > 0.0


@every_width
@every_shape
def test_is_symmetric(smooth, whole, rng, cells, bandwidth):
    local, a, b = whole(cells), rng.standard_normal((*cells, 1)), rng.standard_normal((*cells, 1))
    left, right = np.sum(a * smooth(local, b, bandwidth)), np.sum(smooth(local, a, bandwidth) * b)
    assert left == pytest.approx(right, abs=1e-13 * np.abs(a).sum())


@pytest.mark.parametrize("layers", [2, 4])
def test_the_lowest_layers_alone_are_a_patch_of_their_own(whole, rng, layers):
    """What lies above the top of the bed may be left out; the cut reflects."""
    local, part = (
        whole((4, 3, 6)),
        LocalGrid(Grid((4, 3, layers), (0.08, 0.09, 0.05 * layers)), (0, 0, 0), (4, 3, layers)),
    )
    field = rng.random(local.make_field(2).shape)
    alone = np.concatenate([field[:layers], np.full_like(field[:1], np.nan)])
    Diffusion(local, 0.05).smooth(field[: layers + 1])
    Diffusion(part, 0.05).smooth(alone)
    assert field[:layers, :-1, :-1] == pytest.approx(alone[:layers, :-1, :-1], rel=1e-13)


def spread_from_the_middle(smooth, n, bandwidth, axis):
    """What one cell in the middle of n along `axis` is spread to, and the cell size."""
    cells = tuple(n if other == axis else 3 for other in range(3))
    edges = (0.02, 0.03, 0.05)
    local = LocalGrid(Grid(cells, tuple(m * edge for m, edge in zip(cells, edges, strict=True))), (0, 0, 0), cells)
    values = np.zeros((*cells, 1))
    values[tuple(m // 2 for m in cells)] = 1.0
    smoothed = smooth(local, values, bandwidth)
    return smoothed.sum(axis=tuple({0, 1, 2, 3} - {axis})), edges[axis]


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("bandwidth", [0.01, 0.05, 0.2])
def test_adds_half_the_bandwidth_squared_of_variance_along_each_axis(smooth, axis, bandwidth):
    profile, edge = spread_from_the_middle(smooth, 301, bandwidth, axis)
    x = (np.arange(301) - 150) * edge
    assert profile @ x == pytest.approx(0.0, abs=1e-15)
    assert profile @ x**2 == pytest.approx(bandwidth**2 / 2, rel=1e-11)


def test_is_close_to_the_gaussian_of_its_bandwidth(smooth):
    bandwidth = 0.12
    profile, edge = spread_from_the_middle(smooth, 101, bandwidth, 0)
    edges = (np.arange(102) - 50.5) * edge
    gaussian = np.diff(np.vectorize(math.erf)(edges / bandwidth)) / 2
    assert np.abs(profile - gaussian).sum() == pytest.approx(0.064, abs=0.002)


def test_components_do_not_mix(smooth, whole):
    values = np.zeros((5, 5, 5, 2))
    values[2, 2, 2, 1] = 1.0
    smoothed = smooth(whole((5, 5, 5)), values, 0.05)
    assert not smoothed[..., 0].any() and smoothed[2, 2, 2, 1] < 0.5


def test_a_widened_patch_diffuses_as_the_whole_grid_does(smooth, rng):
    """What a local grid does not see of the diffusion is less than `UNSEEN`, written or read."""
    grid = Grid((60, 40, 50), (0.6, 0.4, 0.5))
    low, high, bandwidth = np.array([0.261, 0.0, 0.252]), np.array([0.283, 0.041, 0.27]), 0.02
    margin = find_margin(grid.spacing, bandwidth)
    box, domain = find_local_grid(grid, low, high, 0.0, 0), LocalGrid(grid, (0, 0, 0), grid.cells)
    local = find_local_grid(grid, low, high, 0.0, margin)
    assert local.low[0] > 0 and local.low[1] == 0 and all(np.less(local.high, grid.cells)), "edges inside the domain"
    here = tuple(slice(a, b) for a, b in zip(local.low, local.high, strict=True))
    stencils = tuple(slice(a, b) for a, b in zip(box.low, box.high, strict=True))
    inner = tuple(slice(a - p, b - p) for a, b, p in zip(box.low, box.high, local.low, strict=True))

    written = np.zeros((*grid.cells, 1))
    written[stencils] = rng.random(written[stencils].shape)
    everywhere = smooth(domain, written, bandwidth)
    mine = np.zeros_like(everywhere)
    mine[here] = smooth(local, written[here], bandwidth)
    assert mine.sum() == pytest.approx(written.sum(), rel=1e-13)
    assert np.abs(mine - everywhere).sum() < 3 * UNSEEN * written.sum()
    narrow = find_local_grid(grid, low, high, 0.0, margin // 2)
    part = tuple(slice(a, b) for a, b in zip(narrow.low, narrow.high, strict=True))
    mine[:] = 0.0
    mine[part] = smooth(narrow, written[part], bandwidth)
    assert np.abs(mine - everywhere).sum() > 1e3 * UNSEEN * written.sum(), "half the margin is too little"

    read = rng.standard_normal((*grid.cells, 1))
    found, expected = smooth(local, read[here], bandwidth)[inner], smooth(domain, read, bandwidth)[stencils]
    assert found == pytest.approx(expected, abs=30 * UNSEEN)


def test_no_bandwidth_needs_no_margin():
    assert (find_margin(np.array([0.02, 0.03, 0.05]), 0.0) == 0).all()
