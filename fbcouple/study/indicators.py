"""Indicators by which a run is judged stable, inaccurate or unstable, as a registry.

To add one: a function under `@indicator("name", inaccurate, unstable)` that gives a number from the history rows of a
run (of one that blew up as well); above the limits the run is called so. A run is as bad as its worst indicator.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from fbcouple.case.bed import derived
from fbcouple.case.bed.drag_balance import EXPANDED
from fbcouple.case.bed.gas_heat import list_inlet_temperatures, list_temperatures
from fbcouple.case.bed.particle_types import count_kinds, list_kinds, mean_kind
from fbcouple.case.schema.sections import Case

Row = dict[str, Any]
Verdict = Literal["stable", "inaccurate", "unstable"]
WORST: tuple[Verdict, ...] = ("stable", "inaccurate", "unstable")
NEVER = math.inf
_MASS = "gas_mass_error"


@dataclass(frozen=True)
class Indicator:
    """An indicator: its function, and the values above which a run is inaccurate and unstable."""

    name: str
    function: Callable[[Case, list[Row]], float]
    inaccurate: float
    unstable: float


INDICATORS: dict[str, Indicator] = {}


def indicator(name: str, inaccurate: float, unstable: float) -> Callable[[Callable[[Case, list[Row]], float]], Any]:
    """Register an indicator."""

    def register(function: Callable[[Case, list[Row]], float]) -> Callable[[Case, list[Row]], float]:
        INDICATORS[name] = Indicator(name, function, inaccurate, unstable)
        return function

    return register


def read_indicators(case: Case, rows: list[Row]) -> dict[str, float]:
    """Every indicator of a run with these history rows; nan where the scene does not have it."""
    return {name: indicator.function(case, rows) for name, indicator in INDICATORS.items()}


def judge(indicators: dict[str, float]) -> tuple[Verdict, str]:
    """The verdict of the worst indicator, and which indicators say so."""
    levels = {
        name: (value > INDICATORS[name].inaccurate) + (value > INDICATORS[name].unstable)
        for name, value in indicators.items()
    }
    worst = max(levels.values(), default=0)
    return WORST[worst], ", ".join(name for name, level in levels.items() if level == worst and worst)


_NO_INFLOW = "gas_flux_error"


def _peak(rows: list[Row], name: str) -> float:
    values = [abs(row[name]) for row in rows if name in row and math.isfinite(row[name])]
    return max(values, default=math.nan)


@indicator("not finite", 0.0, 0.0)
def count_not_finite(case: Case, rows: list[Row]) -> float:
    """Numbers in the history that are not finite; before the first step there is no pressure drop yet, and without
    inflow no gas flux to compare with one."""
    values = [
        v for row in rows if row["steps"] for name, v in row.items() if isinstance(v, float) and name != _NO_INFLOW
    ]
    return float(sum(not math.isfinite(v) for v in values))


@indicator("momentum error", 1e-10, 1e-9)
def find_momentum_error(case: Case, rows: list[Row]) -> float:
    """Largest imbalance of a step over its drag impulse."""
    return _peak(rows, "momentum_error")


@indicator("gas mass error", 1e-3, 1e-1)
def find_mass_error(case: Case, rows: list[Row]) -> float:
    """Largest gas volume lost by continuity over the inflow, where and while gas flows in."""
    if case.gas is None:
        return math.nan
    flows = [derived.inlet_speed(case.gas, row["time"]) > 0.0 for row in rows]
    return _peak([row for row, before, now in zip(rows[1:], flows, flows[1:], strict=False) if before and now], _MASS)


@indicator("over-packed", 0.0, NEVER)
def count_over_packed(case: Case, rows: list[Row]) -> float:
    """Most cells that held more solids than the closest packing."""
    return _peak(rows, "cells_over_packed")


@indicator("solids fraction", 0.9, 1.0)
def find_solids(case: Case, rows: list[Row]) -> float:
    """Largest solids fraction of a cell: above 1 there is no room for gas."""
    least = [row["min_voidage"] for row in rows if "min_voidage" in row]
    return 1.0 - min(least) if least else math.nan


@indicator("overlap", 0.1, 0.5)
def find_overlap(case: Case, rows: list[Row]) -> float:
    """Largest overlap of two particles over their mean diameter."""
    return _peak(rows, "max_overlap")


@indicator("Courant", 1.5, NEVER)
def find_courant(case: Case, rows: list[Row]) -> float:
    """Largest Courant number of the gas."""
    return _peak(rows, "max_courant")


@indicator("gas speed", 3.0, 10.0)
def find_gas_speed(case: Case, rows: list[Row]) -> float:
    """Fastest gas, as the Courant number tells it, over the fastest that the scene has reason for."""
    if case.gas is None:
        return math.nan
    edge = float(derived.cell_size(case).min())
    dem_step = derived.dem_step(case.contact, case.particles) if case.contact and case.particles else 0.0
    speeds = []
    for row, later in pairwise(rows):
        if later["time"] > row["time"] and math.isfinite(later["max_courant"]):
            # While the step grows the last one is the longest of a row.
            mean = (later["time"] - row["time"]) / (later["steps"] - row["steps"])
            speeds.append(later["max_courant"] * edge / max(later["substeps"] * dem_step, mean))
    return max(speeds, default=math.nan) / find_speed(case)


@indicator("kinetic energy", 2.0, 20.0)
def find_kinetic_energy(case: Case, rows: list[Row]) -> float:
    """Largest kinetic energy of the particles over that of all of them at the fastest speed that the scene gives."""
    if case.particles is None:
        return math.nan
    return _peak(rows, "kinetic_energy") / (0.5 * _mass(case) * find_speed(case) ** 2)


@indicator("energy gained", 0.02, 0.5)
def find_energy_gain(case: Case, rows: list[Row]) -> float:
    """Without gas: kinetic and potential energy above that of the start, over that of a fall through the box."""
    if case.particles is None or case.gas or case.gravity == 0.0:
        return math.nan
    weight = _mass(case) * case.gravity
    energies = [row["kinetic_energy"] + weight * row["solids_centre_z"] for row in rows]
    return (max(energies) - energies[0]) / (weight * case.domain.size[2])


SETTLED_AFTER = 4.0
"""Falls through the box after which a bed without gas has come to rest, if it ever does."""
LAST = 5
"""History rows that say whether it has."""


@indicator("heat error", 1e-12, 1e-9)
def find_heat_error(case: Case, rows: list[Row]) -> float:
    """Largest error of a step's ledger of heat over the heat held."""
    return _peak(rows, "heat_error")


@indicator("temperature", 1e-9, 1e-2)
def find_strange_temperature(case: Case, rows: list[Row]) -> float:
    """Farthest temperature of a cell or particle outside those that the scene gives gas, inlets, particles, feeds and
    walls, over their range."""
    heat = case.heat
    if heat is None:
        return math.nan
    given = list_temperatures(case)
    below = min(given) - min(row["min_temperature"] for row in rows)
    above = max(row["max_temperature"] for row in rows) - max(given)
    return max(0.0, below, above) / (max(given) - min(given) or max(given))


@indicator("residual speed", 3e-3, 5e-2)
def find_residual_speed(case: Case, rows: list[Row]) -> float:
    """Without gas, long after the fall: speed of the particles that does not decay, over sqrt(g d) (collective creep
    and the heat of too few contact steps); d is the diameter of what creeps, a parcel of a coarse-grained bed, and of
    several sizes the Sauter mean."""
    if case.particles is None or case.gas or case.gravity == 0.0:
        return math.nan
    if rows[-1]["time"] < SETTLED_AFTER * math.sqrt(2.0 * case.domain.size[2] / case.gravity):
        return math.nan
    energy = float(np.mean([row["kinetic_energy"] for row in rows[-LAST:]]))
    return math.sqrt(2.0 * energy / _mass(case) / (case.gravity * mean_kind(case.particles).diameter))


def find_speed(case: Case) -> float:
    """Speed [m/s] that a scene has reason for: its gas between packed particles, as warm as an ideal one may get, and a
    fall through the box."""
    gas = derived.open_velocity(case) / (EXPANDED if case.particles else 1.0) if case.gas else 0.0
    heat = case.heat
    if heat and heat.has_ideal_gas and heat.gas_temperature:
        gas *= max(list_temperatures(case)) / min([*list_inlet_temperatures(case), heat.gas_temperature])
    return gas + math.sqrt(2.0 * case.gravity * case.domain.size[2]) or 1.0


def _mass(case: Case) -> float:
    assert case.particles is not None
    kinds = list_kinds(case.particles)
    return sum(n * kind.mass for n, kind in zip(count_kinds(case.particles), kinds, strict=True))


def list_limits() -> Iterator[Row]:
    """A row for each indicator, for the tables of a study."""
    for one in INDICATORS.values():
        yield {"indicator": one.name, "inaccurate": one.inaccurate, "unstable": one.unstable}
