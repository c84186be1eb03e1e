"""Numbers of the inlets and outlets of a case, before a run: areas, velocities, flows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fbcouple.case.bed.derived import fastest_inflow
from fbcouple.case.bed.inlet_profile import read_profiles
from fbcouple.case.bed.number import Number
from fbcouple.case.bed.openings import describe, find_stream_areas
from fbcouple.case.bed.region import Region, find_openings
from fbcouple.case.bed.streams import list_outlets, list_streams
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.imported import list_outlets as list_outlet_patches

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
        meaning = f"{describe(stream.opening).capitalize()}: {area:.7g} m2 of the mesh, {velocity:g} m s-1 {when}."
        yield Number(f"inlet {number}", area * velocity, "m3 s-1", None, None, meaning)
        beyond = 0.0 if isinstance(stream.profile, str) else stream.profile.beyond
        if beyond > _EDGE * math.sqrt(area):
            meaning = f"How far the file of its profile goes beyond inlet {number}: what lies there is not used. "
            meaning += "Right if it is of a larger section; wrong if its lengths are in another unit."
            yield Number(f"profile beyond inlet {number}", beyond, "m", "none", "warn", meaning)
    meaning = "Superficial velocity of all inlets together in the mean cross-section, at the fastest."
    whole = fastest_inflow(case.gas) * region.inlet / region.section
    yield Number("superficial velocity", whole, "m s-1", None, None, meaning)
    if case.gas.outlets:
        patches = list_outlet_patches(openings.mesh)
        for number, (outlet, patch) in enumerate(zip(list_outlets(case), patches, strict=True), start=1):
            meaning = f"{describe(outlet).capitalize()}: whole faces of the mesh, whose centres lie in it."
            yield Number(f"area of outlet {number}", openings.mesh.find_area(patch), "m2", None, None, meaning)
