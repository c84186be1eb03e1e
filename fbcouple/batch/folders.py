"""The run folders in a folder, and how much work each of them is."""

from __future__ import annotations

import shlex
from pathlib import Path

from fbcouple.case.bed.derived import dem_step
from fbcouple.case.bed.fluid_step import coupling_step, gas_step
from fbcouple.case.bed.particle_types import particle_count
from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.thin_cells import find_thinnest
from fbcouple.case.load import load_case
from fbcouple.case.schema.sections import Case
from fbcouple.case.source import FILE_NAME
from fbcouple.errors import CaseError

_PER_CELL = 11.0
"""Time of a cell and pressure correction over that of a particle and DEM step (`mueller/0.9`)."""


def is_set(folder: Path) -> bool:
    """Is `folder` no run folder, and holds some?"""
    return not (folder / FILE_NAME).is_file() and any(folder.glob(f"*/{FILE_NAME}"))


def find_runs(folder: Path) -> list[Path]:
    """The run folder `folder`, or the run folders in it, by name.

    Raises: CaseError if it is none and holds none.
    """
    if (folder / FILE_NAME).is_file():
        return [folder.resolve()]
    runs = sorted(path.parent.resolve() for path in folder.glob(f"*/{FILE_NAME}")) if folder.is_dir() else []
    if not runs:
        text = "is neither a run folder nor a folder of runs"
        raise CaseError([f"{folder}: {text}; write one with `fbcouple setup CASE -o {shlex.quote(str(folder))}`."])
    return runs


def estimate_work(run: Path) -> float:
    """Work of the whole run in the folder `run`, as `weigh_case` has it."""
    return weigh_case(load_case(str(run)), run)


def weigh_case(case: Case, folder: Path) -> float:
    """Work of a run of `case`, whose own files lie in `folder`, in DEM steps of a particle: what runs are put in order
    by."""
    work = 0.0
    if case.particles and case.contact:
        work += particle_count(case.particles) / dem_step(case.contact, case.particles)
    if case.gas:
        thinnest = find_thinnest(case, folder)
        step = coupling_step(case, thinnest) if case.contact else gas_step(case, thinnest=thinnest)
        work += _PER_CELL * find_region(case, folder).cells * case.gas.correctors / step
    return work * case.end_time
