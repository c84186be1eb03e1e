"""Forces beside drag and pressure gradient: what particles gain the gas loses, and without them there is nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_momentum import DENSITY, DT, GRAVITY, VISCOSITY, Bed, every_method

from fbcouple.coupling.forces import ADDED_MASS, FORCES

ALL = dict.fromkeys(FORCES, True)


def derive(bed, rng):
    """Random derived fields of the gas for the forces of the bed."""
    return rng.standard_normal((len(bed.centres), 3 * len(bed.coupling.forces.fields)))


def prepare(bed, fields, last_dt=DT):
    bed.coupling.map(bed.particles)
    bed.coupling.read_gas(np.hstack([bed.velocity, bed.pressure_gradient]))
    bed.coupling.forces.read(fields)
    bed.coupling.deposit_drag(bed.particles, DT, last_dt)


@pytest.mark.parametrize("last_dt", [DT, 4.0 * DT])
@pytest.mark.parametrize("scheme", ["exponential", "explicit"])
@pytest.mark.parametrize("passes", [0, 2])
@pytest.mark.parametrize("names", [*([name] for name in FORCES), list(FORCES)], ids="-".join)
@every_method
def test_gas_and_particles_share_the_momentum(rng, method, names, passes, scheme, last_dt):
    """The particles got a part of it in the move before, of `last_dt`: that by their own acceleration."""
    bed = Bed(rng, filter_passes=passes, scheme=scheme, **method, **dict.fromkeys(names, True))
    last = bed.particles.velocities + 1e-3 * rng.standard_normal(bed.particles.velocities.shape)
    bed.particles = replace(bed.particles, last_velocities=last if "virtual_mass" in names else None)
    prepare(bed, derive(bed, rng), last_dt)
    after = rng.standard_normal(bed.velocity.shape)
    forces, magnitude = bed.react(after, bed.pressure_gradient)
    loss = bed.find_loss(after, bed.pressure_gradient)
    assert np.abs(loss).min() > 1e-6 * magnitude and loss == pytest.approx(forces.sum(axis=0), abs=1e-13 * magnitude)
    own = bed.coupling.forces.moved
    expected = np.zeros(3)
    if "virtual_mass" in names:
        carried = ADDED_MASS * DENSITY * bed.volumes[:, None]
        expected = -(carried * (bed.particles.velocities - last) / last_dt).sum(axis=0)
    assert own == pytest.approx(expected, rel=1e-12)


def test_virtual_mass_is_the_gas_that_is_carried_along_times_its_acceleration(rng):
    """In gas whose velocity goes from u to u + a dt everywhere, with u.grad(u) = c: m_a (a + c), and no weight."""
    bed, plain = (Bed(np.random.default_rng(3), pressure_gradient=False, virtual_mass=on) for on in (True, False))
    a, c = np.array([3.0, -2.0, 5.0]), np.array([0.5, 1.0, -4.0])
    for one in (bed, plain):
        one.velocity[:] = [0.3, 0.1, -0.2]
    prepare(bed, np.tile(c, (len(bed.centres), 1)))
    plain.prepare()
    after = bed.velocity + a * DT
    forces, usual = (one.react(after, one.pressure_gradient)[0] for one in (bed, plain))
    carried = ADDED_MASS * DENSITY * bed.volumes[:, None]
    expected = carried * (a + c + [0.0, 0.0, GRAVITY])
    assert forces - usual == pytest.approx(expected, rel=1e-9, abs=1e-18)


def test_lift_pushes_a_sphere_that_lags_towards_the_faster_gas():
    """u along x that grows with z: w = (0, g, 0); Saffman's 6.46 mu a^2 U sqrt(g/nu) where Mei's factor is about 1."""
    slip, curl = np.array([[1e-3, 0.0, 0.0]]), np.array([[0.0, 1e-4, 0.0]])
    radii, force = np.array([5e-5]), np.zeros((1, 3))
    FORCES["lift_force"].kernel(slip, curl, radii, DENSITY, VISCOSITY, force)
    nu = VISCOSITY / DENSITY
    saffman = 6.46 * VISCOSITY * 5e-5**2 * 1e-3 * np.sqrt(1e-4 / nu)
    assert force[0, 2] == pytest.approx(saffman, rel=2e-3) and force[0, 0] == force[0, 1] == 0.0


def test_without_slip_or_shear_there_is_no_lift():
    force = np.zeros((2, 3))
    moving, turning = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    FORCES["lift_force"].kernel(moving, turning, np.full(2, 5e-4), DENSITY, VISCOSITY, force)
    assert not force.any()


def test_without_any_of_them_there_is_nothing_of_them(rng):
    assert Bed(rng).coupling.forces is None and Bed(rng, **ALL).coupling.forces is not None
