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
from fbcouple.coupling.kernels import look_over
from fbcouple.errors import DivergedError
from fbcouple.geometry.overlap import find_bounds, find_worst_overlap
from fbcouple.simulation.simulation import Scene

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
    find_place: Callable[[Scene], Place] = lambda scene: (0.0, "")


def find_breaches(scene: Scene, numbers: Numbers) -> list[str]:
    """Options whose limit one of `numbers` breaks."""
    limits = scene.case.monitors
    return [
        option
        for option, monitor in MONITORS.items()
        if monitor.number in numbers and not monitor.is_sound(numbers[monitor.number], getattr(limits, option))
    ]


def judge(scene: Scene, numbers: Numbers) -> None:
    """Raise DivergedError, with the place, if one of `numbers` breaks its limit (collective)."""
    for option in find_breaches(scene, numbers):
        monitor = MONITORS[option]
        place = max(scene.comm.allgather(monitor.find_place(scene)))[1]
        words = monitor.words.format(**numbers, limit=getattr(scene.case.monitors, option), place=place)
        raise DivergedError(f"at t = {scene.clock.time:.6g} s {words} (monitors.{option})")


def require_finite(scene: Scene) -> None:
    """Raise DivergedError with the first cell or particle that has a number that is none (collective)."""
    found = next(_find_not_finite(scene), None)
    words = [text for text in scene.comm.allgather(found) if text]
    if words:
        raise DivergedError(f"at t = {scene.clock.time:.6g} s {words[0]}")


def require_finite_gas(scene: Scene) -> None:
    """The same of this rank's gas alone, after each step."""
    assert scene.gas is not None
    if not scene.gas.is_finite:
        words = next(_find_not_finite(scene), "the gas is too fast for its numbers")
        raise DivergedError(f"after the step from t = {scene.clock.time:.6g} s {words}")


def require_sound_exchange(scene: Scene) -> None:
    """Raise DivergedError if this rank's voidage or drag is nothing that a gas can be solved with, before it is."""
    assert scene.coupling is not None
    voidage, drag = scene.coupling.gas_input
    least, most, total = look_over(voidage, drag)
    if not math.isfinite(total):
        least, most = voidage.min(initial=1.0), voidage.max(initial=0.0)
    numbers = {"min_voidage": least, "voidage_excess": most - 1.0}
    words = ""
    for option in find_breaches(scene, numbers):
        monitor = MONITORS[option]
        place = monitor.find_place(scene)[1]
        words = monitor.words.format(**numbers, limit=getattr(scene.case.monitors, option), place=place)
        words += f" (monitors.{option})"
    if not words and not math.isfinite(total):
        bad = np.flatnonzero(~np.isfinite(drag).all(axis=1))
        words = f"the drag is not finite: first of {len(bad)} cells of a rank is {name_cell(scene, int(bad[0]))}"
    if words:
        raise DivergedError(f"in the step from t = {scene.clock.time:.6g} s {words}")


def _find_not_finite(scene: Scene) -> Iterator[str]:
    """What is not finite on this rank, and where first."""
    fields: list[tuple[str, np.ndarray, Callable[[Scene, int], str]]] = []
    if gas := scene.gas:
        fields.append(("gas velocity", gas.velocity, name_cell))
        fields.append(("pressure", gas.pressure[:, None], name_cell))
        fields.append(("pressure gradient", gas.pressure_gradient, name_cell))
    if scene.coupling:
        fields.append(("voidage", scene.coupling.voidage[:, None], name_cell))
    if scene.grains:
        fields.append(("position", scene.grains.positions, name_particle))
        fields.append(("velocity", scene.grains.velocities, name_particle))
    for what, field, name in fields:
        if np.isfinite(field.sum()):  # a sum is not if one of its numbers is not
            continue
        bad = np.flatnonzero(~np.isfinite(field).all(axis=1))
        if len(bad):
            yield f"the {what} is not finite: first of {len(bad)} of a rank is {name(scene, int(bad[0]))}"


def require_inside(scene: Scene) -> None:
    """Raise DivergedError if a particle of this rank has its centre behind a wall of the box; in a mesh of another
    shape its cell is looked for in every step."""
    assert scene.grains is not None
    if isinstance(scene.cells, MeshCells):
        return
    positions, size = scene.grains.positions, np.array(scene.case.domain.size)
    walled = ~np.array(scene.grid.periodic)
    low, high = find_bounds(positions)
    if (walled & ((low < 0.0) | (high > size))).any():
        outside = (((positions < 0.0) | (positions > size)) & walled).any(axis=1)
        words = name_particle(scene, int(outside.argmax()))
        raise DivergedError(f"at t = {scene.clock.time:.6g} s {words} is outside the box, behind a wall")


class RollCall:
    """Knows where every particle of this rank was when a row was last recorded, and misses those that are lost."""

    def __init__(self, scene: Scene) -> None:
        bed = scene.case.particles
        self._particles = particle_count(bed) if bed else 0
        if scene.grains:
            # LIGGGHTS would end the process with their number alone; they are counted here in every step.
            scene.grains.command("thermo_modify lost ignore")
        self._numbers, self._places, self._time = np.empty(0, int), np.empty((0, 3)), 0.0

    def take(self, scene: Scene) -> None:
        """Remember where they are."""
        assert scene.grains is not None
        self._numbers, self._places = scene.grains.numbers.copy(), scene.grains.positions.copy()
        self._time = scene.clock.time

    def require_all(self, scene: Scene) -> None:
        """Raise DivergedError if some are lost, with the first of them and where they were (collective)."""
        if scene.grains is None or scene.balance.particles == self._particles:
            return
        require_finite(scene)
        there = np.concatenate(scene.comm.allgather(scene.grains.numbers.copy()))
        seen = dict(zip(self._numbers.tolist(), self._places.tolist(), strict=True))
        everybody: dict[int, list[float]] = {}
        for part in scene.comm.allgather(seen):
            everybody |= part
        missing = np.setdiff1d(np.arange(1, self._particles + 1), there).tolist()
        named = [
            f"{n}, last seen at {_word_point(everybody[n])} at t = {self._time:.6g} s" if n in everybody else str(n)
            for n in missing[:_MOST_NAMED]
        ]
        lost = self._particles - scene.balance.particles
        raise DivergedError(
            f"at t = {scene.clock.time:.6g} s {lost} of {self._particles} particles are lost, they left the box: "
            f"particle {'; particle '.join(named)}; use more DEM steps per contact or a stiffer contact"
        )


def name_cell(scene: Scene, cell: int) -> str:
    """Name this rank's `cell` by its number, three of them in a box, and its centre."""
    assert scene.gas is not None
    number = scene.owned[cell].tolist()
    return f"cell {tuple(number) if len(number) > 1 else number[0]} at {_word_point(scene.gas.centres[cell])}"


def name_particle(scene: Scene, row: int) -> str:
    """Name this rank's particle of `row` by its number and its place."""
    assert scene.grains is not None
    return f"particle {scene.grains.numbers[row]} at {_word_point(scene.grains.positions[row])}"


def _word_point(point: Any) -> str:
    return f"({', '.join(f'{x:.6g}' for x in point)}) m"


def _find_fastest_gas(scene: Scene) -> Place:
    assert scene.gas is not None
    if not len(scene.owned):
        return 0.0, ""
    speeds = np.linalg.norm(scene.gas.velocity, axis=1)
    cell = int(speeds.argmax())
    return float(speeds[cell]), f"{speeds[cell]:.4g} m/s in {name_cell(scene, cell)}"


def _find_voidage(scene: Scene, sign: float) -> Place:
    assert scene.coupling is not None
    if not len(scene.owned):
        return -np.inf, ""
    voidage = sign * scene.coupling.voidage
    cell = int(voidage.argmax())
    return float(voidage[cell]), name_cell(scene, cell)


def _find_overlap(scene: Scene) -> Place:
    assert scene.grains is not None
    positions = scene.grains.ghost_positions()
    overlap, row, other = find_worst_overlap(positions, scene.grains.ghost_radii(), scene.grains.count)
    return overlap, f"{name_particle(scene, row)}, the other at {_word_point(positions[other])}" if row >= 0 else ""


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
        "{inflow_error:.3g} of the fastest, allowed {limit:g}; set the run up again, or mend the inlet in fluid/0/U",
    ),
    "substeps": Monitor("substeps", "a fluid step has {substeps} DEM steps, allowed {limit}"),
    "voidage": Monitor(
        "min_voidage",
        "the voidage is {min_voidage:.4g} in {place}, above {limit:g} is allowed",
        gt,
        lambda scene: _find_voidage(scene, -1.0),
    ),
    "voidage_excess": Monitor(
        "voidage_excess",
        "the voidage is 1 + {voidage_excess:.3g} in {place}, 1 + {limit:g} is allowed",
        find_place=lambda scene: _find_voidage(scene, 1.0),
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
