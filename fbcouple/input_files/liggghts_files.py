"""Particles as LIGGGHTS and LAMMPS write them: text dumps (`dump custom`), data files (`read_data`)."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TextIO

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.input_files.number_rows import shorten
from fbcouple.input_files.number_table import Table

RESTART = ".restart"
SUFFIXES = (".dump", ".liggghts", ".lammpstrj", ".data", RESTART)
"""What such files are called."""
POSITIONS = ("x", "y", "z")
VELOCITIES = ("vx", "vy", "vz")
SPINS = ("omegax", "omegay", "omegaz")
COLUMNS = (*POSITIONS, *VELOCITIES, *SPINS, "radius", "diameter", "density", "type", "id", "temperature")
"""Columns of particles that are read."""
_LOOKED_AT = 4096
_LONGEST = 100_000
_MOST = 1_000_000_000
_COUNT = re.compile(r"\d{1,18}")
_DUMP = re.compile(rb"\s*ITEM:")
_DATA = re.compile(rb"(?m)^\s*\d+\s+atoms\s*$")
_RESTART = (b"LIGGGHTS", b"LAMMPS", b"Version ")


def find_format(path: Path) -> str | None:
    """What of these the file `path` is by its first bytes: "dump", "data" or None.

    Raises: CaseError (one text that begins with the file's name) if it is a restart file; OSError.
    """
    with path.open("rb") as file:
        start = file.read(_LOOKED_AT)
    if b"\0" in start and (path.suffix == RESTART or any(word in start for word in _RESTART)):
        text = f"{path.name} is a binary restart file, which only LIGGGHTS itself can read and nothing can check"
        text += "; read it there, and give what `write_data` or `dump custom` writes of it"
        raise CaseError([f"{text}, or give it as start.restart and say --trust."])
    if _DUMP.match(start):
        return "dump"
    return "data" if _DATA.search(start) else None


class Lines:
    """Lines of a text file, counted."""

    def __init__(self, file: TextIO, name: str) -> None:
        self._file, self.name, self.number = file, name, 0

    def read(self) -> str | None:
        """The next line without its end; None behind the last."""
        line = self._file.readline(_LONGEST)
        if not line:
            return None
        self.number += 1
        if len(line) == _LONGEST:
            raise CaseError([f"{self.name}: line {self.number} is longer than {_LONGEST} letters; write it again."])
        return line.rstrip("\r\n")

    def take(self, count: int, what: str) -> list[str]:
        """The next `count` lines. Raises: CaseError if the file ends before."""
        taken: list[str] = []
        for _ in range(count):
            line = self.read()
            if line is None:
                text = f"{self.name} ends after {len(taken)} of the {count} {what} that it announces"
                raise CaseError([f"{text} (line {self.number}); it is cut short: write it again."])
            taken.append(line)
        return taken

    def take_count(self, what: str) -> int:
        """The whole number on the next line."""
        (line,) = self.take(1, what)
        return self.require_count(line.strip(), what)

    def require_count(self, text: str, what: str) -> int:
        """`text` of the last line as a whole number. Raises: CaseError if it is none."""
        if not _COUNT.fullmatch(text):
            raise self.refuse(f"`{shorten(text)}` for the {what}", "give a whole number")
        return int(text)

    def require_particles(self, count: int) -> int:
        """`count` of the last line. Raises: CaseError if there cannot be so many."""
        if count > _MOST:
            raise self.refuse(f"{count} particles", f"at most {_MOST:.0e} are allowed")
        return count

    def refuse(self, found: str, mend: str) -> CaseError:
        """The error of the last line, for the caller to raise."""
        return CaseError([f"{self.name}: line {self.number} has {found}; {mend}."])


def read_text(path: Path, read: Callable[[Lines], Table]) -> Table:
    """What `read` gives of the lines of the text file `path`. Raises: CaseError; OSError."""
    try:
        with path.open(encoding="utf-8", newline=None) as file:
            return read(Lines(file, path.name))
    except UnicodeDecodeError as error:
        text = f"{path.name} is not UTF-8 text (byte {error.object[error.start]:#04x})"
        raise CaseError([f"{text}; write it again as text, as `dump custom` does."]) from None


def order_by_id(file: str, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The columns without `id`, in its order: ranks write their particles as they have them.

    Raises: CaseError if two particles have one number.
    """
    columns = dict(columns)
    numbers = columns.pop("id", None)
    if numbers is None:
        return columns
    order = np.argsort(numbers, kind="stable")
    twice = np.flatnonzero(np.diff(numbers[order]) == 0)
    if twice.size:
        text = f"{file}: the particle of id {numbers[order][twice[0]]:.0f} is there twice"
        raise CaseError([f"{text}; was it written by several runs? Write it again."])
    return {name: values[order] for name, values in columns.items()}


def choose_columns(names: list[str], known: dict[str, str]) -> Iterator[tuple[str, int]]:
    """Of each column that is read its name and place in a row; `known`: other name -> name. A column that stands twice,
    as `type` in many decks, is read once."""
    seen: set[str] = set()
    for index, given in enumerate(names):
        name = known.get(given, given)
        if name in COLUMNS and name not in seen:
            seen.add(name)
            yield name, index
