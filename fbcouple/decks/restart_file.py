"""The particles of a restart file of LIGGGHTS, of anybody, as the start of a case. Nothing can check such a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fbcouple.case.bed.start_file import StartFile
from fbcouple.case.bed.start_sizes import match_kinds
from fbcouple.case.schema.sections import Case
from fbcouple.decks.alone import Particles, read_foreign_restart
from fbcouple.errors import CaseError, SolverError
from fbcouple.run_folder.manifest import hash_file


def find_restart(case: Case, folder: Path) -> tuple[Path, str]:
    """The restart file of a case whose own files lie in `folder`, and what it is in words."""
    assert case.start is not None and case.start.restart is not None
    path = case.find_folder(folder, case.start.restart) / case.start.restart
    return path, f"particles of the restart file {path.name}, which was trusted: SHA-256 {hash_file(path)}"


def read_restart_file(case: Case, path: Path) -> Particles:
    """The particles in the restart file `path`, with the kinds that `case` has for them.

    Raises: CaseError (one text, without the key) if LIGGGHTS does not read it, or `case` has no such kinds.
    """
    assert case.particles is not None
    try:
        found = read_foreign_restart(path)
    except SolverError as error:
        text = f"{path.name} cannot be read: {error}"
        raise CaseError([f"{text}; give one that this LIGGGHTS wrote, or what `write_data` writes of it."]) from None
    positions, motion = found["positions"], np.hstack([found["velocities"], found["spins"]])
    if not len(positions):
        raise CaseError([f"{path.name} has no particles; give one that has some."])
    if not all(np.isfinite(values).all() for values in (positions, motion, found["radii"], found["densities"])):
        raise CaseError([f"{path.name} has values that are not finite; give another one."])
    start = StartFile(
        positions, types=found["types"].astype(int), diameters=2.0 * found["radii"], densities=found["densities"]
    )
    kinds = match_kinds(case.particles, start)
    assert kinds is not None
    return Particles(positions, motion, kinds)
