"""Time means and their block errors against NumPy on whole series, and against loops over random particles."""

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.coupling.box.halo import HaloExchange, LocalGrid
from fbcouple.geometry.grid import Grid
from fbcouple.simulation.tasks.means import GAS_COLUMNS, SOLIDS_COLUMNS, Means
from fbcouple.simulation.tasks.samplers import SolidsSampler, sample_gas

GLASS = 2500.0
GRID = Grid((3, 2, 4), (0.03, 0.04, 0.08))
CELLS = np.stack(np.meshgrid(*map(np.arange, GRID.cells), indexing="ij"), axis=-1).reshape(-1, 3)


@pytest.fixture
def rng():
    return np.random.default_rng(42)


@pytest.fixture
def owned(rng):
    return rng.permutation(CELLS)


@pytest.fixture
def sampler(owned):
    return SolidsSampler(HaloExchange(MPI.COMM_SELF, LocalGrid(GRID, (0, 0, 0), GRID.cells), owned))


def make_gas(rng, samples, cells=5):
    return rng.random((samples, cells)), rng.standard_normal((samples, cells, 3)), rng.standard_normal((samples, cells))


def test_means_of_the_gas_are_numpys(rng):
    means = Means("gas", 5, (1.0, 3.0), 4)
    voidage, velocity, pressure = make_gas(rng, 40)
    for n in range(40):
        means.add(sample_gas(voidage[n], velocity[n], pressure[n]), 1.0 + 0.05 * (n + 0.5))
    found = {name: mean for name, (mean, _) in means.collect(final=False).items()}
    assert means.samples == 40
    assert found["voidage"][:, 0] == pytest.approx(voidage.mean(axis=0), rel=1e-13)
    assert found["gas_velocity"] == pytest.approx(velocity.mean(axis=0), rel=1e-12)
    assert found["gas_flux"] == pytest.approx((voidage[..., None] * velocity).mean(axis=0), rel=1e-12)
    assert found["pressure"][:, 0] == pytest.approx(pressure.mean(axis=0), rel=1e-12)


@pytest.mark.parametrize("per_block", [1, 7])
def test_standard_error_is_that_of_the_full_blocks(rng, per_block):
    """Of six blocks five are full; the samples of the sixth count for the mean, not for its error."""
    blocks, window = 6, (0.5, 3.5)
    width = (window[1] - window[0]) / blocks
    full, part = 5 * per_block, per_block // 2
    voidage, velocity, pressure = make_gas(rng, full + part)
    means = Means("gas", 5, window, blocks)
    for n in range(full + part):
        block, within = divmod(n, per_block)
        means.add(sample_gas(voidage[n], velocity[n], pressure[n]), 0.5 + width * (block + (within + 0.5) / per_block))
    if part == 0:
        means.add(np.zeros((5, GAS_COLUMNS)), 3.2)
    errors = {name: error for name, (_, error) in means.collect(final=False).items()}
    for name, series in (
        ("voidage", voidage[..., None]),
        ("gas_velocity", velocity),
        ("gas_flux", voidage[..., None] * velocity),
        ("pressure", pressure[..., None]),
    ):
        of_blocks = series[:full].reshape(5, per_block, *series.shape[1:]).mean(axis=1)
        expected = of_blocks.std(axis=0, ddof=1) / np.sqrt(5)
        assert errors[name] == pytest.approx(expected, rel=1e-9), name


def test_the_last_sample_of_the_window_belongs_to_the_last_block(rng):
    """Samples at the start and at the end of each block: four blocks, no fifth of one sample."""
    voidage, velocity, pressure = make_gas(rng, 5)
    means = Means("gas", 5, (1.0, 3.0), 4)
    for n, time in enumerate((1.0, 1.5, 2.0, 2.5, 3.0 + 1e-12)):
        means.add(sample_gas(voidage[n], velocity[n], pressure[n]), time)
    of_blocks = np.array([pressure[:2].mean(axis=0), *pressure[2:]])
    expected = of_blocks.std(axis=0, ddof=1) / np.sqrt(4)
    assert means.collect(final=True)["pressure"][1][:, 0] == pytest.approx(expected, rel=1e-9)


def test_blocks_keep_their_length_where_the_window_grows(rng):
    """Four blocks of a window, and four more of the same length in one twice as long."""
    voidage, velocity, pressure = make_gas(rng, 8)
    short, long = Means("gas", 5, (1.0, 3.0), 4), Means("gas", 5, (1.0, 5.0), 4)
    for n in range(8):
        if n == 4:
            short.collect(final=True)
            counts, sums = short.save()
            long.load(counts, {name: rows.copy() for name, rows in sums.items()})
        means = short if n < 4 else long
        means.add(sample_gas(voidage[n], velocity[n], pressure[n]), 1.5 + 0.5 * n)
    mean, error = long.collect(final=True)["pressure"]
    assert long.samples == 8 and mean[:, 0] == pytest.approx(pressure.mean(axis=0), rel=1e-12)
    assert error[:, 0] == pytest.approx(pressure.std(axis=0, ddof=1) / np.sqrt(8), rel=1e-9)


def test_rows_of_the_solids_are_kept_by_block(rng):
    """Saved and gone on with, also before a block is full."""
    rows = rng.random((7, 5, SOLIDS_COLUMNS))
    means = Means("solids", 5, (1.0, 3.0), 4)
    for n in range(7):
        if n in (0, 3):
            counts, sums = means.save()
            means = Means("solids", 5, (1.0, 3.0), 4)
            means.load(dict(counts), {name: values.copy() for name, values in sums.items()})
        means.add(rows[n], 1.1 + 0.25 * n)
    blocks = list(means.split_window())
    assert [block.samples for block in blocks] == [2, 2, 2, 1]
    assert [block.start for block in blocks] == pytest.approx([1.1, 1.6, 2.1, 2.6])
    for n, block in enumerate(blocks):
        assert block.rows == pytest.approx(rows[2 * n : 2 * n + 2].mean(axis=0), rel=1e-6)
    means.collect(final=True)
    assert [block.samples for block in means.split_window()] == [2, 2, 2, 1]


def test_standard_error_of_correlated_samples_is_larger_than_the_naive_one(rng):
    """An AR(1) series with correlation 0.95 has (1 + 0.95)/(1 - 0.95) = 39 times the variance of the mean."""
    n, cells, blocks, correlation = 4000, 400, 20, 0.95
    noise = rng.standard_normal((n, cells))
    series = np.empty_like(noise)
    series[0] = noise[0] / np.sqrt(1 - correlation**2)
    for step in range(1, n):
        series[step] = correlation * series[step - 1] + noise[step]
    means = Means("gas", cells, (0.0, 1.0), blocks)
    for step in range(n):
        means.add(sample_gas(np.ones(cells), np.zeros((cells, 3)), series[step]), (step + 0.5) / n)
    means.add(np.zeros((cells, GAS_COLUMNS)), 1.0 + 1e-9)
    _, error = means.collect(final=False)["pressure"]
    exact = np.sqrt(39.0 / (1 - correlation**2) / n)
    assert np.sqrt(np.mean(error**2)) == pytest.approx(exact, rel=0.1)
    assert np.sqrt(np.mean(error**2)) > 5 * np.sqrt(1 / (1 - correlation**2) / n)


def test_no_error_is_known_before_two_blocks_are_full(rng):
    means = Means("gas", 5, (0.0, 1.0), 4)
    voidage, velocity, pressure = make_gas(rng, 3)
    for n, time in enumerate((0.1, 0.2, 0.3)):
        means.add(sample_gas(voidage[n], velocity[n], pressure[n]), time)
    for mean, error in means.collect(final=False).values():
        assert np.isfinite(mean).all() and np.isnan(error).all()


def test_without_a_sample_there_is_nothing():
    means = Means("solids", 5, (0.0, 1.0), 4)
    assert means.samples == 0
    assert np.isnan(means.collect(final=False)["solids_velocity"][0]).all()


class Crowd:
    """Particles of two sizes and two densities at several times, and loops that average them cell by cell.

    Velocities have a part that differs by cell, one that differs by time, and one by particle.
    """

    def __init__(self, rng, times=6, count=150):
        self.positions = rng.random((times, count, 3)) * GRID.size
        # The uppermost layer never holds a particle.
        self.positions[..., 2] *= 0.74
        self.radii = rng.choice([3e-4, 5e-4], count)
        self.volumes = 4 / 3 * np.pi * self.radii**3
        self.masses = self.volumes * rng.choice([900.0, GLASS], count)
        by_time = rng.standard_normal((times, 1, 3))
        self.velocities = 5 * self.positions / GRID.size + by_time + 0.5 * rng.standard_normal((times, count, 3))
        self.cells = np.floor(self.positions / GRID.spacing).astype(int)

    def find(self, cell):
        """Per time: masses, velocities and volumes of the particles in `cell`."""
        for cells, velocities in zip(self.cells, self.velocities, strict=True):
            here = (cells == cell).all(axis=1)
            yield self.masses[here], velocities[here], self.volumes[here]


@pytest.fixture
def crowd(rng):
    return Crowd(rng)


@pytest.fixture
def found(crowd, sampler):
    means = Means("solids", len(CELLS), (0.0, 1.0), 2)
    for n, (positions, velocities) in enumerate(zip(crowd.positions, crowd.velocities, strict=True)):
        means.add(sampler.sample(positions, velocities, crowd.radii, crowd.masses), (n + 0.5) / 6)
    return {name: mean for name, (mean, _) in means.collect(final=False).items()}


def test_means_of_the_solids_are_those_of_loops_over_particles(crowd, found, owned):
    empty = 0
    for row, cell in enumerate(owned):
        masses, velocities, volumes = (np.concatenate(parts) for parts in zip(*crowd.find(cell), strict=True))
        total = masses.sum()
        assert found["solids_fraction"][row, 0] == pytest.approx(volumes.sum() / 6 / GRID.cell_volume, rel=1e-12)
        flux = (masses @ velocities) / 6 / GRID.cell_volume
        assert found["solids_flux"][row] == pytest.approx(flux, rel=1e-11, abs=1e-12)
        if total == 0:
            empty += 1
            assert all(np.isnan(found[name][row]).all() for name in ("solids_velocity", "agitation"))
            continue
        mean = masses @ velocities / total
        assert found["solids_velocity"][row] == pytest.approx(mean, rel=1e-11)
        agitation = masses @ np.sum((velocities - mean) ** 2, axis=1) / total
        assert found["agitation"][row, 0] == pytest.approx(agitation, rel=1e-11)
    assert empty == 6


def test_granular_temperature_is_about_the_cell_mean_of_the_instant(crowd, found, owned):
    for row, cell in enumerate(owned):
        total = squares = 0.0
        for masses, velocities, _ in crowd.find(cell):
            if len(masses):
                mean = masses @ velocities / masses.sum()
                squares += masses @ np.sum((velocities - mean) ** 2, axis=1)
                total += masses.sum()
        if total:
            assert found["granular_temperature"][row, 0] == pytest.approx(squares / total / 3, rel=1e-10)


def test_agitation_is_three_temperatures_and_the_wandering_of_the_cell_mean(crowd, found, owned):
    """<|v - <v>|^2> = <|v - c|^2> + <|c - <v>|^2>, c the cell mean of the instant, <> weighted by mass."""
    larger = 0
    for row, cell in enumerate(owned):
        pairs = [(m.sum(), m @ u / m.sum()) for m, u, _ in crowd.find(cell) if len(m)]
        if not pairs:
            continue
        weights, instants = np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs])
        mean = weights @ instants / weights.sum()
        wandering = weights @ np.sum((instants - mean) ** 2, axis=1) / weights.sum()
        agitation, temperature = found["agitation"][row, 0], found["granular_temperature"][row, 0]
        assert agitation == pytest.approx(3 * temperature + wandering, rel=1e-10)
        larger += wandering > 0.5 * temperature
    assert larger > 10, "the wandering matters in this crowd"


def test_error_of_a_ratio_uses_the_blocks_that_have_particles(sampler, owned):
    """A cell with a particle in blocks 0, 1 and 3 of five, at 1, 2 and 6 m/s: 3 +- sqrt(7/3)."""
    means = Means("solids", len(CELLS), (0.0, 1.0), 5)
    place, nowhere, size = np.array([[0.005, 0.01, 0.01]]), np.empty((0, 3)), np.array([5e-4])
    for block, speed in enumerate((1.0, 2.0, None, 6.0, None)):
        here = nowhere if speed is None else place
        radii = masses = size[: len(here)]
        means.add(sampler.sample(here, np.full_like(here, speed or 0.0), radii, masses), (block + 0.5) / 5)
    mean, error = means.collect(final=False)["solids_velocity"]
    row = int(np.flatnonzero((owned == 0).all(axis=1))[0])
    assert mean[row] == pytest.approx([3.0] * 3, rel=1e-13)
    assert error[row] == pytest.approx([np.sqrt(7.0 / 3.0)] * 3, rel=1e-12)
    assert np.isnan(np.delete(error, row, axis=0)).all()


def test_a_centre_on_a_wall_counts_in_the_cell_inside(sampler, owned):
    corners = np.array([[x, y, z] for x in (0.0, 0.03) for y in (0.0, 0.04) for z in (0.0, 0.08)])
    rows = sampler.sample(corners, np.zeros_like(corners), np.full(8, 5e-4), np.ones(8))
    volume = np.pi / 6 * 1e-9
    assert rows.shape == (len(CELLS), SOLIDS_COLUMNS)
    corner = np.all((owned == 0) | (owned == np.array(GRID.cells) - 1), axis=1)
    assert rows[:, 0] == pytest.approx(np.where(corner, volume / GRID.cell_volume, 0.0), rel=1e-13)


def test_a_part_of_the_grid_samples_its_particles_in_the_same_cells(rng, owned, sampler):
    local = LocalGrid(GRID, (1, 0, 1), (3, 2, 3))
    positions = np.array([0.01, 0.0, 0.02]) + rng.random((40, 3)) * [0.02, 0.04, 0.04]
    velocities, radii = rng.standard_normal((40, 3)), np.full(40, 5e-4)
    part = SolidsSampler(HaloExchange(MPI.COMM_SELF, local, owned)).sample(positions, velocities, radii, radii)
    assert part == pytest.approx(sampler.sample(positions, velocities, radii, radii), rel=1e-13)
