"""Where the particles start: by a file beside the case, or on the lattice of [start]."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fbcouple.case.bed.derived import wraps
from fbcouple.case.bed.lattice import lattice_kinds, lattice_positions
from fbcouple.case.bed.particle_types import largest_diameter, list_kinds
from fbcouple.case.bed.start_file import StartFile, read_start
from fbcouple.case.bed.start_sizes import match_kinds
from fbcouple.case.schema.sections import Case

LARGEST_SHIFT = 1e-3
"""Of a diameter, along each axis, by `particles.positions_seed`: about as far as contacts of a bed at rest press, so
that it stays one, and far enough to part two beds in a few contacts."""


def find_start_file(case: Case, folder: Path) -> StartFile | None:
    """The start file of a case whose own files lie in `folder`; None if it starts on a lattice."""
    assert case.particles is not None
    name = case.particles.positions
    return None if name is None else read_start(case.find_folder(folder, name) / name, case.particles.positions_step)


def start_positions(case: Case, folder: Path) -> np.ndarray:
    """Return the start positions of a case whose file lies in `folder`: centres [m], shape (particles, 3)."""
    start = find_start_file(case, folder)
    if start is None:
        return lattice_positions(case, folder)
    assert case.particles is not None
    positions = bring_in(case, start.positions)
    if case.particles.positions_seed is None:
        return positions
    return _shift(case, case.particles.positions_seed, positions, start_kinds(case, folder))


def bring_in(case: Case, positions: np.ndarray) -> np.ndarray:
    """The start `positions` (n, 3) [m] of a file: those that lie over a periodic side, by up to the largest diameter,
    come in on the other.

    LIGGGHTS brings them in only where it makes its neighbour lists anew, so that what it wrote may lie a little
    outside. Those further out stay where they are, for the checks to tell.
    """
    assert case.particles is not None
    size, reach = np.array(case.domain.size), largest_diameter(case.particles)
    over = np.array(wraps(case.domain)) & (
        ((positions < 0.0) & (positions >= -reach)) | ((positions > size) & (positions <= size + reach))
    )
    return np.where(over, positions - np.sign(positions) * size, positions)


def _shift(case: Case, seed: int, positions: np.ndarray, kinds: np.ndarray) -> np.ndarray:
    """The `positions` (n, 3) [m] of particles of `kinds` (n,), each moved at random; those that a periodic side is
    crossed by come in on the other."""
    assert case.particles is not None
    diameters = np.array([kind.diameter for kind in list_kinds(case.particles)])[kinds]
    reach = LARGEST_SHIFT * diameters[:, None]
    moved = positions + reach * np.random.default_rng([seed, len(positions)]).uniform(-1.0, 1.0, positions.shape)
    size = np.array(case.domain.size)
    beyond = np.floor(moved / size) * np.array(wraps(case.domain))
    return moved - beyond * size


def start_kinds(case: Case, folder: Path) -> np.ndarray:
    """Return the kind of each particle of a case, int (particles,), counted from 0.

    A positions file may say it by a column `kind`, counted from 1, by sizes and densities, or by LIGGGHTS' types;
    otherwise the kinds are mixed at random.
    """
    start = find_start_file(case, folder)
    assert case.particles is not None
    kinds = None if start is None else match_kinds(case.particles, start)
    return lattice_kinds(case, folder) if kinds is None else kinds


def start_temperatures(case: Case, folder: Path) -> np.ndarray | None:
    """Return the temperatures [K] at the start, shape (particles,); None if all are alike, or the case has no heat."""
    start = find_start_file(case, folder) if case.heat else None
    return None if start is None else start.temperatures


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
