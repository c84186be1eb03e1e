"""The run folders in a folder, and how much work each of them is."""

from __future__ import annotations

import shlex
from pathlib import Path

from fbcouple.case.bed.derived import dem_step
from fbcouple.case.bed.particle_types import particle_count
from fbcouple.case.bed.region import find_region
from fbcouple.case.load import load_case
from fbcouple.case.preflight import coupling_step, gas_step
from fbcouple.case.source import FILE_NAME
from fbcouple.errors import CaseError

_CELL = 30.0
"""Work of a cell in a fluid step over that of a particle in a DEM step (measured on `patil/c2`: 5 and 0.2 us)."""


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
    """Work of the whole run, in steps of a particle: what runs are put in order by, the longest first."""
    case, work = load_case(str(run)), 0.0
    if case.particles and case.contact:
        work += particle_count(case.particles) * case.end_time / dem_step(case.contact, case.particles)
    if case.gas:
        step = coupling_step(case) if case.particles else gas_step(case)
        work += _CELL * find_region(case, run).cells * case.end_time / step
    return work
