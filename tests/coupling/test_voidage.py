"""Every voidage method of the registry: whole particles next to walls too, reads as it writes, anchors of each."""

import math
from typing import get_args

import numpy as np
import pytest

from fbcouple.case.schema.sections import Exchange
from fbcouple.coupling.box.corners import corner_weights
from fbcouple.coupling.box.halo import LocalGrid, find_local_grid
from fbcouple.coupling.box.mapping import VOIDAGE_METHODS, Widths
from fbcouple.coupling.box.stencils import satellites
from fbcouple.errors import DivergedError
from fbcouple.geometry.grid import Grid

RADIUS, BANDWIDTH = 0.012, 0.05
WIDTHS = Widths(RADIUS, BANDWIDTH)
SHAPES = [(6, 5, 7), (5, 1, 6), (1, 2, 3), (1, 1, 1)]

every_method = pytest.mark.parametrize("name", VOIDAGE_METHODS)
every_shape = pytest.mark.parametrize("cells", SHAPES)


def scatter(grid, rng, count=100):
    """Random places in the box, its walls, edges and corners included, and a little beyond."""
    places = np.clip(rng.uniform(-0.3, 1.3, (count, 3)), 0.0, 1.0) * grid.size
    places[:6] += 0.05 * grid.spacing * rng.standard_normal((6, 3))
    return places


def locate(name, local, positions, widths=WIDTHS, radii=None):
    mapping = VOIDAGE_METHODS[name](local, widths)
    mapping.locate(positions, np.full(len(positions), widths.radius) if radii is None else radii)
    return mapping


def write(mapping, values):
    """LocalGrid field after the `values` (n, c) of the particles were written as the kernels of the forces do."""
    base, upper, offsets = mapping.stencil
    field = mapping.local.make_field(values.shape[1])
    field[:] = np.nan
    rows = mapping.open(field)
    for p, value in enumerate(values):
        for weight, offset in zip(corner_weights(*upper[p]), offsets, strict=True):
            rows[base[p] + offset] += weight * value
    mapping.write(rows, field)
    return field


def read(mapping, field):
    """What each particle reads of a local field."""
    base, upper, offsets = mapping.stencil
    rows = mapping.read(field, field.shape[-1])
    return np.array([np.array(corner_weights(*upper[p])) @ rows[base[p] + offsets] for p in range(len(base))])


def test_the_words_of_the_schema_are_the_names_of_the_registry():
    assert set(get_args(Exchange.model_fields["voidage"].annotation)) == set(VOIDAGE_METHODS)


@every_method
@every_shape
def test_a_particle_is_whole_wherever_it_is_and_nothing_is_negative(name, whole, inside, rng, cells):
    local = whole(cells)
    for place in scatter(local.grid, rng, 30):
        field = write(locate(name, local, place[None]), np.ones((1, 1)))
        assert field.min() >= 0.0
        assert inside(field).sum() == pytest.approx(1.0, rel=1e-14)


@every_method
@every_shape
def test_reading_is_the_transpose_of_writing(name, whole, inside, rng, cells):
    local = whole(cells)
    mapping = locate(name, local, scatter(local.grid, rng))
    values, field = rng.standard_normal((100, 4)), local.make_field(4)
    inside(field)[:] = rng.standard_normal(inside(field).shape)
    left, right = np.sum(write(mapping, values) * field), np.sum(values * read(mapping, field))
    assert left == pytest.approx(right, rel=1e-13, abs=1e-13 * np.abs(values).sum())


@every_method
@every_shape
def test_a_constant_reads_as_it_is(name, whole, inside, rng, cells):
    local = whole(cells)
    field = local.make_field(1)
    inside(field)[:] = 0.37
    found = read(locate(name, local, scatter(local.grid, rng)), field)
    assert found == pytest.approx(np.full((100, 1), 0.37), rel=1e-14)


@every_method
def test_a_part_of_the_grid_does_as_the_whole(name, inside, rng):
    """The local grid of a rank's box is wide enough for whatever its particles touch."""
    grid = Grid((30, 20, 24), (0.6, 0.6, 1.2))
    low, high = np.array([0.21, 0.0, 0.4]), np.array([0.25, 0.2, 0.6])
    local = find_local_grid(grid, low, high, 0.01 + VOIDAGE_METHODS[name].find_reach(WIDTHS), 0)
    domain = LocalGrid(grid, (0, 0, 0), grid.cells)
    assert local.low[0] > 0 and local.low[1] == 0 and all(np.less(local.high, grid.cells)), "edges inside the domain"
    positions = rng.uniform(low - 0.01, high + 0.01, (100, 3))
    positions[:, 1] = np.maximum(positions[:, 1], 0.0)
    everywhere = inside(write(locate(name, domain, positions), np.ones((100, 1))))
    here = tuple(slice(a, b) for a, b in zip(local.low, local.high, strict=True))
    mine = inside(write(locate(name, local, positions), np.ones((100, 1))))
    assert mine == pytest.approx(everywhere[here], abs=1e-14)
    assert mine.sum() == pytest.approx(100.0, rel=1e-14)


@every_method
def test_across_periodic_sides_it_goes_on(name, inside, rng):
    """Particles at the ends of a periodic axis write to image cells, which add up to those of the other end."""
    cells, size = (8, 4, 6), (0.24, 0.2, 0.12)
    grid = Grid(cells, size, (True, False, False))
    box = np.zeros(3), np.array(size)
    local = find_local_grid(grid, *box, 0.005 + find_reach(name, WIDTHS), 0)
    assert local.low[0] < 0 and local.high[0] > 8 and local.low[1] == 0
    positions = rng.uniform(*box, (60, 3))
    positions[:20, 0] = rng.choice([-0.004, 0.0011, 0.2393, 0.244], 20)
    field = inside(write(locate(name, local, positions), np.ones((60, 1))))
    found = np.zeros((*cells, 1))
    for layer in range(local.low[0], local.high[0]):
        found[layer % 8] += field[layer - local.low[0]]
    shifted = positions + np.array([3 * 0.03, 0.0, 0.0])
    shifted[:, 0] %= 0.24
    elsewhere = inside(write(locate(name, local, shifted), np.ones((60, 1))))
    moved = np.zeros_like(found)
    for layer in range(local.low[0], local.high[0]):
        moved[(layer - 3) % 8] += elsewhere[layer - local.low[0]]
    assert found.sum() == pytest.approx(60.0, rel=1e-14)
    assert found == pytest.approx(moved, abs=1e-12)


@every_method
def test_counts_may_grow_shrink_and_vanish(name, whole, rng):
    local = whole((5, 4, 6))
    mapping = VOIDAGE_METHODS[name](local, WIDTHS)
    for count in (3, 50, 0, 7):
        positions = scatter(local.grid, rng, max(count, 6))[:count]
        mapping.locate(positions, np.full(count, RADIUS))
        alone = locate(name, local, positions)
        assert (write(mapping, np.ones((count, 2))) == write(alone, np.ones((count, 2)))).all()


@every_method
@pytest.mark.parametrize(
    "place",
    [(-0.011, 0.05, 0.1), (0.05, 0.136, 0.1), (0.05, 0.05, -3.0), (1e9, 0.05, 0.1), (0.05, math.nan, 0.1)],
)
def test_a_particle_that_left_the_box_is_named_by_its_place(name, whole, place):
    with pytest.raises(DivergedError, match="smaller step") as caught:
        locate(name, whole((5, 4, 6)), np.array([[0.05, 0.05, 0.1], place, [0.01, 0.01, 0.01]]))
    assert ", ".join(f"{x:.6g}" for x in place) in str(caught.value)


@every_method
def test_a_particle_in_the_box_but_out_of_the_patch_is_named_too(name):
    grid = Grid((30, 4, 4), (0.3, 0.04, 0.04))
    widths = Widths(0.005, 0.01)
    local = find_local_grid(grid, np.array([0.1, 0.0, 0.0]), np.array([0.2, 0.04, 0.04]), find_reach(name, widths), 0)
    locate(name, local, np.array([[0.1, 0.02, 0.02], [0.2, 0.02, 0.02]]), widths)
    for x in (0.02, 0.27):
        with pytest.raises(DivergedError, match=f"{x:.6g}, 0.02, 0.02"):
            locate(name, local, np.array([[x, 0.02, 0.02]]), widths)


def find_reach(name, widths):
    return VOIDAGE_METHODS[name].find_reach(widths)


def profile(field, inside, axis):
    """Sum of a field (c = 1) over each layer along `axis`."""
    return inside(field)[..., 0].sum(axis=tuple({0, 1, 2} - {axis}))


def moments(local, field, inside, axis):
    """Total, mean and variance of a field along `axis`, each cell at its centre."""
    amount, x = profile(field, inside, axis), local.grid.centres(axis)
    mean = amount @ x / amount.sum()
    return amount.sum(), mean, amount @ (x - mean) ** 2 / amount.sum()


def test_centre_puts_all_into_the_cell_of_the_centre(whole, inside, rng):
    local = whole((6, 5, 7))
    for place in rng.uniform(0.0, 1.0, (30, 3)) * local.grid.size:
        field = inside(write(locate("centre", local, place[None]), np.ones((1, 1))))[..., 0]
        assert field[tuple(local.grid.indices(place[None])[0])] == 1.0 and field.sum() == 1.0


def test_satellites_have_the_second_moment_of_the_sphere():
    """A fifth of the radius squared along each axis, nothing mixed, and no part outside of the sphere."""
    points = satellites()
    assert points.shape == (29, 3)
    assert np.linalg.norm(points, axis=1).max() < 1.0
    assert points.mean(axis=0) == pytest.approx(np.zeros(3), abs=1e-15)
    assert points.T @ points / 29 == pytest.approx(np.eye(3) / 5, abs=1e-15)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("height", np.linspace(0.05, 1.95, 39))
def test_divided_follows_the_cap_that_a_face_cuts_off(whole, inside, axis, height):
    """Part of a sphere beyond a face of the cells: h^2 (3 - h)/4 for a cap of height h radii, within 4.6 %."""
    local = whole((6, 6, 6))
    place = 2.5 * local.grid.spacing
    place[axis] = 3.0 * local.grid.spacing[axis] - (1.0 - height) * RADIUS
    field = write(locate("divided", local, place[None]), np.ones((1, 1)))
    beyond = profile(field, inside, axis)[3:].sum()
    assert beyond == pytest.approx(height**2 * (3.0 - height) / 4.0, abs=0.046)


def test_divided_reflects_what_an_overlap_puts_behind_a_wall(whole, inside):
    local = whole((4, 4, 4))
    place = np.array([[0.0, 0.045, 0.11]])
    field = inside(write(locate("divided", local, place), np.ones((1, 1))))
    assert field[0].sum() == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_gaussian_has_the_prescribed_width(inside, rng, axis):
    """Far from walls the variance is b^2/2, and a cell's own dx^2/12 on top, less the 4e-4 beyond 3 b."""
    cells = (40, 36, 48)
    local = LocalGrid(Grid(cells, (0.8, 0.72, 0.96)), (0, 0, 0), cells)
    for place in np.array(local.grid.size) / 2 + rng.uniform(-0.02, 0.02, (5, 3)):
        field = write(locate("gaussian", local, place[None]), np.ones((1, 1)))
        _, mean, variance = moments(local, field, inside, axis)
        assert mean == pytest.approx(place[axis], abs=1e-3 * 0.02)
        expected = BANDWIDTH**2 / 2 + local.grid.spacing[axis] ** 2 / 12
        assert variance == pytest.approx(expected, rel=1e-3)


def test_gaussian_is_reflected_at_a_wall(inside):
    """Next to a wall the field is that of the particle and of its mirror image behind the wall."""
    cells = (20, 4, 4)
    local = LocalGrid(Grid(cells, (0.4, 0.08, 0.08)), (0, 0, 0), cells)
    x = 0.013
    amount = profile(write(locate("gaussian", local, np.array([[x, 0.04, 0.04]])), np.ones((1, 1))), inside, 0)
    edges = np.arange(21) * 0.02
    integral = np.vectorize(math.erf)((edges[:, None] - [x, -x]) / BANDWIDTH).sum(axis=1) / 2
    assert amount == pytest.approx(np.diff(integral), abs=3e-5)


def test_a_narrow_gaussian_is_the_centre_method(whole, rng):
    local, widths = whole((6, 5, 7)), Widths(RADIUS, 1e-9)
    positions = rng.uniform(0.01, 0.99, (50, 3)) * local.grid.size
    narrow = write(locate("gaussian", local, positions, widths), np.ones((50, 1)))
    assert narrow == pytest.approx(write(locate("centre", local, positions), np.ones((50, 1))), abs=1e-14)
