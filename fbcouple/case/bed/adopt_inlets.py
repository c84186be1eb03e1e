"""What the tables [[gas.inlets]] leave to their files and to the mesh: rows of time and velocity, profiles, areas."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np

from fbcouple.case.bed.inlet_profile import read_profile
from fbcouple.case.bed.openings import find_stream_areas
from fbcouple.case.bed.region import find_openings
from fbcouple.case.bed.streams import find_area, find_opening, list_streams
from fbcouple.case.companions import find_companion
from fbcouple.case.schema.inlets import Inlet
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.geometry.cylinder import find_section
from fbcouple.input_files.number_table import Form, read_table
from fbcouple.input_files.units import SPEEDS, TIMES

_FORM = Form(
    columns={"time": TIMES, "velocity": SPEEDS},
    needed=("time", "velocity"),
    rows="rows of an inlet",
    largest=20_000_000,
    aliases={"t": "time", "u": "velocity", "v": "velocity"},
    is_all=True,
)

Rows = tuple[tuple[float, float], ...]


def adopt_inlets(case: Case, folder: Path = Path()) -> Case:
    """The case with ramp and area of each of its inlets, and the area that all of them count for, filled in; its own
    files lie in `folder`. What it says already stays, and what cannot be had is left out: the checks tell."""
    if case.gas is None or not case.gas.inlets:
        return case
    inlets = tuple(_adopt_profile(case, _adopt_ramp(case, inlet, folder), folder) for inlet in case.gas.inlets)
    case = case.model_copy(update={"gas": case.gas.model_copy(update={"inlets": inlets})})
    assert case.gas is not None
    try:
        areas = find_areas(case, folder)
    except CaseError:
        return case  # told by check_inlets
    section = find_inlet_section(case, areas)
    inlets = tuple(
        inlet.model_copy(update={"area": area if inlet.area is None else inlet.area})
        for inlet, area in zip(inlets, areas.tolist(), strict=True)
    )
    given = case.gas.inlet_section
    update = {"inlets": inlets, "inlet_section": section if given is None else given}
    return case.model_copy(update={"gas": case.gas.model_copy(update=update)})


def find_areas(case: Case, folder: Path) -> np.ndarray:
    """Area [m2] that each inlet lets gas through by, (inlets,). Raises: CaseError (one text, without the key)."""
    streams = list_streams(case)
    if case.domain.shape == "file":
        return find_stream_areas(find_openings(case, folder))
    return np.array([find_area(case.domain, streams, number) for number in range(len(streams))])


def find_inlet_section(case: Case, areas: np.ndarray) -> float:
    """Area [m2] that the superficial velocity of all inlets together counts for."""
    domain = case.domain
    if domain.shape == "file":
        return float(areas.sum())
    if domain.shape == "cylinder":
        return find_section(domain.size[0], domain.cells[0])
    return domain.size[0] * domain.size[1]


def read_ramp(case: Case, inlet: Inlet, folder: Path) -> Rows:
    """Rows of the file that an inlet names. Raises: CaseError (one text, without the key)."""
    assert inlet.ramp_file is not None
    path = find_companion(case.find_folder(folder, inlet.ramp_file), inlet.ramp_file, ".csv")
    about = path.stat()
    return _read_rows(path, (about.st_mtime_ns, about.st_size))


@lru_cache(maxsize=8)
def _read_rows(path: Path, stamp: tuple[int, int]) -> Rows:
    """`stamp`: when the file was written, and its size; a load asks for it twice, to fill it in and to check it."""
    table = read_table(path, _FORM).columns
    return tuple(zip(table["time"].tolist(), table["velocity"].tolist(), strict=True))


def _adopt_ramp(case: Case, inlet: Inlet, folder: Path) -> Inlet:
    if inlet.ramp_file is None or inlet.ramp is not None:
        return inlet
    try:
        return inlet.model_copy(update={"ramp": read_ramp(case, inlet, folder)})
    except CaseError:
        return inlet  # told by check_inlets


def _adopt_profile(case: Case, inlet: Inlet, folder: Path) -> Inlet:
    if inlet.profile_file is None or find_opening(inlet).shape is None:
        return inlet
    try:
        profile = read_profile(case, inlet, folder)
    except CaseError:
        return inlet  # told by check_inlets
    update = {"peak": profile.peak if inlet.peak is None else inlet.peak}
    if inlet.velocity is None and inlet.ramp is None and inlet.ramp_file is None:
        update["velocity"] = profile.mean
    return inlet.model_copy(update=update)
