"""Text dumps of LIGGGHTS and LAMMPS: one or several time steps, each with its box and a particle a line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.input_files.liggghts_files import POSITIONS, Lines, choose_columns, order_by_id, read_text
from fbcouple.input_files.number_rows import read_rows, shorten
from fbcouple.input_files.number_table import Table

_ITEM = "ITEM:"
_UNITS = "si"
_MANNERS = ("", "u", "s", "su")
"""How dumps give positions (x, xu, xs, xsu), the plain ones first: unwrapped, scaled by the box, both."""
_MOST_NAMED = 5


@dataclass
class _Frame:
    """One time step: bounds (3, 2) [m] of its box, axes that are periodic, names of the columns, rows of text."""

    step: int = -1
    count: int | None = None
    bounds: np.ndarray | None = None
    periodic: tuple[bool, ...] = (False,) * 3
    names: tuple[str, ...] = ()
    first: int = 0
    rows: list[str] | None = None


def read_dump(path: Path, step: int | None = None) -> Table:
    """Columns of the particles of the time step `step` in a text dump, None: the last, in the order of their ids.

    Raises: CaseError (one text that begins with the file's name) saying what was found, where, and how to fix it.
    """
    return read_text(path, lambda lines: _read_columns(lines.name, _find_frame(lines, step)))


def _find_frame(lines: Lines, step: int | None) -> _Frame:
    """Walk through the whole file, so that one that is cut short is told, and keep the rows of one step."""
    kept: _Frame | None = None
    steps: list[int] = []
    frame = _Frame()
    while (line := lines.read()) is not None:
        if not line.strip():
            continue
        if not line.startswith(_ITEM):
            raise lines.refuse(f"`{shorten(line)}` where the next ITEM is wanted", "the number of atoms is wrong")
        item = line.removeprefix(_ITEM).split()
        if item[:1] == ["TIMESTEP"]:
            frame = _Frame(step=lines.take_count("time step"))
            steps.append(frame.step)
        else:
            _read_item(lines, item, frame)
        if frame.rows is not None:
            kept = frame if step in (None, frame.step) else kept
            frame = _Frame(step=frame.step)
    if kept is None or not kept.rows:
        shown = ", ".join(map(str, steps[-_MOST_NAMED:])) or "none"
        text = f"{lines.name} has no time step {step}"
        if step is None or kept is not None:
            text = f"{lines.name} has no particles at its {'last time step' if step is None else f'time step {step}'}"
        raise CaseError([f"{text}; steps in it: {'..., ' if len(steps) > _MOST_NAMED else ''}{shown}."])
    return kept


def _read_item(lines: Lines, item: list[str], frame: _Frame) -> None:
    if item[:1] == ["UNITS"]:
        (units,) = lines.take(1, "units")
        if units.strip() != _UNITS:
            raise lines.refuse(f"the units `{shorten(units)}`", "values in SI units are read: convert it")
    elif item[:3] == ["NUMBER", "OF", "ATOMS"]:
        frame.count = lines.require_particles(lines.take_count("number of atoms"))
    elif item[:2] == ["BOX", "BOUNDS"]:
        if set(item[2:]) & {"xy", "xz", "yz"}:
            raise lines.refuse("a box that is not upright (xy xz yz)", "boxes with right angles are read")
        frame.periodic = tuple(word == "pp" for word in item[2:5]) if len(item) == 5 else (False,) * 3
        first = lines.number + 1
        frame.bounds = read_rows(lines.name, lines.take(3, "lines of the box"), first, ("low", "high"), (0, 1))
    elif item[:1] == ["ATOMS"]:
        if frame.count is None:
            raise lines.refuse("ATOMS and no number of them before it", "write the file again")
        frame.names, frame.first = tuple(item[1:]), lines.number + 1
        frame.rows = lines.take(frame.count, "particles")
    elif item[:1] == ["ENTRIES"]:
        raise lines.refuse("ENTRIES: this is a dump of contacts", "give a dump of particles (dump custom)")
    elif item:  # TIME and others of one line
        lines.take(1, " ".join(item)[:40])


def _read_columns(file: str, frame: _Frame) -> Table:
    assert frame.rows is not None
    names = list(frame.names)
    manner = next((m for m in _MANNERS if all(f"{axis}{m}" in names for axis in POSITIONS)), None)
    if manner is None:
        text = f"{file}: line {frame.first - 1} names the columns {shorten(' '.join(names))}, and no positions"
        raise CaseError([f"{text}; dump x y z, or xu yu zu, or xs ys zs."])
    indices = dict(choose_columns(names, {f"{axis}{manner}": axis for axis in POSITIONS}))
    rows = read_rows(file, frame.rows, frame.first, names, list(indices.values()))
    columns = dict(zip(indices, rows.T.copy(), strict=True))
    _unfold(file, frame, manner, columns)
    unread = tuple(name for index, name in enumerate(names) if index not in indices.values() and name not in indices)
    return Table(order_by_id(file, columns), unread)


def _unfold(file: str, frame: _Frame, manner: str, columns: dict[str, np.ndarray]) -> None:
    """Bring scaled positions to meters, and what lies over a periodic side back through it: unwrapped positions, and
    plain ones of particles that LIGGGHTS had not brought in yet."""
    if frame.bounds is None or (frame.bounds[:, 1] <= frame.bounds[:, 0]).any():
        if not manner:
            return
        raise CaseError([f"{file}: positions are given as x{manner} and there is no box; dump x y z."])
    for axis, (low, high), wraps in zip(POSITIONS, frame.bounds.tolist(), frame.periodic, strict=True):
        values = columns[axis]
        if "s" in manner:
            values = low + values * (high - low)
        outside = wraps & ((values < low) | (values > high))
        columns[axis] = np.where(outside, low + np.mod(values - low, high - low), values)
