"""The exchange of an ideal gas: drag and heat transfer at the particles take the density that the gas has there."""

from __future__ import annotations

import numpy as np
import pytest
from test_heat_exchange import CONDUCTIVITY, GAS_HEAT, REFERENCE, SPECIFIC_HEAT
from test_momentum import DENSITY, DT, Bed

from fbcouple.physics.drag.registry import DRAG_LAWS

HEAT = {
    "gas_temperature": REFERENCE,
    "particle_temperature": 350.0,
    "gas_specific_heat": GAS_HEAT,
    "gas_conductivity": CONDUCTIVITY,
    "particle_specific_heat": SPECIFIC_HEAT,
}
RATIO = 0.4


def expand(bed, densities):
    bed.prepare()
    bed.coupling.deposit_drag(bed.particles, DT, 0.0, densities)
    bed.coupling.deposit_heat(bed.particles, (bed.particles.masses, np.full(len(bed.volumes), 350.0)), DT)
    return bed.coupling


def make(seed, density, **exchange):
    bed = Bed(np.random.default_rng(seed), heat=HEAT | {"gas_density": density}, **exchange)
    if density == "constant":
        bed.coupling._drag = bed.coupling._drag._replace(density=RATIO * DENSITY)
        transfer = bed.coupling._heat._transfer
        bed.coupling._heat._transfer = transfer._replace(reynolds=RATIO * transfer.reynolds)
    return bed


@pytest.mark.parametrize("drag", sorted(DRAG_LAWS))
def test_a_thin_gas_has_the_drag_and_the_heat_transfer_of_a_gas_of_that_density(drag):
    """All laws are right in their dimensions, so that density and slip come in by their product alone."""
    ideal = make(7, "ideal", drag=drag)
    found = expand(ideal, np.full(len(ideal.centres), RATIO))
    expected = expand(make(7, "constant", drag=drag), None)
    assert found.beta == pytest.approx(expected.beta, rel=1e-13)
    assert found.drag_sums == pytest.approx(expected.drag_sums, rel=1e-12, abs=1e-15)
    assert found.heat_sums == pytest.approx(expected.heat_sums, rel=1e-12)


def test_each_particle_takes_the_density_where_it_is(rng):
    """Thin gas on the right half: less drag there, and that of before on the left."""
    bed = Bed(rng, heat=HEAT | {"gas_density": "ideal"}, voidage="centre")
    x = bed.centres[:, 0]
    middle = 0.5 * bed.grid.size[0]
    whole = expand(bed, np.ones(len(x))).beta.copy()
    part = expand(bed, np.where(x > middle, RATIO, 1.0)).beta
    left = bed.particles.positions[:, 0] < middle
    assert part[left] == pytest.approx(whole[left], rel=1e-14) and (part[~left] < 0.95 * whole[~left]).all()
    assert left.any() and not left.all()
