"""Where the particles start: by a file beside the case, or on the lattice of [start]."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fbcouple.case.bed.lattice import lattice_kinds, lattice_positions
from fbcouple.case.bed.start_file import StartFile, read_start
from fbcouple.case.bed.start_sizes import match_kinds
from fbcouple.case.schema.sections import Case


def find_start_file(case: Case, folder: Path) -> StartFile | None:
    """The start file of a case whose own files lie in `folder`; None if it starts on a lattice."""
    assert case.particles is not None
    name = case.particles.positions
    return None if name is None else read_start(case.find_folder(folder, name) / name, case.particles.positions_step)


def start_positions(case: Case, folder: Path) -> np.ndarray:
    """Return the start positions of a case whose file lies in `folder`: centres [m], shape (particles, 3)."""
    start = find_start_file(case, folder)
    return lattice_positions(case, folder) if start is None else start.positions


def start_kinds(case: Case, folder: Path) -> np.ndarray:
    """Return the kind of each particle of a case, int (particles,), counted from 0.

    A positions file may say it by a column `kind`, counted from 1, by sizes and densities, or by LIGGGHTS' types;
    otherwise the kinds are mixed at random.
    """
    start = find_start_file(case, folder)
    assert case.particles is not None
    kinds = None if start is None else match_kinds(case.particles, start)
    return lattice_kinds(case, folder) if kinds is None else kinds


def start_motion(case: Case, folder: Path) -> np.ndarray | None:
    """Return velocities [m/s] and angular velocities [rad/s] at the start, shape (particles, 6); None if all are at
    rest. Where the case has no rotation nothing spins."""
    start = find_start_file(case, folder)
    assert case.particles is not None
    spins = start.spins if start is not None and case.particles.rotation else None
    if start is None or (start.velocities is None and spins is None):
        return None
    still = np.zeros_like(start.positions)
    return np.hstack([still if start.velocities is None else start.velocities, still if spins is None else spins])
