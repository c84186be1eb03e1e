"""Pre-flight numbers of heat: what the cells add to the conduction that a case asks for, and what the constant density
of the gas leaves out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fbcouple.case.bed.gas_heat import (
    find_conductivity,
    list_inlet_temperatures,
    list_temperatures,
    list_wall_temperatures,
)
from fbcouple.case.bed.number import Number, judge
from fbcouple.case.bed.particle_types import find_ratio
from fbcouple.case.bed.positions import start_temperatures
from fbcouple.case.bed.speeds import SETTLED
from fbcouple.case.schema.sections import Case
from fbcouple.physics.heat.conductivity import conduct_by_bed

SMALL = 0.1
"""Conductivity that sharing adds, over that of the bed by Zehner and Schlunder, above which it is told."""
STEADY = 0.05
"""Change of the gas's density by its temperature, over it, above which it is told."""
CELSIUS = 5.0, 150.0
"""Temperatures [K] between which one is told: most are those of a bed in degrees Celsius."""
_LIQUID = 100.0
"""Density [kg/m3] above which what flows is taken to be a liquid, no ideal gas."""
_RESTING = 3.8
"""Nusselt number of a packed bed in gas at rest, Gunn's 7 - 10 eps + 5 eps^2 at voidage 0.4."""


def describe_conduction(case: Case, cell: np.ndarray) -> Iterator[Number]:
    """Conductivity that a packed bed at rest gets because particles are shared among cells of the size `cell` (3,) [m],
    along the longest axis, over that of its gas; of a case that asks for conduction by the bed or by contacts."""
    heat, gas, exchange, particles = case.heat, case.gas, case.exchange, case.particles
    if not (heat and gas and exchange and particles):
        return
    if {heat.bed_conduction, heat.contact_conduction} == {"none"}:
        return
    transfer = 6.0 * SETTLED / particles.diameter**2 * _RESTING  # n h A over k
    ratio = transfer * find_variance(case, float(np.max(cell)))
    meaning = (
        "Conductivity that a packed bed at rest gets from particles that are shared among cells, over that of the gas; "
        'exchange.voidage = "centre" without filter and diffusion has none, small cells have little. Where the bed '
        "moves particles carry more."
    )
    own = find_conductivity(heat, gas)
    packed = np.array([1.0 - SETTLED])
    bed = float(conduct_by_bed(packed, own, heat.particle_conductivity or own)[0]) / own
    fits = judge(ratio <= SMALL * bed)
    yield Number("conduction by sharing", ratio, "1", f"at most {SMALL * bed:.3g}", fits, meaning)


def describe_density(case: Case, folder: Path = Path()) -> Iterator[Number]:
    """Density that the gas has by the law of ideal gases at the temperature of particles, fed ones too, inlets or walls
    that is farthest from its own, over the density of the case, which the run takes everywhere unless the gas is an
    ideal one. The case's own files lie in `folder`."""
    heat, gas = case.heat, case.gas
    if not (heat and gas and heat.gas_temperature) or heat.has_ideal_gas or gas.density > _LIQUID:
        return
    fed = [feed.temperature for feed in (case.particles.feeds if case.particles else ())]
    start = start_temperatures(case, folder) if case.particles else None
    held = [heat.particle_temperature] if start is None else [float(start.min()), float(start.max())]
    others = [*held, *fed, *list_wall_temperatures(heat), *list_inlet_temperatures(case)]
    ratios = [heat.gas_temperature / other for other in others if other]
    if not ratios:
        return
    ratio = max(ratios, key=lambda value: abs(math.log(value)))
    meaning = (
        "Density that the gas has, by the law of ideal gases, where it is as warm as the particles, inlets or walls "
        "that are farthest from its own temperature, over that of the case. The run takes the latter everywhere: the "
        'speed of gas that is warmed in the bed is as much too low; heat.gas_density = "ideal" lets the density follow.'
    )
    allowed = f"{1.0 - STEADY:g} to {1.0 + STEADY:g}"
    yield Number("density of warm gas", ratio, "1", allowed, judge(abs(ratio - 1.0) <= STEADY), meaning)


def describe_temperatures(case: Case) -> Iterator[Number]:
    """The lowest of the temperatures that the case gives, of those that are more likely ones in degrees Celsius."""
    if case.heat is None:
        return
    least, largest = CELSIUS
    doubtful = [one for one in list_temperatures(case) if least <= one < largest]
    if doubtful:
        lowest = min(doubtful)
        meaning = f"Temperatures are in K; if {lowest:g} degrees Celsius are meant, give {lowest + 273.15:g}."
        yield Number("lowest temperature", lowest, "K", f"at least {largest:g}", "warn", meaning)


def find_variance(case: Case, cell: float) -> float:
    """Variance [m2], along an axis of cells of the size `cell` [m], of how a particle is shared among them, in the mean
    over its places; of a coarse-grained bed a parcel, in whose diameters the widths are."""
    assert case.exchange and case.particles
    exchange, diameter = case.exchange, find_ratio(case.particles) * case.particles.diameter
    own = {
        "centre": 0.0,
        "trilinear": cell**2 / 6.0,
        "divided": diameter**2 / 20.0,
        "gaussian": 0.5 * ((exchange.kernel_width or 0.0) * diameter) ** 2,
    }[exchange.voidage]
    spread = 0.5 * ((exchange.diffusion_width or 0.0) * diameter) ** 2
    return own + 0.5 * exchange.filter_passes * cell**2 + spread
