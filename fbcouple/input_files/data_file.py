"""Data files of LIGGGHTS and LAMMPS (`read_data`, `write_data`) of spheres: atom_style sphere or granular."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.input_files.liggghts_files import POSITIONS, SPINS, VELOCITIES, Lines, order_by_id, read_text
from fbcouple.input_files.number_rows import read_rows, shorten
from fbcouple.input_files.number_table import Table

_STYLES = ("sphere", "granular", "")
_ATOMS = ("id", "type", "diameter", "density", *POSITIONS)
_IMAGES = ("ix", "iy", "iz")
_MOTION = ("id", *VELOCITIES, *SPINS)
_COUNT = re.compile(r"\s*(\S+)\s+atoms\s*(#.*)?")
_SECTION = re.compile(r"\s*([A-Z][A-Za-z]+(?: [A-Z][a-z]+)*)\s*(?:#\s*(\w*).*)?")
_SKIPPED = ("Masses",)
"""Sections without a row for each particle; they end at the next one."""


def read_data(path: Path) -> Table:
    """Columns of the particles in a data file, in the order of their ids.

    Raises: CaseError (one text that begins with the file's name) saying what was found, where, and how to fix it.
    """
    return read_text(path, _read)


def _read(lines: Lines) -> Table:
    lines.read()  # the first line is a comment
    count = 0
    columns: dict[str, np.ndarray] = {}
    motion: dict[str, np.ndarray] = {}
    while (line := lines.read()) is not None:
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        section = _SECTION.fullmatch(line)
        if counted := _COUNT.fullmatch(line):
            count = lines.require_particles(lines.require_count(counted[1], "number of atoms"))
        elif section and section[1] == "Atoms":
            columns = _read_atoms(lines, count, section[2] or "")
        elif section and section[1] == "Velocities":
            motion = _read_section(lines, count, "Velocities", _MOTION)
        elif section and section[1] not in _SKIPPED:
            raise lines.refuse(f"the section {section[1]}", "Atoms and Velocities of spheres are read: remove it")
    if not columns:
        raise CaseError([f"{lines.name} has no section Atoms; write it again (write_data)."])
    if motion:
        columns = _join(lines.name, columns, motion)
    return Table(order_by_id(lines.name, columns), ())


def _read_atoms(lines: Lines, count: int, style: str) -> dict[str, np.ndarray]:
    if style not in _STYLES:
        raise lines.refuse(f"atoms of the style {style}", "spheres are read (atom_style sphere or granular)")
    return _read_section(lines, count, "Atoms", _ATOMS, _IMAGES)


def _read_section(
    lines: Lines, count: int, section: str, names: tuple[str, ...], more: tuple[str, ...] = ()
) -> dict[str, np.ndarray]:
    """The columns `names` of a section; a line may have the columns `more` behind them."""
    if not count:
        raise lines.refuse(f"{section} and no number of atoms before it", "write the file again")
    blank = lines.read()
    if blank is None or blank.strip():
        raise lines.refuse(f"`{shorten(blank or '')}` where an empty line is wanted", "write the file again")
    first = lines.number + 1
    rows = lines.take(count, f"rows of {section}")
    width = len(rows[0].split())
    if width not in (len(names), len(names) + len(more)):
        text = f"{lines.name}: line {first}, `{shorten(rows[0])}`, has {width} columns, {len(names)} are wanted"
        raise CaseError([f"{text} ({' '.join(names)}: atom_style sphere or granular); write it so, or a dump."])
    given = (*names, *more)[:width]
    found = read_rows(lines.name, rows, first, given, range(len(names)))
    return dict(zip(names, found.T.copy(), strict=True))


def _join(file: str, columns: dict[str, np.ndarray], motion: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The particles with their velocities, whose rows may be in another order."""
    one, other = np.argsort(columns["id"], kind="stable"), np.argsort(motion["id"], kind="stable")
    apart = np.flatnonzero(columns["id"][one] != motion["id"][other])
    if apart.size:
        number = columns["id"][one][apart[0]]
        raise CaseError([f"{file}: Velocities are not of the same ids as Atoms (id {number:.0f}); write it again."])
    moved = {name: values[other] for name, values in motion.items() if name != "id"}
    return {name: values[one] for name, values in columns.items()} | moved
