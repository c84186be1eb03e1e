"""What the gas loses the particles gain, to rounding; the drag of a step averaged; forces handed over as impulses."""

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.case.schema.sections import Case
from fbcouple.case.user_laws import DRAG_LAWS
from fbcouple.coupling.box.mapping import VOIDAGE_METHODS
from fbcouple.coupling.coupling import Coupling, Particles
from fbcouple.coupling.discretisation import BoxSpace
from fbcouple.coupling.kernels import DRAG_SCHEMES
from fbcouple.geometry.grid import Grid
from fbcouple.simulation.conservation import Conservation

SCHEMES = ["exponential", "semi-implicit", "explicit"]
PASSES = [0, 1, 3]
CELLS = [(6, 3, 7), (4, 1, 5)]
METHODS = {name: {"voidage": name} | ({"kernel_width": 3.0} if name == "gaussian" else {}) for name in VOIDAGE_METHODS}
METHODS |= {"diffusion": {"diffusion_width": 3.0}, "centre-diffusion": {"voidage": "centre", "diffusion_width": 2.0}}

every_method = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
DENSITY, VISCOSITY, GRAVITY, DT = 1.165, 2e-5, 9.81, 3e-4


class Bed:
    """Some particles in a box, a gas with random fields, and the coupling of the two in this process."""

    def __init__(self, rng, cells=(6, 3, 7), gravity=GRAVITY, held_gravity=0.0, heat=None, ratio=None, **exchange):
        size = tuple(n * edge for n, edge in zip(cells, (0.002, 0.003, 0.0025), strict=True))
        self.grid = Grid(cells, size)
        case = Case.model_validate(
            {
                "title": "a bed",
                "end_time": 1.0,
                "gravity": gravity,
                "domain": {"size": size, "cells": cells},
                "gas": {"density": DENSITY, "viscosity": VISCOSITY, "inlet_velocity": 1.0},
                "particles": {"diameter": 1e-3, "density": 2500.0, "count": 60, "coarse_graining": ratio},
                "exchange": exchange,
                "heat": heat,
            }
        )
        centres = np.stack(np.meshgrid(*map(self.grid.centres, range(3)), indexing="ij"), axis=-1).reshape(-1, 3)
        self.centres = rng.permutation(centres)
        bounds = np.array([[0.0, 0.0, 0.0], size])
        self.coupling = Coupling(case, BoxSpace(case, MPI.COMM_SELF, self.centres, bounds, 1e-3), held_gravity)
        n = 60
        radii = rng.uniform(3e-4, 5e-4, n)
        places = np.clip(rng.uniform(-0.1, 1.1, (n, 3)), 0.0, 1.0) * size
        self.particles = Particles(places, rng.standard_normal((n, 3)), radii, 2500.0 * 4 / 3 * np.pi * radii**3)
        self.volumes = 4 / 3 * np.pi * radii**3
        self.velocity = rng.standard_normal((len(centres), 3))
        self.pressure_gradient = 1e4 * rng.standard_normal((len(centres), 3))

    def prepare(self, dt=DT):
        """Map, read the gas, and find the drag of the step."""
        self.coupling.map(self.particles)
        self.coupling.read_gas(np.hstack([self.velocity, self.pressure_gradient]))
        self.coupling.deposit_drag(self.particles, dt)

    def react(self, velocity, pressure_gradient):
        """The force on each particle, from none before, and the summed drag magnitude."""
        held, current = np.zeros((2, len(self.volumes), 3))
        magnitude = self.hand_over(velocity, pressure_gradient, held, current)
        assert (held == current).all()
        return held, magnitude

    def hand_over(self, velocity, pressure_gradient, held, current):
        """Put the particles under their force."""
        return self.coupling.apply_gas_force(self.particles, np.hstack([velocity, pressure_gradient]), held, current)

    def find_loss(self, velocity, pressure_gradient):
        """The force that the gas gave up, from the sums that its solver makes."""
        sums, solids = self.coupling.drag_sums, (1.0 - self.coupling.voidage) * self.grid.cell_volume
        drag = (sums[:, :1] * velocity - sums[:, 1:]).sum(axis=0)
        return self.coupling.find_gas_loss(np.array([*drag, *(solids @ pressure_gradient), solids.sum()]))


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize("passes", PASSES)
@every_method
def test_solids_volume_is_kept(rng, cells, passes, method):
    bed = Bed(rng, cells, filter_passes=passes, **method)
    bed.coupling.map(bed.particles)
    solids = np.sum(1.0 - bed.coupling.voidage) * bed.grid.cell_volume
    assert solids == pytest.approx(bed.volumes.sum(), rel=1e-12)


def test_voidage_is_one_less_the_hat_weights(rng, hats):
    """Eq. 30, with no filter."""
    bed = Bed(rng, filter_passes=0)
    bed.coupling.map(bed.particles)
    solids = np.einsum("pijk,p->ijk", hats(bed.grid, bed.particles.positions), bed.volumes) / bed.grid.cell_volume
    i, j, k = bed.grid.indices(bed.centres).T
    assert bed.coupling.voidage == pytest.approx(1.0 - solids[i, j, k], abs=1e-13)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("passes", PASSES)
@pytest.mark.parametrize("cells", CELLS)
@every_method
def test_drag_on_the_particles_is_what_the_gas_gives_up(rng, cells, passes, scheme, method):
    """sum_p beta~ (u at p - v) = sum_c V (K u - S), for a new gas velocity that the drag step has not seen."""
    bed = Bed(rng, cells, scheme=scheme, filter_passes=passes, pressure_gradient=False, **method)
    bed.prepare()
    after = rng.standard_normal(bed.velocity.shape)
    forces, magnitude = bed.react(after, bed.pressure_gradient)
    sums = bed.coupling.drag_sums
    lost = np.sum(sums[:, :1] * after - sums[:, 1:], axis=0)
    gained = forces.sum(axis=0)
    assert magnitude == pytest.approx(np.linalg.norm(forces, axis=1).sum(), rel=1e-12)
    assert np.abs(gained).min() > 1e-3 * magnitude, "a sum that is not zero by itself"
    assert gained == pytest.approx(lost, abs=1e-13 * magnitude)
    assert bed.find_loss(after, bed.pressure_gradient) == pytest.approx(lost, abs=1e-13 * magnitude)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("passes", PASSES)
@every_method
def test_pressure_gradient_and_lift_balance_too(rng, passes, scheme, method):
    bed = Bed(rng, scheme=scheme, filter_passes=passes, **method)
    bed.prepare()
    after, gradient = rng.standard_normal(bed.velocity.shape), 1e4 * rng.standard_normal(bed.velocity.shape)
    forces, magnitude = bed.react(after, gradient)
    lost = bed.find_loss(after, gradient)
    assert forces.sum(axis=0) == pytest.approx(lost, abs=1e-13 * magnitude)


@pytest.mark.parametrize("passes", PASSES)
def test_each_particle_feels_beta_times_the_slip_it_has(rng, hats, passes):
    """One by one against hat weights and the filter's matrix; the law itself has its own tests."""
    bed = Bed(rng, scheme="exponential", filter_passes=passes, pressure_gradient=False)
    bed.prepare()
    forces, _ = bed.react(bed.velocity, bed.pressure_gradient)
    cells = bed.grid.cells
    wind, voidage = np.empty((*cells, 3)), np.empty(cells)
    i, j, k = bed.grid.indices(bed.centres).T
    wind[i, j, k], voidage[i, j, k] = bed.velocity, bed.coupling.voidage
    for axis, n in enumerate(cells):
        rows = 0.5 * np.eye(n) + 0.25 * (np.eye(n, k=1) + np.eye(n, k=-1))
        rows[0, 0], rows[-1, -1] = 0.75, 0.75
        wind = np.moveaxis(np.tensordot(np.linalg.matrix_power(rows, passes), wind, (1, axis)), 0, axis)
    weights = hats(bed.grid, bed.particles.positions)
    slip = np.einsum("pijk,ijkm->pm", weights, wind) - bed.particles.velocities
    eps = np.einsum("pijk,ijk->p", weights, voidage)
    law = DRAG_LAWS["huilin-gidaspow"]
    beta = law(eps, np.linalg.norm(slip, axis=1), 2 * bed.particles.radii, DENSITY, VISCOSITY)
    mean = bed.particles.masses / DT * -np.expm1(-DT * beta / bed.particles.masses)
    assert forces == pytest.approx(mean[:, None] * slip, rel=1e-10, abs=1e-12 * np.abs(mean).max())


def test_explicit_drag_is_that_of_the_steps_start(rng):
    """The paper's plain form: nothing implicit for the gas, and a new gas velocity changes no force."""
    bed = Bed(rng, scheme="explicit", filter_passes=1, pressure_gradient=False)
    bed.prepare()
    before, _ = bed.react(bed.velocity, bed.pressure_gradient)
    after, _ = bed.react(-5.0 * bed.velocity, bed.pressure_gradient)
    assert not bed.coupling.drag_sums[:, 0].any()
    assert (after == before).all() and np.abs(before).max() > 0.0


def test_schemes_agree_for_a_short_step_and_are_bounded_for_a_long_one(rng):
    seed = rng.integers(1 << 30)
    forces = {}
    for scheme in SCHEMES:
        for dt in (1e-9, 1e3):
            bed = Bed(np.random.default_rng(seed), scheme=scheme, pressure_gradient=False)
            bed.prepare(dt)
            forces[scheme, dt], _ = bed.react(bed.velocity, bed.pressure_gradient)
    for scheme in SCHEMES[:2]:
        # dt beta/m is about 1e-8 here, half of which is the schemes' difference.
        assert forces[scheme, 1e-9] == pytest.approx(forces["explicit", 1e-9], rel=1e-6)
        impulse = 1e3 * forces[scheme, 1e3] / bed.particles.masses[:, None]
        wind = impulse + bed.particles.velocities
        # An endless step gives the particle the gas velocity and no more.
        assert np.abs(wind).max() < np.abs(bed.velocity).max() * 1.01


def test_exact_average_is_the_exponential_relaxation():
    """m dv/dt = beta (u - v): with beta~ one step of any length ends on u + (v - u) exp(-dt beta/m)."""
    mass, dt = np.full(6, 1.3e-6), 2e-4
    rate = np.array([1e-9, 1e-3, 0.1, 1.0, 10.0, 1e3])
    beta = rate * mass / dt
    mean = beta.copy()
    DRAG_SCHEMES["exponential"](mean, mass, dt)
    u, v = 1.2, -0.4
    after = v + dt * mean / mass * (u - v)
    assert after == pytest.approx(u + (v - u) * np.exp(-rate), rel=1e-13)
    assert mean[0] == pytest.approx(beta[0] * (1 - rate[0] / 2), rel=1e-15)
    assert mean[-1] == pytest.approx(mass[-1] / dt, rel=1e-15)
    assert (mean < beta).all()


def test_implicit_average_is_backward_euler():
    mass, dt = np.full(5, 1.3e-6), 2e-4
    rate = np.array([1e-9, 0.1, 1.0, 10.0, 1e6])
    mean = rate * mass / dt
    DRAG_SCHEMES["semi-implicit"](mean, mass, dt)
    u, v = 1.2, -0.4
    after = v + dt * mean / mass * (u - v)
    # Backward Euler: after = v + rate (u - after).
    assert after == pytest.approx((v + rate * u) / (1 + rate), rel=1e-13)


def test_a_resting_particle_in_resting_gas_is_lifted_by_its_gas_weight(rng):
    """Archimedes: P is the dynamic pressure, so the hydrostatic part comes as V rho g upward."""
    bed = Bed(rng)
    bed.particles.velocities[:] = 0.0
    still = np.zeros_like(bed.velocity)
    bed.velocity = bed.pressure_gradient = still
    bed.prepare()
    forces, magnitude = bed.react(still, still)
    assert magnitude == 0.0
    expected = np.outer(bed.volumes * DENSITY * GRAVITY, [0.0, 0.0, 1.0])
    assert forces == pytest.approx(expected, rel=1e-14)


@every_method
@pytest.mark.parametrize("wanted", [True, False])
def test_a_uniform_pressure_gradient_pushes_by_volume_or_not_at_all(rng, wanted, method):
    bed = Bed(rng, gravity=0.0, filter_passes=1, pressure_gradient=wanted, **method)
    gradient = np.tile([700.0, -300.0, -1e4], (bed.grid.count, 1))
    bed.prepare()
    drag, _ = bed.react(bed.velocity, np.zeros_like(gradient))
    both, _ = bed.react(bed.velocity, gradient)
    push = -np.outer(bed.volumes, gradient[0]) * wanted
    assert both - drag == pytest.approx(push, rel=1e-10, abs=1e-18)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_held_force_is_replaced_in_the_current_one(rng, scheme):
    """`current` holds contacts, weight and the held gas force: only the last of them changes."""
    bed = Bed(rng, scheme=scheme, filter_passes=1)
    bed.prepare()
    forces, magnitude = bed.react(bed.velocity, bed.pressure_gradient)
    held, rest = np.abs(forces).max() * rng.standard_normal((2, *forces.shape))
    current = rest + held
    for _ in range(2):
        total = bed.hand_over(bed.velocity, bed.pressure_gradient, held, current)
        assert total == pytest.approx(magnitude, rel=1e-14)
        assert held == pytest.approx(forces, rel=1e-14)
        assert current - held == pytest.approx(rest, abs=1e-14 * np.abs(rest).max())


def test_a_weight_that_is_held_comes_beside_the_force_of_the_gas():
    """The gas gives up no more than without it; masses of all sizes."""
    beds = [Bed(np.random.default_rng(3), held_gravity=gravity) for gravity in (0.0, GRAVITY)]
    for bed in beds:
        bed.prepare()
    (gas, drag), (held, same) = (bed.react(bed.velocity, bed.pressure_gradient) for bed in beds)
    weights = GRAVITY * beds[0].particles.masses
    assert (held[:, :2] == gas[:, :2]).all() and drag == same
    assert held[:, 2] == pytest.approx(gas[:, 2] - weights, rel=1e-14)
    conservation = Conservation(MPI.COMM_SELF)
    conservation.give(beds[1].find_loss(beds[1].velocity, beds[1].pressure_gradient), drag, DT)
    conservation.receive(held, DT, weight=float(weights.sum()))
    assert conservation.momentum_error < 1e-13


def test_the_impulse_that_the_gas_lost_is_the_particles_impulse_over_the_same_step(rng):
    bed = Bed(rng)
    bed.prepare()
    held, current = np.zeros((2, len(bed.volumes), 3))
    magnitude = bed.hand_over(bed.velocity, bed.pressure_gradient, held, current)
    loss = bed.find_loss(bed.velocity, bed.pressure_gradient)
    conservation = Conservation(MPI.COMM_SELF)
    conservation.give(loss, magnitude, DT)
    conservation.receive(held, DT)
    assert conservation.particles == len(bed.volumes) and conservation.momentum_error < 1e-13
    assert held.sum(axis=0) == pytest.approx(loss, abs=1e-13 * magnitude)
    conservation.give(loss, magnitude, DT)
    conservation.receive(held, 4 / 3 * DT)
    assert conservation.momentum_error > 0.01, "the same force over another step is no balance"


@every_method
def test_a_rank_without_particles_takes_part(method):
    """Its local grid is still needed for the others' sake: nothing is written, and nothing fails."""
    bed = Bed(np.random.default_rng(0), **method)
    nobody = Particles(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty(0))
    bed.particles, bed.volumes = nobody, np.empty(0)
    bed.prepare()
    forces, magnitude = bed.react(bed.velocity, bed.pressure_gradient)
    assert forces.shape == (0, 3) and magnitude == 0.0
    assert (bed.coupling.voidage == 1.0).all() and not bed.coupling.drag_sums.any()


def test_balance_measures_what_is_missing(rng):
    """A particle whose drag of 3 N goes astray, of 12 N in all, is an error of a quarter."""
    forces = np.array([[3.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 5.0]])
    conservation = Conservation(MPI.COMM_SELF)
    conservation.give(forces.sum(axis=0), 12.0, 1e-4)
    conservation.receive(forces[1:], 1e-4)
    assert conservation.momentum_error == pytest.approx(0.25, rel=1e-14) and conservation.particles == 2


def test_balance_in_a_liquid_is_of_the_whole_impulse():
    """Buoyancy of 4 N beside a drag of next to nothing: a missing 1 N is a quarter."""
    conservation = Conservation(MPI.COMM_SELF)
    conservation.give(np.array([0.0, 0.0, 4.0]), 1e-12, 1e-4)
    conservation.receive(np.array([[0.0, 0.0, 3.0]]), 1e-4)
    assert conservation.momentum_error == pytest.approx(0.25, rel=1e-12)


@pytest.mark.parametrize("passes", PASSES)
def test_particles_that_rise_above_what_was_read_feel_the_gas_there(rng, passes):
    """Only the layers of the bed are read; what a step carries above them is read again without a message."""
    bed, other = (Bed(np.random.default_rng(5), (4, 3, 30), filter_passes=passes) for _ in range(2))
    height = bed.particles.positions[:, 2].copy()
    bed.particles.positions[:, 2] *= 0.2
    bed.prepare()
    for one in (bed, other):
        one.particles.positions[:, 2] = height
        one.coupling.map(one.particles)
    other.coupling.read_gas(np.hstack([other.velocity, other.pressure_gradient]))
    for one in (bed, other):
        one.coupling.deposit_drag(one.particles, DT)
    assert (bed.coupling.beta == other.coupling.beta).all()
    assert (bed.coupling.drag_sums == other.coupling.drag_sums).all()
    assert bed.coupling.beta.min() > 0


@pytest.mark.parametrize("passes", PASSES)
def test_a_bed_that_sinks_leaves_nothing_behind(passes):
    """Only the layers of the bed are added up; those above it still hold what a higher bed wrote."""
    bed = Bed(np.random.default_rng(5), (4, 3, 30), filter_passes=passes)
    for height in (1.0, 0.5, 0.2):
        bed.particles.positions[:, 2] *= height
        bed.prepare()
        solids = np.sum(1.0 - bed.coupling.voidage) * bed.grid.cell_volume
        assert solids == pytest.approx(bed.volumes.sum(), rel=1e-12)
        forces, magnitude = bed.react(bed.velocity, bed.pressure_gradient)
        loss = bed.find_loss(bed.velocity, bed.pressure_gradient)
        assert loss == pytest.approx(forces.sum(axis=0), abs=1e-13 * magnitude)
