"""What the gas of a case with heat is like: conductivity, Prandtl number, capacity, and its walls."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fbcouple.case.bed.derived import fastest_inlet, inlet_ramp
from fbcouple.case.bed.streams import list_streams
from fbcouple.case.schema.gas import Gas
from fbcouple.case.schema.heat import Heat
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.sides import SIDES

TURBULENT_PRANDTL = 0.9
"""Of what the sub-grid model mixes: its kinematic viscosity over its thermal diffusivity."""


def find_conductivity(heat: Heat, gas: Gas) -> float:
    """Thermal conductivity of the gas [W/(m K)]."""
    assert heat.gas_specific_heat is not None
    if heat.prandtl is not None:
        return gas.viscosity * heat.gas_specific_heat / heat.prandtl
    assert heat.gas_conductivity is not None
    return heat.gas_conductivity


def find_prandtl(heat: Heat, gas: Gas) -> float:
    """Prandtl number of the gas [1]."""
    assert heat.gas_specific_heat is not None
    return heat.prandtl or gas.viscosity * heat.gas_specific_heat / find_conductivity(heat, gas)


def find_capacity(heat: Heat, gas: Gas) -> float:
    """Heat capacity of the gas [J/(m3 K)]."""
    assert heat.gas_specific_heat is not None
    return gas.density * heat.gas_specific_heat


def has_inlet_temperatures(case: Case) -> bool:
    """Does gas come in by an inlet with a temperature of its own?"""
    if case.heat is None or case.gas is None:
        return False
    return any(stream.temperature is not None and stream.comes_in for stream in list_streams(case))


def list_inlet_temperatures(case: Case) -> list[float]:
    """Temperatures [K] of the gas of each inlet that ever lets gas in."""
    assert case.heat is not None and case.heat.gas_temperature is not None
    return [stream.temperature or case.heat.gas_temperature for stream in list_streams(case) if stream.comes_in]


def warm_gas(case: Case) -> Case:
    """Of an ideal gas the case whose gas, its density and its inflow, is as warm as the particles are at the start,
    which it is soon after it has come in; any other case as it is."""
    heat, gas = case.heat, case.gas
    if gas is None or heat is None or not heat.has_ideal_gas:
        return case
    start, warm = heat.gas_temperature, heat.particle_temperature
    if start is None or warm is None:
        return case
    update: dict[str, Any] = {"density": gas.density * start / warm}
    if gas.inlets:
        areas = [(inlet.area or 0.0) * warm / (inlet.temperature or start) for inlet in gas.inlets]
        pairs = zip(gas.inlets, areas, strict=True)
        update["inlets"] = tuple(inlet.model_copy(update={"area": area}) for inlet, area in pairs)
    else:
        rows = tuple((time, velocity * warm / start) for time, velocity in inlet_ramp(gas))
        update |= {"inlet_velocity": None, "inlet_ramp": rows}
    return case.model_copy(update={"gas": gas.model_copy(update=update)})


def speed_up_gas(case: Case) -> Case:
    """The case with its gas as it comes in, or as warm as the particles are (`warm_gas`), whichever is faster."""
    warm = warm_gas(case)
    if warm is case:
        return case
    assert case.gas is not None and warm.gas is not None
    return warm if fastest_inlet(warm.gas) > fastest_inlet(case.gas) else case


def has_hot_walls(heat: Heat) -> bool:
    """Has a wall a temperature?"""
    return bool(list_wall_temperatures(heat))


def list_wall_temperatures(heat: Heat) -> list[float]:
    """Temperatures [K] of the walls that have one."""
    given = heat.wall_temperature, *(wall.temperature for wall in heat.walls)
    return [temperature for temperature in given if temperature is not None]


def list_temperatures(case: Case) -> list[float]:
    """Temperatures [K] that a case with heat gives gas, inlets, particles, feeds and walls; without those in files."""
    heat = case.heat
    assert heat is not None
    phases = heat.gas_temperature, heat.particle_temperature
    fed = [feed.temperature for feed in (case.particles.feeds if case.particles else ())]
    inlets = list_inlet_temperatures(case) if case.gas else []
    return [one for one in (*phases, *fed, *inlets, *list_wall_temperatures(heat)) if one]


def list_walls(heat: Heat) -> np.ndarray:
    """Temperature [K] and coefficient [W/(m2 K)] of walls, (7, 2), nan where there is none: of those on no side of the
    box around the region, then at its low and high x, y and z."""
    rows = np.full((1 + len(SIDES), 2), math.nan)
    rows[0] = _as_row(heat.wall_temperature, heat.wall_coefficient)
    for side, (axis, end) in SIDES.items():
        rows[1 + 2 * axis + end] = _as_row(*heat.find_wall(side))
    return rows


def _as_row(temperature: float | None, coefficient: float | None) -> tuple[float, float]:
    return (math.nan if temperature is None else temperature, math.nan if coefficient is None else coefficient)


def is_inlet_closed(gas: Gas) -> bool:
    """Does no gas ever pass any inlet?"""
    return fastest_inlet(gas) == 0.0


def is_inlet_hot_wall(case: Case) -> bool:
    """Does no gas ever pass the inlet, and has the wall that it then is a temperature? Of a mesh from a file, whose
    inlet may lie anywhere, any wall counts."""
    if case.heat is None or case.gas is None or not is_inlet_closed(case.gas):
        return False
    if case.domain.shape == "file":
        return has_hot_walls(case.heat)
    return case.heat.find_wall("floor")[0] is not None
