"""What ends a run with exit code 4: limits on what it measures of itself, each named as its option in [monitors].

A limit is held against a number that the run has anyway, of the step or of the history row; the cell or particle is
looked for only where it is broken. To add one: an option in the schema and a line in MONITORS.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from operator import gt, le
from typing import Any

import numpy as np

from fbcouple.errors import DivergedError
from fbcouple.geometry.overlap import find_worst_overlap
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.soundness import (
    LEDGER,
    VOIDAGE,
    VOIDAGE_EXCESS,
    find_not_finite,
    format_point,
    name_cell,
    name_particle,
)

Numbers = dict[str, Any]
"""What was measured, by its name in the history or in the step; the same on every rank."""
Worst = tuple[float, str]
"""The worst value of a rank, and where it is."""
JUDGED_ONLY = ("voidage_excess", "solids_error", "gas_flux_height")
"""Numbers that no history keeps."""


@dataclass(frozen=True)
class Monitor:
    """A number, the message where it breaks its limit, and who finds the worst on a rank."""

    number: str
    message: str
    is_sound: Callable[[float, float], bool] = le
    """False for nan, whichever way the limit goes."""
    find_worst: Callable[[Simulation], Worst] = lambda sim: (0.0, "")


def find_breaches(sim: Simulation, numbers: Numbers) -> list[str]:
    """Options whose limit one of `numbers` breaks."""
    limits = sim.case.monitors
    return [
        option
        for option, monitor in MONITORS.items()
        if monitor.number in numbers and not monitor.is_sound(numbers[monitor.number], getattr(limits, option))
    ]


def judge(sim: Simulation, numbers: Numbers) -> None:
    """Raise DivergedError, with the worst cell or particle, if one of `numbers` breaks its limit (collective)."""
    for option in find_breaches(sim, numbers):
        monitor = MONITORS[option]
        where = max(sim.comm.allgather(monitor.find_worst(sim)))[1]
        message = monitor.message.format(**numbers, limit=getattr(sim.case.monitors, option), where=where)
        raise DivergedError(f"at t = {sim.time:.6g} s {message} (monitors.{option})")


def require_finite(sim: Simulation) -> None:
    """Raise DivergedError with the first cell or particle that has a number that is none (collective)."""
    fields = (
        sim.gas if sim.has_gas else None,
        sim.coupling if sim.is_coupled else None,
        sim.liggghts if sim.has_particles else None,
    )
    found = next(find_not_finite(sim.owned, *fields), None)
    messages = [text for text in sim.comm.allgather(found) if text]
    if messages:
        raise DivergedError(f"at t = {sim.time:.6g} s {messages[0]}")


def require_inside(sim: Simulation) -> None:
    """Raise DivergedError if a particle of this rank has its centre behind a wall of the box."""
    rows = np.arange(sim.liggghts.count)[sim.rows_inside]
    row = sim.cells.find_outside(sim.liggghts.positions[rows])
    if row is not None:
        name = name_particle(sim.liggghts, int(rows[row]))
        raise DivergedError(f"at t = {sim.time:.6g} s {name} is outside the box, behind a wall")


def _find_fastest_gas(sim: Simulation) -> Worst:
    if not len(sim.owned):
        return 0.0, ""
    speeds = np.linalg.norm(sim.gas.velocity, axis=1)
    cell = int(speeds.argmax())
    return float(speeds[cell]), f"{speeds[cell]:.4g} m/s in {name_cell(sim.owned, sim.gas, cell)}"


def _find_voidage(sim: Simulation, sign: float) -> Worst:
    if not len(sim.owned):
        return -np.inf, ""
    voidage = sign * sim.coupling.voidage
    cell = int(voidage.argmax())
    return float(voidage[cell]), name_cell(sim.owned, sim.gas, cell)


def _find_overlap(sim: Simulation) -> Worst:
    own = sim.liggghts
    positions = own.ghost_positions()
    overlap, row, other = find_worst_overlap(positions, own.ghost_radii(), own.count)
    return overlap, f"{name_particle(own, row)}, the other at {format_point(positions[other])}" if row >= 0 else ""


MONITORS: dict[str, Monitor] = {
    "momentum": Monitor(
        "momentum_error",
        "gas and particles disagree on the momentum exchanged: {momentum_error:.3g} of the impulse, allowed {limit:g}",
    ),
    "courant": Monitor(
        "courant_ratio",
        "the Courant number is {courant_ratio:.4g} times gas.max_courant, allowed {limit:g}; fastest gas: {where}",
        find_worst=_find_fastest_gas,
    ),
    "inflow": Monitor(
        "inflow_error",
        "gas comes in by the inlet at {inflow:.6g} m/s over its area and the case asks for {inflow_asked:.6g} m/s: "
        "{inflow_error:.3g} of the fastest, allowed {limit:g}; set the run up again, or fix the inlet in CFD/0/U",
    ),
    "substeps": Monitor("substeps", "a fluid step has {substeps} DEM steps, allowed {limit}"),
    "voidage": Monitor(
        "min_voidage",
        VOIDAGE,
        gt,
        lambda sim: _find_voidage(sim, -1.0),
    ),
    "voidage_excess": Monitor(
        "voidage_excess",
        VOIDAGE_EXCESS,
        find_worst=lambda sim: _find_voidage(sim, 1.0),
    ),
    "overlap": Monitor(
        "max_overlap",
        "two particles overlap by {max_overlap:.4g} of their mean diameter, allowed {limit:g}: one is {where}",
        find_worst=_find_overlap,
    ),
    "solids_volume": Monitor(
        "solids_error", "the solids that the gas sees are {solids_error:.3g} of their volume off, allowed {limit:g}"
    ),
    "ledger": Monitor("ledger_error", LEDGER),
    "heat": Monitor(
        "heat_error",
        "heat of gas and particles does not add up over a step: {heat_error:.3g} of what they hold, allowed {limit:g}",
    ),
    "gas_flux": Monitor(
        "gas_flux_error",
        "the gas flux at z = {gas_flux_height:.4g} m is {gas_flux_error:.3g} of the inflow off, allowed {limit:g}",
    ),
}
