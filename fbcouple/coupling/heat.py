"""The heat between gas and particles, so that what one gains the other loses, to rounding; for cases with [heat].

As with drag, a particle of mass m and specific heat cp takes H (T - T_p) from the gas, with the exact average over the
step for a gas of constant temperature T:

    H = h A (1 - exp(-x))/x,  x = dt h A/(m cp),  h = Nu k/d,  A = pi d^2

The gas is implicit in H, under the temperatures of the particles as they are. The particles then get H (T - T_p) dt of
the new T at once: T_p + (1 - exp(-x)) (T - T_p), between the two whatever dt is. Writing and reading have the weights
and the filter of drag: the sum over particles of H (T at p - T_p) equals that over cells of K T - S.

All temperatures here are counted from the reference temperature of the case, so that sums keep their digits.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from fbcouple.case.bed.gas_heat import find_conductivity, find_prandtl
from fbcouple.case.bed.particle_types import find_ratio, grains_per_parcel
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_laws import choose_nusselt
from fbcouple.coupling.box.corners import Stencil, corner_weights, read_four
from fbcouple.coupling.discretisation import Space
from fbcouple.coupling.forces import Way
from fbcouple.coupling.negative import NONE, Negative, find_lowest
from fbcouple.coupling.particles import Particles
from fbcouple.physics.elementary import decay
from fbcouple.physics.heat.conductivity import BED_CONDUCTIVITIES
from fbcouple.physics.jit import call_nusselt, compiled, find_address

_BLOCK = 256


class Transfer(NamedTuple):
    """How the heat transfer of a case is found: the address of a law (`physics.jit`), the gas, the particles."""

    law: int
    prandtl: float
    conductivity: float
    """Of the gas [W/(m K)]."""
    reynolds: float
    """Density over viscosity of the gas [s/m2]."""
    specific_heat: float
    """Of the particles [J/(kg K)]."""
    reference: float
    """What temperatures count from [K]."""
    ratio: float
    """Diameter of a parcel over that of its grains, whose heat transfer it has; 1 where particles are no parcels."""
    grains: float
    """Grains of a parcel."""
    is_expanded: bool
    """Of an ideal gas, whose density goes with its temperature."""


@compiled
def deposit_heat(
    transfer: Transfer, stencil: Stencil, velocities, radii, masses, temperatures, gas, dt, coefficients, field
):
    """Add H [W/K] and H T_p [W] of every particle to local `field` (places, 2); H stays in `coefficients` (n,).

    `gas` (places, >= 4) starts with the filtered gas velocity and the voidage, and that of an ideal gas has its density
    over the one of the case in column 7; `temperatures` (n,) [K] are absolute; `dt` [s] is the step to come.
    Returns the lowest Nusselt number below 0, its particle, -1 if there is none, its voidage and Reynolds number.
    """
    lowest = NONE
    base, upper, offsets = stencil.base, stencil.upper, stencil.offsets
    eps, reynolds, nusselt = np.empty(_BLOCK), np.empty(_BLOCK), np.empty(_BLOCK)
    for first in range(0, len(base), _BLOCK):
        n = min(_BLOCK, len(base) - first)
        at, up, v = base[first : first + n], upper[first : first + n], velocities[first : first + n]
        for q in range(n):
            weights = corner_weights(up[q, 0], up[q, 1], up[q, 2])
            ux, uy, uz, eps[q] = read_four(gas, np.uint64(0), at[q], offsets, weights)
            rx, ry, rz = ux - v[q, 0], uy - v[q, 1], uz - v[q, 2]
            slip = np.sqrt(rx * rx + ry * ry + rz * rz)
            reynolds[q] = eps[q] * transfer.reynolds * slip * 2.0 * radii[first + q] / transfer.ratio
        if transfer.is_expanded:
            for q in range(n):
                weights = corner_weights(up[q, 0], up[q, 1], up[q, 2])
                _, _, _, density = read_four(gas, np.uint64(4), at[q], offsets, weights)
                reynolds[q] *= density
        call_nusselt(transfer.law, eps[:n], reynolds[:n], transfer.prandtl, nusselt[:n])
        lowest = find_lowest(first, eps[:n], reynolds[:n], reynolds[:n], nusselt[:n], lowest)
        own = coefficients[first : first + n]
        for q in range(n):
            capacity = masses[first + q] * transfer.specific_heat
            size = 2.0 * radii[first + q] / transfer.ratio
            conductance = transfer.grains * nusselt[q] * transfer.conductivity * np.pi * size
            own[q] = capacity / dt * decay(dt * conductance / capacity)
        for q in range(n):
            weights = corner_weights(up[q, 0], up[q, 1], up[q, 2])
            heat = own[q] * (temperatures[first + q] - transfer.reference)
            for c in range(8):
                place = at[q] + offsets[c]
                field[place, 0] += weights[c] * own[q]
                field[place, 1] += weights[c] * heat
    return lowest[:4]


@compiled
def give_heat(stencil: Stencil, gas, coefficients, masses, specific_heat, reference, dt, temperatures):
    """Change the particles' `temperatures` (n,) [K], in place, by what the gas gives them in `dt` [s].

    `gas` (places, 1): filtered gas temperature, from `reference` [K]. Returns the heat that they got [J].
    """
    base, upper, offsets = stencil.base, stencil.upper, stencil.offsets
    given = 0.0
    for p in range(len(base)):
        weights = corner_weights(upper[p, 0], upper[p, 1], upper[p, 2])
        around = 0.0
        for c in range(8):
            around += weights[c] * gas[base[p] + offsets[c], 0]
        heat = coefficients[p] * (around - (temperatures[p] - reference)) * dt
        temperatures[p] += heat / (masses[p] * specific_heat)
        given += heat
    return given


@compiled
def add_up_heat(masses, temperatures, reference):
    """Sums over particles of m (T - reference), of its magnitude [kg K], and of m [kg]."""
    total, magnitude, mass = 0.0, 0.0, 0.0
    for p in range(len(masses)):
        warm = masses[p] * (temperatures[p] - reference)
        total += warm
        magnitude += abs(warm)
        mass += masses[p]
    return total, magnitude, mass


class HeatExchange:
    """The exchange of heat between this rank's particles and gas cells.

    `sums` (cells, 2), the sums of H [W/K] and H T_p [W] over the particles of each cell, are what the gas step takes.
    `negative` is the particle that the last step takes heat from hardest against its direction, if it does so.
    """

    def __init__(self, case: Case, space: Space) -> None:
        """`space` has the cells; a file of the case's own law lies in the current folder."""
        assert case.heat and case.gas
        heat, gas = case.heat, case.gas
        assert heat.particle_specific_heat is not None and heat.gas_temperature is not None
        law = choose_nusselt(heat, Path()).kernel
        self._kernel, self._law_name = law, heat.nusselt
        self.negative: Negative | None = None
        self._transfer = Transfer(
            find_address(law),
            find_prandtl(heat, gas),
            find_conductivity(heat, gas),
            gas.density / gas.viscosity,
            heat.particle_specific_heat,
            heat.gas_temperature,
            find_ratio(case.particles) if case.particles else 1.0,
            grains_per_parcel(case.particles) if case.particles else 1.0,
            heat.has_ideal_gas,
        )
        self._space = space
        self._written, self._read = space.make_field(2), space.make_field(1)
        self._scratch = {c: space.make_field(c) if space.needs_scratch else field for c, field in self._fields()}
        self.sums = np.zeros((space.halo.owned_count, 2))
        self._coefficients = np.empty(0)
        self._dt = 0.0

    def _fields(self) -> tuple[tuple[int, np.ndarray], ...]:
        return (2, self._written), (1, self._read)

    def deposit(
        self,
        particles: Particles,
        heat: tuple[np.ndarray, np.ndarray],
        way: tuple[Way, int],
        gas: np.ndarray,
        dt: float,
    ) -> None:
        """The heat of the next gas step, averaged over `dt` [s], to the cells (collective).

        heat: masses (n,) [kg] and temperatures (n,) [K] of the particles; way: the mapping, and the layers of the local
        grid that it needs; gas (places, >= 4): filtered velocity and voidage, as `deposit_heat` takes them.
        """
        mapping, layers = way
        count = len(particles.positions)
        if count > len(self._coefficients):
            self._coefficients = np.empty(count + count // 4)
        self._dt = dt
        field = self._written[:layers]
        rows = mapping.open(field)
        own = self._coefficients[:count]
        about = self._transfer, mapping.stencil, particles.velocities, particles.radii, *heat, gas, dt, own, rows
        number, particle, voidage, reynolds = deposit_heat(*about)
        self.negative = None
        if number < 0.0:
            what, place = f"a Nusselt number of {number:.4g}", particles.positions[particle].copy()
            self.negative = Negative(what, "heat.nusselt", self._law_name, place, voidage, reynolds)
        mapping.write(rows, field)
        filtered = self._space.filter_written(field, self._scratch[2][:layers])
        self._space.halo.reverse(filtered[:-1], self.sums)

    def give(self, temperatures: np.ndarray, heat: tuple[np.ndarray, np.ndarray], way: tuple[Way, int]) -> float:
        """Give the particles what the gas, of the new `temperatures` (cells,) [K], loses to them in the step.

        heat: masses (n,) [kg] and temperatures (n,) [K] of the particles, which change. Returns what they got [J]
        (collective).
        """
        mapping, layers = way
        masses, own = heat
        warm = (temperatures - self._transfer.reference)[:, None]
        field = self._read[:layers]
        self._space.halo.forward(warm, field, "heat")
        rows = mapping.read(self._space.average(field, self._scratch[1][:layers]), 1)
        coefficients = self._coefficients[: len(own)]
        about = self._transfer.specific_heat, self._transfer.reference, self._dt
        return give_heat(mapping.stencil, rows, coefficients, masses, *about, own)


class CellConductivity:
    """Conductivity of the cells by their voidage, as `heat.bed_conduction` says."""

    def __init__(self, case: Case) -> None:
        assert case.heat and case.gas
        self._law = BED_CONDUCTIVITIES[case.heat.bed_conduction]
        self._gas = find_conductivity(case.heat, case.gas)
        self._particles = case.heat.particle_conductivity or self._gas

    def find(self, voidage: np.ndarray) -> np.ndarray:
        """Conductivity (cells,) [W/(m K)] at `voidage` (cells,) [1]."""
        return self._law(voidage, self._gas, self._particles)
