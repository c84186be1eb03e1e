"""Where the particles start: a CSV file beside the case, or the lattice of [start]."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from fbcouple.case.lattice import lattice_kinds, lattice_positions
from fbcouple.case.schema import Case
from fbcouple.errors import CaseError

AXES = ("x", "y", "z")
VELOCITIES = ("vx", "vy", "vz")
LARGEST = 2_000_000_000
"""Bytes that a file of start positions may have."""


def start_positions(case: Case, folder: Path) -> np.ndarray:
    """Return the start positions of a case whose file lies in `folder`: centres [m], shape (particles, 3)."""
    assert case.particles is not None
    if case.particles.positions is None:
        return lattice_positions(case, folder)
    return read_positions(folder / case.particles.positions)


def start_kinds(case: Case, folder: Path) -> np.ndarray:
    """Return the kind of each particle of a case, int (particles,), counted from 0.

    A positions file may say it in a column `kind`, counted from 1; otherwise the kinds are mixed at random.
    """
    assert case.particles is not None
    if case.particles.positions is not None and (rows := read_kinds(folder / case.particles.positions)) is not None:
        return rows - 1
    return lattice_kinds(case)


def start_velocities(case: Case, folder: Path) -> np.ndarray | None:
    """Return the start velocities [m/s] of a case, shape (particles, 3); None if all particles start at rest."""
    assert case.particles is not None
    return read_velocities(folder / case.particles.positions) if case.particles.positions else None


def read_positions(path: Path) -> np.ndarray:
    """Read the columns x, y and z [m] of a CSV file with a header line; other columns are allowed.

    Returns: positions [m], shape (particles, 3).
    Raises: CaseError (one text, without the key) if the file is missing or holds anything but finite numbers.
    """
    positions = _read_columns(path, AXES)
    if positions is None:
        raise CaseError([f"{path.name} has no columns x, y and z; start it with the line `x,y,z`."])
    return positions


def read_velocities(path: Path) -> np.ndarray | None:
    """Read the columns vx, vy and vz [m/s] of a positions file, (particles, 3); None if it has none of them.

    Raises: CaseError (one text, without the key) if it has some of them only, or anything but finite numbers in them.
    """
    velocities = _read_columns(path, VELOCITIES)
    if velocities is None and any(_read_columns(path, (name,)) is not None for name in VELOCITIES):
        raise CaseError([f"{path.name} has not all of the columns vx, vy and vz; give all three or none."])
    return velocities


def read_kinds(path: Path) -> np.ndarray | None:
    """Read the column `kind` of a positions file, int (particles,) from 1; None if it has none. Raises: CaseError."""
    kinds = _read_columns(path, ("kind",))
    if kinds is None:
        return None
    broken = np.flatnonzero((kinds[:, 0] < 1) | (kinds[:, 0] != np.floor(kinds[:, 0])))
    if broken.size:
        raise CaseError([f"{path.name}: the kind of particle {broken[0] + 1} is no whole number from 1; mend it."])
    return kinds[:, 0].astype(int)


def _read_columns(path: Path, names: tuple[str, ...]) -> np.ndarray | None:
    """The columns `names` as (rows, columns), all finite; None if the header lacks one of them."""
    try:
        if path.stat().st_size > LARGEST:
            raise CaseError([f"{path.name} is larger than {LARGEST / 1e9:g} GB; give fewer particles or fewer digits."])
        with path.open(encoding="utf-8") as file, warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # "no data": told below
            header = [name.strip() for name in file.readline().split(",")]
            if not set(names) <= set(header):
                return None
            columns = [header.index(name) for name in names]
            positions = np.loadtxt(file, delimiter=",", usecols=columns, ndmin=2, comments=None)
    except OSError as error:
        raise CaseError([f"{path.name} cannot be read: {error.strerror}; put it beside the case file."]) from None
    except ValueError as error:
        raise CaseError([f"{path.name}: {str(error)[:150]}; give a number in each column of each row."]) from None
    if positions.shape[0] == 0:
        raise CaseError([f"{path.name} holds no particles; add a row for each below the header."])
    broken = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if broken.size:
        raise CaseError([f"{path.name}: particle {broken[0] + 1} is not finite; give coordinates in m (and m/s)."])
    return positions
