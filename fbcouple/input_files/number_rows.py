"""Rows of numbers between blanks, read as a block; what is wrong with one is told with its line."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fbcouple.errors import CaseError

_SHOWN = 60


def read_rows(file: str, lines: Sequence[str], first: int, names: Sequence[str], wanted: Sequence[int]) -> np.ndarray:
    """The numbers in the columns `wanted` of `lines`, float64 (rows, wanted).

    first: number of the first line in `file`; names: of all columns, as many as every line must have.
    Raises: CaseError (one text that begins with the file's name) at the first line that is not so.
    """
    for number, line in enumerate(lines, start=first):
        if (found := len(line.split())) != len(names):
            text = f"{file}: line {number}, `{shorten(line)}`, has {found} columns, {len(names)} are wanted"
            raise CaseError([f"{text} ({shorten(' '.join(names))}); is the file cut short? Write it again."])
    try:
        rows = np.loadtxt(lines, dtype=np.float64, comments=None, usecols=wanted, ndmin=2)
    except ValueError:
        rows = np.full((len(lines), len(wanted)), np.nan)
    if not np.isfinite(rows).all():
        raise CaseError([_find_wrong(file, lines, first, names, wanted)])
    return rows


def _find_wrong(file: str, lines: Sequence[str], first: int, names: Sequence[str], wanted: Sequence[int]) -> str:
    for number, line in enumerate(lines, start=first):
        entries = line.split()
        for column in wanted:
            try:
                if math.isfinite(float(entries[column])) and "_" not in entries[column]:
                    continue
            except ValueError:
                pass
            text = f"{file}: line {number} has `{shorten(entries[column])}` for {names[column]}"
            return f"{text}; give a finite number."
    return f"{file}: lines from {first} on are no rows of numbers; write the file again."


def shorten(line: str) -> str:
    """A line as messages show it."""
    text = line.strip()
    text = text if text.isprintable() else text.encode("unicode_escape").decode("ascii")
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
