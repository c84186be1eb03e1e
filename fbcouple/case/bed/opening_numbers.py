"""Numbers of the inlets and outlets of a case, before a run: areas, velocities, flows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fbcouple.case.bed.derived import fastest_inflow
from fbcouple.case.bed.gas_heat import has_inlet_temperatures
from fbcouple.case.bed.inlet_profile import read_profiles
from fbcouple.case.bed.jets import compare_momentum, count_across
from fbcouple.case.bed.number import Number, judge
from fbcouple.case.bed.openings import Openings, describe, find_stream_areas
from fbcouple.case.bed.outlets import find_open_faces, is_opening, list_openings, read_wall_mesh
from fbcouple.case.bed.region import Region, find_openings
from fbcouple.case.bed.streams import Opening, Stream, find_opening, list_outlets, list_streams
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.imported import list_outlets as list_outlet_patches

WIDE = 3.0
"""Cells across an inlet from which on the mesh has the most of its jet: the faces at its edges are a part of it."""
_AWAY = 0.1
"""Part of the area of an outlet that the faces of the mesh may be off it."""
_EDGE = 1e-3
"""Part of the edge of a square as large as an inlet by which points may go beyond it untold."""


def describe_openings(case: Case, region: Region, folder: Path) -> Iterator[Number]:
    """The flow of each inlet as the mesh lets it through, the area of the outlets, and the velocity of the whole."""
    assert case.gas is not None
    streams, openings = read_profiles(case, list_streams(case), folder), find_openings(case, folder)
    areas = find_stream_areas(openings).tolist()
    for number, (stream, area) in enumerate(zip(streams, areas, strict=True), start=1):
        times, velocities = np.array(stream.rows).T
        velocity = float(velocities[np.abs(velocities).argmax()])
        when = f"at most, over {len(times)} rows of time" if len(times) > 1 else "all the time"
        warm = "" if stream.temperature is None else f", {stream.temperature:g} K"
        meaning = f"{describe(stream.opening)}: {area:.7g} m2 of the mesh, {velocity:g} m s-1 {when}{warm}."
        yield Number(f"inlet {number}", area * velocity, "m3 s-1", None, None, meaning)
        beyond = 0.0 if isinstance(stream.profile, str) else stream.profile.beyond
        if stream.opening.shape is not None and not stream.is_closed:
            yield from _count_cells(case, streams, openings, number)
        if beyond > _EDGE * math.sqrt(area):
            meaning = f"How far the file of its profile goes beyond inlet {number}: what lies there is not used. "
            meaning += "Right if it is of a larger section; wrong if its lengths are in another unit."
            yield Number(f"profile beyond inlet {number}", beyond, "m", "none", "warn", meaning)
    meaning = "Superficial velocity of all inlets together in the mean cross-section, at the fastest."
    if has_inlet_temperatures(case):
        meaning += " The gas of each is as warm as it comes in."
    whole = fastest_inflow(case.gas) * region.inlet / region.section
    yield Number("superficial velocity", whole, "m s-1", None, None, meaning)
    if case.gas.outlets:
        patches = list_outlet_patches(openings.mesh)
        for number, (outlet, patch) in enumerate(zip(list_outlets(case), patches, strict=True), start=1):
            yield _measure_outlet(f"area of outlet {number}", outlet, openings.mesh.find_area(patch))


def describe_traffic(case: Case, folder: Path) -> Iterator[Number]:
    """Feeds and outlets of particles that never begin, and the area of each opening in the walls of a region that is no
    box, by which particles leave."""
    assert case.particles is not None
    for key in ("feeds", "outlets"):
        for number, one in enumerate(getattr(case.particles, key), start=1):
            if one.start >= case.end_time:
                limit = f"below {case.end_time:g}"
                meaning = "It begins after the end of the run and does nothing."
                yield Number(f"start of particles.{key} {number}", one.start, "s", limit, "warn", meaning)
    if case.domain.shape == "box" or not list_openings(case):
        return  # a box is cut as the case has it
    mesh = read_wall_mesh(case, folder)
    for number, outlet in enumerate(case.particles.outlets, start=1):
        if is_opening(outlet):
            area = mesh.sum_areas(find_open_faces(case, [outlet], folder))
            yield _measure_outlet(f"area of particles.outlets {number}", find_opening(outlet), area)


def _measure_outlet(name: str, outlet: Opening, area: float) -> Number:
    """What the whole faces that an outlet has are together, beside what its shape is."""
    if outlet.shape is None:
        return Number(name, area, "m2", None, None, f"{describe(outlet)}: whole faces of the mesh.")
    meaning = f"{describe(outlet)}, opened by the whole faces whose centres lie in it: smaller cells, or "
    meaning += "edges where faces have theirs, make it the one that is given."
    asked, away = outlet.shape.area, abs(area / outlet.shape.area - 1.0)
    return Number(name, area, "m2", f"{asked:.4g} within {100 * _AWAY:g} %", judge(away <= _AWAY), meaning)


def _count_cells(case: Case, streams: tuple[Stream, ...], openings: Openings, number: int) -> Iterator[Number]:
    """How many cells are across inlet `number`, from 1, that has a shape, and what the mesh has of its momentum."""
    across = count_across(case.domain, streams, openings, number - 1)
    if math.isinf(across):
        return
    part = compare_momentum(streams, openings, number - 1)
    meaning = (
        f"A face has one velocity: the mesh has {part:.3g} of the momentum flux that the case gives on the faces of "
        f"inlet {number}. For more of it make the cells smaller, or let the inlet end where faces do."
    )
    yield Number(
        f"cells across inlet {number}",
        across,
        "cells",
        f"at least {WIDE:g}",
        judge(across >= WIDE * (1.0 - 1e-9)),
        meaning,
    )
