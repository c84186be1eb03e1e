"""Drag that knows the other forces: exact for constant ones at any step, and what the gas loses the particle gets."""

from dataclasses import replace

import numpy as np
import pytest
from test_momentum import DT, Bed

from fbcouple.case.bed.acceleration import SLOW, choose_acceleration
from fbcouple.case.bed.exchange_numbers import response_times
from fbcouple.case.bed.fluid_step import coupling_step
from fbcouple.case.checks.registry import find_problems
from fbcouple.case.load import load_case
from fbcouple.coupling.kernels import BLENDING, predict

STIFFNESS = [1e-6, 1e-3, 0.0999, 0.1001, 1.0, 10.0, 1e3]


def aim_for(x, velocity, drift, ratio=1.0):
    """Foresee one particle of unit mass over a unit step, `ratio` times the last, with dt beta/m = x: aim and beta~."""
    aim = np.empty((1, 3))
    predict(np.full((1, 3), velocity), np.full((1, 3), velocity - drift / BLENDING / ratio), ratio, np.array([x]), aim)
    return aim[0, 0], -np.expm1(-x)


@pytest.mark.parametrize("ratio", [1.0, 0.25, 3.0])
@pytest.mark.parametrize("x", STIFFNESS)
def test_mean_drag_is_that_of_the_exact_path(x, ratio):
    """dv/dt = x (u - v) + a from v0 over a unit step, `ratio` times the last: the drag's impulse is v1 - v0 - a."""
    u, v0, a = 1.3, -0.4, 2.5
    end = u + a / x
    change = (end - v0) * -np.expm1(-x)
    aim, beta = aim_for(x, v0, a, ratio)
    assert beta * (u - aim) == pytest.approx(change - a, rel=1e-9 if x > 0.01 else 1e-9 / x)


@pytest.mark.parametrize("x", STIFFNESS)
def test_a_particle_in_balance_stays_in_balance(x):
    """At terminal velocity, and packed at rest, the drag of the step is beta (u - v): no lag, no bias."""
    slip = 0.7
    aim, beta = aim_for(x, 0.0, -x * slip)
    assert beta * (slip - aim) == pytest.approx(x * slip, rel=1e-9)


def test_what_is_known_of_other_forces_is_half_new(rng):
    """No new one: half of what was known is left, and the drag acts on v + c d."""
    bed = Bed(rng, filter_passes=0)
    first = rng.standard_normal(bed.particles.velocities.shape)
    bed.particles = replace(bed.particles, drag_only_velocities=bed.particles.velocities - first / BLENDING)
    bed.prepare()
    force, _ = bed.react(bed.velocity, 0.0 * bed.pressure_gradient)
    # The particles move as drag alone would have it.
    lift = bed.volumes[:, None] * np.array([0.0, 0.0, 9.81 * 1.165])
    moved = bed.particles.velocities + DT * (force - lift) / bed.particles.masses[:, None]
    known = BLENDING * (moved - bed.particles.drag_only_velocities)
    assert known == pytest.approx((1.0 - BLENDING) * first, rel=1e-9, abs=1e-12)


def test_the_gas_loses_what_the_particles_get(rng):
    bed = Bed(rng, filter_passes=1)
    driven = bed.particles.velocities + rng.standard_normal(bed.particles.velocities.shape)
    plain_force = force_of(bed)
    bed.particles = replace(bed.particles, drag_only_velocities=driven.copy())
    force = force_of(bed)
    assert np.abs(force - plain_force).max() > 1e-3 * np.abs(plain_force).max()
    loss = bed.find_loss(bed.velocity, bed.pressure_gradient)
    assert force.sum(axis=0) == pytest.approx(loss, rel=1e-10, abs=1e-10 * np.abs(force).sum())


def force_of(bed):
    bed.prepare()
    return bed.react(bed.velocity, bed.pressure_gradient)[0]


def test_the_drag_is_left_behind_for_the_next_step(rng):
    """v + dt F_D/m, without the pressure gradient's force."""
    bed = Bed(rng, filter_passes=0)
    bed.particles = replace(bed.particles, drag_only_velocities=bed.particles.velocities.copy())
    bed.prepare()
    bed.react(bed.velocity, bed.pressure_gradient)
    with_push = bed.particles.drag_only_velocities.copy()
    bed.particles.drag_only_velocities[:] = bed.particles.velocities
    bed.prepare()
    force, _ = bed.react(bed.velocity, 0.0 * bed.pressure_gradient)
    lift = bed.volumes[:, None] * np.array([0.0, 0.0, 9.81 * 1.165])
    gained = DT * (force - lift) / bed.particles.masses[:, None]
    assert with_push == pytest.approx(bed.particles.velocities + gained, rel=1e-12, abs=1e-14)
    assert bed.particles.drag_only_velocities == pytest.approx(with_push, rel=1e-12, abs=1e-14)


def test_it_is_in_where_the_step_needs_it():
    dusty = ["particles.diameter=1e-4", "particles.mass=1e-4"]
    glass, dust = load_case("patil/c2", ["accuracy=none"]), load_case("patil/c2", dusty)
    for case, wanted in ((glass, False), (dust, True)):
        ratio = coupling_step(case) / response_times(case)["tau_p"]
        assert (ratio > SLOW) == wanted == choose_acceleration(case)[0]
    forced = load_case("patil/c2", ["accuracy=none", "exchange.accelerated=true"])
    left_out = load_case("patil/c2", [*dusty, "exchange.accelerated=false"])
    assert choose_acceleration(forced)[0] and not choose_acceleration(left_out)[0]
    assert not choose_acceleration(load_case("patil/c2", [*dusty, "exchange.scheme=explicit"]))[0]


def test_only_the_exact_mean_can_know_of_it():
    case = load_case("patil/c2")
    exchange = case.exchange.model_copy(update={"accelerated": True, "scheme": "semi-implicit"})
    (problem,) = find_problems(case.model_copy(update={"exchange": exchange}))
    assert problem.startswith("exchange.accelerated: true is given and exchange.scheme is")
