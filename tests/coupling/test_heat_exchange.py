"""Heat between gas and particles: what one loses the other gains, by the exact average over any step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_momentum import DENSITY, METHODS, VISCOSITY, Bed

from fbcouple.physics.heat.nusselt import NUSSELT_LAWS

REFERENCE, SPECIFIC_HEAT, CONDUCTIVITY, GAS_HEAT = 300.0, 840.0, 0.026, 1005.0
STEPS = [1e-6, 1e-2, 1e4]

every_method = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)


class HotBed(Bed):
    """A bed whose particles and gas have temperatures."""

    def __init__(self, rng, cells=(6, 3, 7), law="gunn", nusselt_file=None, **exchange):
        heat = {
            "gas_temperature": REFERENCE,
            "particle_temperature": 350.0,
            "gas_specific_heat": GAS_HEAT,
            "gas_conductivity": CONDUCTIVITY,
            "particle_specific_heat": SPECIFIC_HEAT,
            "nusselt": law,
            "nusselt_file": nusselt_file,
        }

        super().__init__(rng, cells, heat=heat, **exchange)
        self.temperatures = rng.uniform(290.0, 400.0, len(self.volumes))
        self.gas = rng.uniform(280.0, 410.0, len(self.centres))

    def exchange(self, dt):
        """One step of `dt` [s]: heat that the particles got, and that the gas lost by its sums [J]."""
        self.prepare(dt)
        own = self.particles.masses, self.temperatures
        self.coupling.deposit_heat(self.particles, own, dt)
        sums = self.coupling.heat_sums
        lost = dt * float((sums[:, 0] * (self.gas - REFERENCE) - sums[:, 1]).sum())
        return self.coupling.give_heat(self.gas, own), lost


@pytest.mark.parametrize("dt", STEPS)
@pytest.mark.parametrize("passes", [0, 2])
@every_method
def test_particles_get_what_the_gas_loses(rng, method, passes, dt):
    bed = HotBed(rng, filter_passes=passes, **method)
    before = SPECIFIC_HEAT * bed.particles.masses @ (bed.temperatures - REFERENCE)
    given, lost = bed.exchange(dt)
    after = SPECIFIC_HEAT * bed.particles.masses @ (bed.temperatures - REFERENCE)
    scale = SPECIFIC_HEAT * bed.particles.masses.sum() * 50.0
    assert given == pytest.approx(lost, abs=1e-13 * scale)
    assert after - before == pytest.approx(given, abs=1e-12 * scale)


@every_method
def test_no_step_is_too_long(rng, method):
    """1e4 s, millions of response times: each particle has the temperature of the gas around it."""
    bed = HotBed(rng, **method)
    bed.exchange(1e4)
    assert bed.temperatures.min() >= bed.gas.min() and bed.temperatures.max() <= bed.gas.max()
    before = bed.temperatures.copy()
    bed.exchange(1e4)
    assert bed.temperatures == pytest.approx(before, abs=1e-9)


@pytest.mark.parametrize("ratio", [None, 2.0], ids=["particles", "parcels"])
@pytest.mark.parametrize("law", NUSSELT_LAWS)
def test_the_average_over_a_step_is_that_of_a_constant_gas(rng, law, ratio):
    """T = T_gas + (T_0 - T_gas) exp(-h A t/(m cp)), h by the law at each particle, whatever the step; parcels have the
    rates of their grains."""
    bed = HotBed(rng, law=law, voidage="centre", ratio=ratio)
    bed.gas[:] = 310.0
    start = bed.temperatures.copy()
    dt = 0.3
    bed.exchange(dt)
    cell = np.linalg.norm(bed.particles.positions[:, None] - bed.centres[None], axis=2)
    edges = bed.grid.spacing
    inside = np.abs(bed.particles.positions[:, None] - bed.centres[None]) <= 0.5 * edges * (1.0 + 1e-12)
    home = np.where(inside.all(axis=2), cell, np.inf).argmin(axis=1)
    eps, diameters = bed.coupling.voidage[home], 2.0 * bed.particles.radii / (ratio or 1.0)
    slip = np.linalg.norm(bed.velocity[home] - bed.particles.velocities, axis=1)
    nusselt = NUSSELT_LAWS[law](eps, eps * DENSITY * slip * diameters / VISCOSITY, VISCOSITY * GAS_HEAT / CONDUCTIVITY)
    grain_masses = bed.particles.masses / (ratio or 1.0) ** 3
    rates = nusselt * CONDUCTIVITY * math.pi * diameters / (grain_masses * SPECIFIC_HEAT)
    assert bed.temperatures == pytest.approx(310.0 + (start - 310.0) * np.exp(-rates * dt), rel=1e-12)
