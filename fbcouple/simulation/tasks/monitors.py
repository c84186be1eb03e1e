"""What ends a run with exit code 4: limits on what it measures of itself, each named as its option in [monitors].

A limit is held against a number that the run has anyway, of the step or of the history row; the place is looked for
only where it is broken. To add one: an option in the schema and a line in MONITORS.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from operator import gt, le
from typing import Any

import numpy as np

from fbcouple.case.bed.particle_types import particle_count
from fbcouple.coupling.cells import MeshCells
from fbcouple.coupling.kernels import scan_min_max
from fbcouple.errors import DivergedError
from fbcouple.geometry.overlap import find_bounds, find_worst_overlap
from fbcouple.simulation.simulation import Simulation

Numbers = dict[str, Any]
"""What was measured, by its name in the history or in the step; the same on every rank."""
Place = tuple[float, str]
"""How bad the worst place of a rank is, and where it is."""
JUDGED_ONLY = ("voidage_excess", "solids_error", "gas_flux_height")
"""Numbers that no history keeps."""
_MOST_NAMED = 5


@dataclass(frozen=True)
class Monitor:
    """A number, what is said where it breaks its limit, and who finds the place on a rank."""

    number: str
    words: str
    is_sound: Callable[[float, float], bool] = le
    """False for nan, whichever way the limit goes."""
    find_place: Callable[[Simulation], Place] = lambda sim: (0.0, "")


def find_breaches(sim: Simulation, numbers: Numbers) -> list[str]:
    """Options whose limit one of `numbers` breaks."""
    limits = sim.case.monitors
    return [
        option
        for option, monitor in MONITORS.items()
        if monitor.number in numbers and not monitor.is_sound(numbers[monitor.number], getattr(limits, option))
    ]


def judge(sim: Simulation, numbers: Numbers) -> None:
    """Raise DivergedError, with the place, if one of `numbers` breaks its limit (collective)."""
    for option in find_breaches(sim, numbers):
        monitor = MONITORS[option]
        place = max(sim.comm.allgather(monitor.find_place(sim)))[1]
        words = monitor.words.format(**numbers, limit=getattr(sim.case.monitors, option), place=place)
        raise DivergedError(f"at t = {sim.clock.time:.6g} s {words} (monitors.{option})")


def require_finite(sim: Simulation) -> None:
    """Raise DivergedError with the first cell or particle that has a number that is none (collective)."""
    found = next(_find_not_finite(sim), None)
    words = [text for text in sim.comm.allgather(found) if text]
    if words:
        raise DivergedError(f"at t = {sim.clock.time:.6g} s {words[0]}")


def require_finite_gas(sim: Simulation) -> None:
    """The same of this rank's gas alone, after each step."""
    assert sim.gas is not None
    if not sim.gas.is_finite:
        words = next(_find_not_finite(sim), "the gas is too fast for its numbers")
        raise DivergedError(f"after the step from t = {sim.clock.time:.6g} s {words}")


def require_sound_exchange(sim: Simulation) -> None:
    """Raise DivergedError if this rank's voidage or drag is nothing that a gas can be solved with, before it is."""
    assert sim.coupling is not None
    voidage, drag = sim.coupling.gas_input
    least, most, total = scan_min_max(voidage, drag)
    if not math.isfinite(total):
        least, most = voidage.min(initial=1.0), voidage.max(initial=0.0)
    numbers = {"min_voidage": least, "voidage_excess": most - 1.0}
    words = ""
    for option in find_breaches(sim, numbers):
        monitor = MONITORS[option]
        place = monitor.find_place(sim)[1]
        words = monitor.words.format(**numbers, limit=getattr(sim.case.monitors, option), place=place)
        words += f" (monitors.{option})"
    if not words and not math.isfinite(total):
        bad = np.flatnonzero(~np.isfinite(drag).all(axis=1))
        words = f"the drag is not finite: first of {len(bad)} cells of a rank is {name_cell(sim, int(bad[0]))}"
    if words:
        raise DivergedError(f"in the step from t = {sim.clock.time:.6g} s {words}")


def _find_not_finite(sim: Simulation) -> Iterator[str]:
    """What is not finite on this rank, and where first."""
    fields: list[tuple[str, np.ndarray, Callable[[Simulation, int], str]]] = []
    if gas := sim.gas:
        fields.append(("gas velocity", gas.velocity, name_cell))
        fields.append(("pressure", gas.pressure[:, None], name_cell))
        fields.append(("pressure gradient", gas.pressure_gradient, name_cell))
    if sim.coupling:
        fields.append(("voidage", sim.coupling.voidage[:, None], name_cell))
    if sim.liggghts:
        fields.append(("position", sim.liggghts.positions, name_particle))
        fields.append(("velocity", sim.liggghts.velocities, name_particle))
    for what, field, name in fields:
        if np.isfinite(field.sum()):  # a sum is not if one of its numbers is not
            continue
        bad = np.flatnonzero(~np.isfinite(field).all(axis=1))
        if len(bad):
            yield f"the {what} is not finite: first of {len(bad)} of a rank is {name(sim, int(bad[0]))}"


def require_inside(sim: Simulation) -> None:
    """Raise DivergedError if a particle of this rank has its centre behind a wall of the box; in a mesh of another
    shape its cell is looked for in every step."""
    assert sim.liggghts is not None
    if isinstance(sim.cells, MeshCells):
        return
    positions, size = sim.liggghts.positions, np.array(sim.case.domain.size)
    walled = ~np.array(sim.grid.periodic)
    low, high = find_bounds(positions)
    if (walled & ((low < 0.0) | (high > size))).any():
        outside = (((positions < 0.0) | (positions > size)) & walled).any(axis=1)
        words = name_particle(sim, int(outside.argmax()))
        raise DivergedError(f"at t = {sim.clock.time:.6g} s {words} is outside the box, behind a wall")


class LostParticles:
    """Knows where every particle of this rank was when a row was last recorded, and misses those that are lost."""

    def __init__(self, sim: Simulation) -> None:
        bed = sim.case.particles
        self._particles = particle_count(bed) if bed else 0
        if sim.liggghts:
            # LIGGGHTS would end the process with their number alone; they are counted here in every step.
            sim.liggghts.command("thermo_modify lost ignore")
        self._numbers, self._places, self._time = np.empty(0, int), np.empty((0, 3)), 0.0

    def take(self, sim: Simulation) -> None:
        """Remember where they are."""
        assert sim.liggghts is not None
        self._numbers, self._places = sim.liggghts.numbers.copy(), sim.liggghts.positions.copy()
        self._time = sim.clock.time

    def require_all(self, sim: Simulation) -> None:
        """Raise DivergedError if some are lost, with the first of them and where they were (collective)."""
        if sim.liggghts is None or sim.conservation.particles == self._particles:
            return
        require_finite(sim)
        there = np.concatenate(sim.comm.allgather(sim.liggghts.numbers.copy()))
        seen = dict(zip(self._numbers.tolist(), self._places.tolist(), strict=True))
        everybody: dict[int, list[float]] = {}
        for part in sim.comm.allgather(seen):
            everybody |= part
        missing = np.setdiff1d(np.arange(1, self._particles + 1), there).tolist()
        named = [
            f"{n}, last seen at {_word_point(everybody[n])} at t = {self._time:.6g} s" if n in everybody else str(n)
            for n in missing[:_MOST_NAMED]
        ]
        lost = self._particles - sim.conservation.particles
        raise DivergedError(
            f"at t = {sim.clock.time:.6g} s {lost} of {self._particles} particles are lost, they left the box: "
            f"particle {'; particle '.join(named)}; use more DEM steps per contact or a stiffer contact"
        )


def name_cell(sim: Simulation, cell: int) -> str:
    """Name this rank's `cell` by its number, three of them in a box, and its centre."""
    assert sim.gas is not None
    number = sim.owned[cell].tolist()
    return f"cell {tuple(number) if len(number) > 1 else number[0]} at {_word_point(sim.gas.centres[cell])}"


def name_particle(sim: Simulation, row: int) -> str:
    """Name this rank's particle of `row` by its number and its place."""
    assert sim.liggghts is not None
    return f"particle {sim.liggghts.numbers[row]} at {_word_point(sim.liggghts.positions[row])}"


def _word_point(point: Any) -> str:
    return f"({', '.join(f'{x:.6g}' for x in point)}) m"


def _find_fastest_gas(sim: Simulation) -> Place:
    assert sim.gas is not None
    if not len(sim.owned):
        return 0.0, ""
    speeds = np.linalg.norm(sim.gas.velocity, axis=1)
    cell = int(speeds.argmax())
    return float(speeds[cell]), f"{speeds[cell]:.4g} m/s in {name_cell(sim, cell)}"


def _find_voidage(sim: Simulation, sign: float) -> Place:
    assert sim.coupling is not None
    if not len(sim.owned):
        return -np.inf, ""
    voidage = sign * sim.coupling.voidage
    cell = int(voidage.argmax())
    return float(voidage[cell]), name_cell(sim, cell)


def _find_overlap(sim: Simulation) -> Place:
    assert sim.liggghts is not None
    positions = sim.liggghts.ghost_positions()
    overlap, row, other = find_worst_overlap(positions, sim.liggghts.ghost_radii(), sim.liggghts.count)
    return overlap, f"{name_particle(sim, row)}, the other at {_word_point(positions[other])}" if row >= 0 else ""


MONITORS: dict[str, Monitor] = {
    "momentum": Monitor(
        "momentum_error",
        "gas and particles disagree on the momentum exchanged: {momentum_error:.3g} of the impulse, allowed {limit:g}",
    ),
    "courant": Monitor(
        "courant_ratio",
        "the Courant number is {courant_ratio:.4g} times gas.max_courant, allowed {limit:g}; fastest gas: {place}",
        find_place=_find_fastest_gas,
    ),
    "inflow": Monitor(
        "inflow_error",
        "gas comes in by the inlet at {inflow:.6g} m/s over its area and the case asks for {inflow_asked:.6g} m/s: "
        "{inflow_error:.3g} of the fastest, allowed {limit:g}; set the run up again, or mend the inlet in CFD/0/U",
    ),
    "substeps": Monitor("substeps", "a fluid step has {substeps} DEM steps, allowed {limit}"),
    "voidage": Monitor(
        "min_voidage",
        "the voidage is {min_voidage:.4g} in {place}, above {limit:g} is allowed",
        gt,
        lambda sim: _find_voidage(sim, -1.0),
    ),
    "voidage_excess": Monitor(
        "voidage_excess",
        "the voidage is 1 + {voidage_excess:.3g} in {place}, 1 + {limit:g} is allowed",
        find_place=lambda sim: _find_voidage(sim, 1.0),
    ),
    "overlap": Monitor(
        "max_overlap",
        "two particles overlap by {max_overlap:.4g} of their mean diameter, allowed {limit:g}: one is {place}",
        find_place=_find_overlap,
    ),
    "solids_volume": Monitor(
        "solids_error", "the solids that the gas sees are {solids_error:.3g} of their volume off, allowed {limit:g}"
    ),
    "gas_flux": Monitor(
        "gas_flux_error",
        "the gas flux at z = {gas_flux_height:.4g} m is {gas_flux_error:.3g} of the inflow off, allowed {limit:g}",
    ),
}
