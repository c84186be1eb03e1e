"""Numbers that tell before a run whether a case can work: steps against response times, cells, bed and gas."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

from fbcouple.case.bed.cadences import watch_cadences
from fbcouple.case.bed.contact_numbers import tell_creep, time_contacts
from fbcouple.case.bed.derived import fastest_inlet, inlet_ramp, inlet_range, inlet_rows
from fbcouple.case.bed.drag_balance import minimum_fluidization, terminal_velocity
from fbcouple.case.bed.exchange_numbers import measure_cells, time_exchange
from fbcouple.case.bed.feeds import count_fed
from fbcouple.case.bed.fluid_step import gas_step
from fbcouple.case.bed.gas_heat import warm_gas
from fbcouple.case.bed.heat_numbers import describe_conduction, describe_density, describe_temperatures
from fbcouple.case.bed.number import Law, Number
from fbcouple.case.bed.number import judge as _judge
from fbcouple.case.bed.opening_numbers import describe_openings, describe_traffic
from fbcouple.case.bed.parcel_numbers import describe_parcels, measure_bubbles
from fbcouple.case.bed.particle_types import (
    grain_count,
    grains_per_parcel,
    mean_density,
    mean_volume,
    solids_volume,
)
from fbcouple.case.bed.region import Region, count_baffles, find_region, list_inner_surfaces
from fbcouple.case.bed.rest_overlap import estimate_rest_overlap
from fbcouple.case.bed.slips import compare_slips
from fbcouple.case.bed.speeds import SETTLED, estimate_overlap
from fbcouple.case.bed.stacks import watch_columns
from fbcouple.case.bed.start_numbers import describe_start
from fbcouple.case.bed.step_limits import Limits, measure_limits
from fbcouple.case.bed.streams import has_openings
from fbcouple.case.bed.thin_cells import find_widths, look_for_slivers
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import OWN
from fbcouple.errors import CaseError

LEANING = 45.0
"""Angle [deg] to the vertical from which on an inlet is one in a side."""
ROUND = 0.1
"""Length of the mean normal of an inlet below which it looks all around: that of a plane patch is 1."""
HARDLY = 0.002
"""Part of a mesh that a bed fills below which its length may be in another unit: inches for m are 6e-5."""
JET = 0.5
"""Area of the inlet over the column's cross-section below which the gas is a jet into a bed that rests beside it."""
TURBULENT = 2300.0
"""Bulk Reynolds number below which gas in a duct is laminar."""


def estimate(case: Case, law: Law | None = None, folder: Path = Path()) -> list[Number]:
    """Return the pre-flight numbers of a case that passed its checks; a case gets only those that apply to it.

    law: the case's own drag law; without it a case that has one gets no numbers of its drag. folder: where the case's
    own files lie.

    Raises: CaseError if a value is so large or small that they cannot be calculated.
    """
    region = find_region(case, folder)
    parts: list[Callable[[Case], Iterator[Number]]] = [partial(_size_up, folder=folder)]
    if case.particles:
        parts += [partial(describe_parcels, region=region), partial(_tell_start, folder=folder)]
        parts.append(partial(describe_traffic, folder=folder))
    if case.particles and case.contact:
        parts += [time_contacts, partial(estimate_overlap, region=region, law=law, folder=folder)]
    if case.particles and case.gravity > 0.0:
        parts.append(partial(_weigh_bed, region=region))
        if case.contact:
            parts.append(partial(estimate_rest_overlap, region=region))
            parts.append(partial(_watch_rest, law=law, region=region))
            if not (case.gas and case.exchange):
                parts.append(partial(watch_columns, speed=None))
    widths = find_widths(case, folder) if case.gas else None
    limits = measure_limits(case, folder) if case.gas else None
    if limits:
        parts.append(partial(_time_gas, limits=limits))
        if widths is not None:
            parts.append(partial(look_for_slivers, widths=widths, folder=folder))
        parts.append(partial(_look_at_inlet, region=region))
        if has_openings(case):
            parts.append(partial(describe_openings, region=region, folder=folder))
    if case.gas and case.heat:
        parts.append(partial(describe_density, folder=folder))
    parts.append(describe_temperatures)
    if case.gas and case.particles and case.exchange:
        parts.append(partial(measure_cells, cell=region.spacing))
        parts.append(partial(describe_conduction, cell=np.asarray(region.spacing)))
        if law or case.exchange.drag != OWN:
            parts.append(partial(time_exchange, law=law, limits=limits))
            parts += [partial(_fluidize, law=law, region=region), partial(compare_slips, law=law)]
    parts.append(partial(watch_cadences, limits=limits))
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            return [number for part in parts for number in part(case)]
    except ArithmeticError:
        text = "the values are too large or too small to calculate with; give every one in SI units."
        raise CaseError([f"case: {text}"]) from None


def require_fit(case: Case, law: Law | None = None, folder: Path = Path()) -> None:
    """Raise CaseError, one text a number, if a pre-flight number says that the case cannot work."""
    mend = "fix the case, or set it up all the same with --force."
    problems = [
        f"{number.name}: {number.format()} is expected, {number.limit} is fit; {mend} {number.meaning}"
        for number in estimate(case, law, folder)
        if number.verdict == "unfit"
    ]
    if problems:
        raise CaseError(problems)


def _size_up(case: Case, folder: Path) -> Iterator[Number]:
    if case.particles:
        yield Number("particles", _as_count(grain_count(case.particles)), "1", None, None, "Particles in the bed.")
        if case.particles.feeds:
            meaning = "Particles that the feeds bring up to the end, if none of them has to wait for a place."
            fed = count_fed(case) * grains_per_parcel(case.particles)
            yield Number("particles fed", round(fed), "1", None, None, meaning)
    if case.gas:
        yield Number("cells", find_region(case, folder).cells, "1", None, None, "Cells of the gas mesh.")
    if case.domain.shape == "file":
        yield from _tell_box(case, find_region(case, folder))
    for name, faces in list_inner_surfaces(case, folder).items():
        meaning = f"Faces of the surface {name} between two cells: no wall; gas and particles pass through it."
        yield Number("inner faces", faces, "1", "none", "warn", meaning)
    yield from _tell_baffles(case, folder)


def _tell_baffles(case: Case, folder: Path) -> Iterator[Number]:
    faces, unseen = count_baffles(case, folder)
    if not faces:
        return
    meaning = "Faces of walls without thickness in the mesh: wall on both sides, to gas and particles."
    if not unseen:
        yield Number("baffle faces", faces, "1", None, None, meaning)
        return
    meaning += f" {unseen} of them are parts one cell wide between free edges: drag, voidage and filter reach across"
    yield Number("baffle faces", faces, "1", "two cells wide", "warn", f"{meaning} these as if they were not there.")


def _as_count(value: float) -> float:
    """A whole number as such: it is told in all its digits."""
    return int(value) if value == int(value) else value


def _tell_box(case: Case, region: Region) -> Iterator[Number]:
    """Of a mesh from a file: how large it is, and how finely its results are sampled; a unit that is wrong shows."""
    for axis, size, low in zip("xyz", case.domain.size, region.corner, strict=True):
        yield Number(f"mesh {axis}", size, "m", None, None, f"The mesh goes from {low:.6g} to {low + size:.6g} m.")
    meaning = f"Places that results are sampled at: {' x '.join(map(str, case.domain.cells))} (domain.cells)."
    yield Number("sampling grid", math.prod(case.domain.cells), "1", None, None, meaning)
    if case.particles:
        part = solids_volume(case.particles) / SETTLED / region.volume
        meaning = "Part of the mesh that the settled bed fills; less if a length is not in m (domain.scale)."
        yield Number("filled part", part, "1", f"above {HARDLY:g}", _judge(part > HARDLY), meaning)


def _tell_start(case: Case, folder: Path) -> Iterator[Number]:
    for name, value, unit, limit, fits, meaning in describe_start(case, folder):
        yield Number(name, value, unit, limit, _judge(fits), meaning)


def _weigh_bed(case: Case, region: Region) -> Iterator[Number]:
    assert case.particles is not None
    solids = solids_volume(case.particles)
    verdict, meaning = None, "Bed at rest, solids fraction 0.60."
    if case.particles.feeds:
        solids += count_fed(case) * mean_volume(case.particles)
        meaning = "Bed at rest, solids fraction 0.60, with all that the feeds bring, as if none left."
    height = region.find_level(solids / SETTLED)
    if not case.particles.feeds or height < region.height:
        verdict = _judge(height < region.height, "unfit")
    elif not case.particles.outlets:
        verdict, meaning = "warn", f"{meaning} There is no room for all of it: the feeds will owe the rest."
    yield Number("settled height", height, "m", f"below {region.height:g}", verdict, meaning)
    if case.gas:
        meaning = (
            "Settled height over the cell's: the surface is smeared over a cell, one more a filter pass, and beds "
        )
        meaning += "5-14 cells high cost 6-12 % less pressure than the drag law at their mean voidage."
        yield Number("bed height in cells", height / float(region.spacing[2]), "cells", None, None, meaning)
        drop = SETTLED * height * (mean_density(case.particles) - case.gas.density) * case.gravity
        meaning = "Weight less buoyancy over the bed's mean cross-section: of a bed that is fluidized as a whole."
        yield Number("pressure drop", drop, "Pa", None, None, meaning)


def _watch_rest(case: Case, law: Law | None, region: Region) -> Iterator[Number]:
    """Does friction have to hold the bed at rest: no gas, at some time less than fluidizes it, or a jet and a bed that
    rests beside it?"""
    assert case.particles is not None
    slowest, onset = 0.0, math.inf
    if case.gas:
        slowest = _spread_out(case, max(inlet_range(case.gas, 0.0, case.end_time)[0], 0.0), region)
        known = case.exchange and (law or case.exchange.drag != OWN)
        heavier = mean_density(case.particles) > case.gas.density
        onset = (minimum_fluidization(case, law=law) if heavier else 0.0) if known else 0.0
    passes = (
        [inlet.area or 0.0 for inlet in case.gas.inlets if any(v for _, v in inlet_rows(inlet))] if case.gas else []
    )
    jet = (sum(passes) or region.inlet) < JET * region.section
    yield from tell_creep(case, rests=slowest == 0.0 or slowest < onset or (case.gas is not None and jet))


def _time_gas(case: Case, limits: Limits) -> Iterator[Number]:
    assert case.gas is not None
    meaning = "What the Courant limit at U_f/0.40, the Fourier limit and max_step allow; a lively bed takes less."
    yield Number("fluid step", gas_step(case, limits=limits), "s", None, None, meaning)
    meaning = "Superficial velocity through the open faces of the inlet."
    if case.gas.inlets:
        meaning = (
            "Superficial velocity of the fastest inlet, in the middle of its profile, as the faces of the mesh have it."
        )
    yield Number("open inlet velocity", limits.jet, "m s-1", None, None, meaning)
    within, whole = max(map(abs, inlet_range(case.gas, 0.0, case.end_time))), fastest_inlet(case.gas)
    if whole > within:
        meaning = (
            f"Fastest inflow up to end_time; the ramp goes on after it, to {whole:.4g} m/s. Springs, steps and "
            "verdicts take all of the ramp, for a run that is made longer: end it at end_time if this one is not."
        )
        yield Number("inflow in the run", within, "m s-1", f"that of the ramp, {whole:.4g}", "warn", meaning)
    if case.gas.turbulence != "none":
        reynolds = fastest_inlet(case.gas) * case.domain.size[0] * case.gas.density / case.gas.viscosity
        meaning = "Of the superficial velocity and the bed's width; a sub-grid model adds nothing to laminar gas."
        limit = f"above {TURBULENT:g} (gas.turbulence)"
        yield Number("bulk Reynolds number", reynolds, "1", limit, _judge(reynolds > TURBULENT), meaning)


def _look_at_inlet(case: Case, region: Region) -> Iterator[Number]:
    """Of a mesh from a file: gas may come in by any patch, gravity acts along -z."""
    assert case.gas is not None
    if case.domain.shape != "file":
        return
    angle, way = 90.0, "all around"
    if (along := math.hypot(*region.direction)) > ROUND:
        inward = [part / along for part in region.direction]
        angle = math.degrees(math.acos(max(-1.0, min(1.0, inward[2]))))
        way = "along (" + ", ".join(f"{round(part, 3) + 0.0:g}" for part in inward) + ")"
    where = "bottom" if angle < LEANING else "top" if angle > 180.0 - LEANING else "side"
    meaning = f"Gas enters from the {where}, {way}, and gravity acts along (0, 0, -1)."
    if where != "bottom":
        meaning = f"{meaning} Turn the mesh if its own up is another axis; domain.inlet names the patch."
    yield Number("inlet direction", angle, "deg", f"below {LEANING:g} from +z", _judge(where == "bottom"), meaning)


def _spread_out(case: Case, velocity: float, region: Region) -> float:
    """Superficial velocity [m/s] in the mean cross-section of the settled bed of gas that comes in at `velocity`."""
    assert case.particles is not None
    solids = solids_volume(case.particles)
    if not solids:
        return velocity * region.inlet / region.section
    return velocity * region.inlet * region.find_level(solids / SETTLED) * SETTLED / solids


def _fluidize(case: Case, law: Law | None, region: Region) -> Iterator[Number]:
    """Of gas that flows up; its velocity is that of the column where the inlet is a part of its cross-section, of an
    ideal gas once it is as warm as the particles."""
    case = warm_gas(case)
    assert case.gas is not None and case.particles is not None
    if case.gravity == 0.0 or mean_density(case.particles) <= case.gas.density:
        return
    fastest = max(velocity for _, velocity in inlet_ramp(case.gas))
    terminal = terminal_velocity(case, law)
    if fastest <= 0.0:
        yield Number("terminal velocity", terminal, "m s-1", None, None, "Fall speed of a lone particle.")
        yield from watch_columns(case, None)
        return
    onset, there = minimum_fluidization(case, law=law), _spread_out(case, fastest, region)
    meaning = "U_mf of the case's drag law at voidage 0.40; below it the bed stays packed."
    if case.heat and case.heat.has_ideal_gas:
        meaning += " Both of gas that is as warm as the particles at the start."
    yield Number("minimum fluidization", onset, "m s-1", f"below U_f = {there:g}", _judge(onset < there), meaning)
    yield from watch_columns(case, there, law)
    yield from measure_bubbles(case, region, there - onset)
    above = fastest * region.inlet / region.section
    if any(outlet.face == "top" for outlet in case.particles.outlets):
        meaning = "Fall speed of a lone particle; more gas carries it out by the top, which is open to particles."
        yield Number("terminal velocity", terminal, "m s-1", None, None, meaning)
        return
    meaning = "Fall speed of a lone particle; more gas carries it to the outlet, a wall for particles, where it stays."
    yield Number("terminal velocity", terminal, "m s-1", f"above U_f = {above:g}", _judge(terminal > above), meaning)
