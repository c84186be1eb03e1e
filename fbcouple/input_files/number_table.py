"""Tables of numbers as other programs write them: a head with the names of the columns, and a row a line.

Separators are commas, semicolons, tabs or blanks; decimal commas count where commas do not separate. A head may say the
unit of a column (`x [mm]`) and may stand behind a `#`; rows without an entry are left out. What cannot be read is told
as it was found.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.input_files.decimal_signs import DecimalSigns
from fbcouple.input_files.foreign_files import find_encoding
from fbcouple.input_files.units import DENSITIES, LENGTHS, SPEEDS, TIMES, find_size

_LACKING = re.compile(r"#(N/A|NV|N/D|[^\s;,]+[!?])\s*([;,\t]|$)")
"""First entry of a row that a spreadsheet could not compute, in any language; other lines with `#` are comments."""
_BRACKETS = " []()\t"
_FRACTION = re.compile(r"\s*0\d+\s*")
"""Digits that no whole number begins with: what a decimal comma leaves of 0,05 where commas separate columns."""
_COMMAS = "commas cannot separate columns and decimals: write decimal points, or `;` between the columns."
_LONGEST_HEAD = 100_000
_SHOWN = 60


@dataclass(frozen=True)
class Form:
    """What a file is to hold.

    columns: name -> units that its head may say; needed: those that must be there; aliases: other heads -> name;
    unclear: heads that could mean one of the columns -> what to do about it; others: heads that may be
    one of them where a needed one is missing; largest: bytes that the file may have; rows: what a row stands for;
    follows: name -> the column whose unit it has where its own head says none; is_all: other columns are a mistake.
    """

    columns: dict[str, dict[str, float]]
    needed: tuple[str, ...]
    rows: str
    largest: int
    aliases: dict[str, str] = field(default_factory=dict)
    unclear: dict[str, str] = field(default_factory=dict)
    others: dict[str, str] = field(default_factory=dict)
    follows: dict[str, str] = field(default_factory=dict)
    is_all: bool = False

    @property
    def first_line(self) -> str:
        """The head that a file of this form has at least."""
        return ",".join(self.needed)


@dataclass(frozen=True)
class Table:
    """Columns of finite numbers in SI units, (rows,) each, and the heads of the columns that were not read."""

    columns: dict[str, np.ndarray]
    unread: tuple[str, ...]


@dataclass(frozen=True)
class _Head:
    """The line of the names, its number, the separator (None: blanks) and the names as they stand there."""

    line: str
    number: int
    separator: str | None
    names: tuple[str, ...]


Lines = Iterator[tuple[int, str]]


def read_table(path: Path, form: Form) -> Table:
    """Read the columns that `form` knows from the file `path`; others are not looked at, and named.

    Raises: CaseError (one text that begins with the file's name) saying what was found, where, and how to fix it.
    """
    try:
        if not path.is_file():
            reason = "it is not a plain file" if path.exists() else "No such file or directory"
            raise CaseError([f"{path.name} cannot be read: {reason}; give a CSV file, starting `{form.first_line}`."])
        if path.stat().st_size > form.largest:
            limit = f"at most {form.largest / 1e6:g} MB are allowed"
            raise CaseError([f"{path.name} has {path.stat().st_size / 1e6:g} MB, {limit}; give fewer {form.rows}."])
        with path.open(encoding=find_encoding(path, form.rows, form.first_line)) as file:
            return _read_lines(path.name, enumerate(file, start=1), form)
    except OSError as error:
        text = f"{path.name} cannot be read: {error.strerror}"
        raise CaseError([f"{text}; give a CSV file, starting `{form.first_line}`."]) from None
    except UnicodeDecodeError as error:
        text = f"{path.name} is not {error.encoding.upper()} text (byte {error.object[error.start]:#04x})"
        raise CaseError([f"{text}; save it as CSV in UTF-8."]) from None


def _read_lines(file: str, lines: Lines, form: Form) -> Table:
    head, rest = _find_head(file, lines, form)
    found = _place_columns(file, head, form)
    indices = [index for index, _ in found.values()]
    flat = np.fromiter(_read_numbers(file, rest, head, indices), np.float64)
    if not flat.size:
        raise CaseError([f"{file} holds no {form.rows}; add a row for each below the header."])
    rows = flat.reshape(-1, len(indices)).T
    columns = {
        name: column.copy() if factor == 1.0 else (column * factor if factor > 1.0 else column / (1.0 / factor))
        for (name, (_, factor)), column in zip(found.items(), rows, strict=True)
    }
    unread = tuple(name for index, name in enumerate(head.names) if index not in indices and name)
    if unread and form.is_all:
        text = f"{file} has the columns {', '.join(map(repr, unread))}, which nothing looks at"
        raise CaseError([f"{text}; remove them: {', '.join(form.columns)} may be there."])
    return Table(columns, unread)


def _find_head(file: str, lines: Lines, form: Form) -> tuple[_Head, Lines]:
    """The first line that is no comment; of a file that begins with numbers the comment before them."""
    commented: _Head | None = None
    for number, line in lines:
        text = line.strip()
        if not text or text.lower().startswith("sep="):
            continue
        if len(text) > _LONGEST_HEAD:
            raise CaseError([f"{file}: line {number} has {len(text)} characters and no row is so long; fix it."])
        if text.startswith("#"):
            head = _split_head(text.lstrip("# "), number)
            named = {_understand(name, form)[0] for name in head.names}
            commented = head if set(form.needed) <= named else commented
            continue
        head = _split_head(text, number)
        if not all(_is_number(name) for name in head.names):
            return head, lines
        if commented is None:
            found = f"{file}: line {number}, `{_shorten(text)}`, holds numbers and no line before it names the columns"
            raise CaseError([f"{found}; start the file with the line `{form.first_line}`."])
        return commented, chain([(number, line)], lines)
    if commented is not None:
        raise CaseError([f"{file} holds no {form.rows}; add a row for each below the header."])
    raise CaseError([f"{file} is empty; start it with the line `{form.first_line}` and add {form.rows}."])


def _split_head(text: str, number: int) -> _Head:
    separator = next((sign for sign in (";", "\t", ",") if sign in text), None)
    if separator is None:  # `x [m]` is one name
        text = text.replace(" [", "[").replace(" (", "(")
    names = [name.strip().strip('"').strip() for name in _split(text, separator)]
    while len(names) > 1 and not names[-1]:
        names.pop()
    return _Head(text, number, separator, tuple(names))


def _split(line: str, separator: str | None) -> list[str]:
    if '"' not in line:
        return line.split(separator)
    try:
        return next(csv.reader([line], delimiter=separator or " ", skipinitialspace=True))
    except csv.Error:
        return [line]  # told as a row that has not the columns of the head


def _understand(name: str, form: Form) -> tuple[str | None, str | None]:
    """The column that a head means, None if it is none of the form's, and the unit that it says."""
    unit = None
    text = name
    for opening, closing in ("[]", "()"):
        if name.endswith(closing) and opening in name:
            text, _, unit = name[:-1].partition(opening)
    word = text.strip().lower()
    word = form.aliases.get(word, word)
    if unit is None and word not in form.columns and "/" in word:
        before, _, after = text.partition("/")
        if (short := form.aliases.get(before.strip().lower(), before.strip().lower())) in form.columns:
            return short, after.strip()
    return (word, unit if unit is None else unit.strip()) if word in form.columns else (None, unit)


def _find_word(name: str) -> str:
    """A head without its unit, dots, dashes and underscores."""
    word = name.lower().partition("[")[0].partition("(")[0].partition("/")[0]
    return " ".join(re.sub(r"[._-]", " ", word).split())


def _place_columns(file: str, head: _Head, form: Form) -> dict[str, tuple[int, float]]:
    """Column -> its place in a row, and its unit in SI units."""
    indices: dict[str, tuple[int, float]] = {}
    unclear = ""
    where = f"{file}: line {head.number}, `{_shorten(head.line)}`,"
    for index, name in enumerate(head.names):
        column, unit = _understand(name, form)
        if column is None:
            if hint := form.unclear.get(_find_word(name)):
                unclear = unclear or f"{where} has a column `{name}`; {hint}."
            continue
        if column in indices:
            raise CaseError([f"{where} names the column {column} twice; keep one."])
        indices[column] = index, _find_size(where, column, unit, form.columns[column])
    missing = [name for name in form.needed if name not in indices]
    if missing:
        lacking = " and ".join(missing) if len(missing) < 3 else f"{', '.join(missing[:-1])} and {missing[-1]}"
        text = f"{where} has no column {lacking}"
        for name in head.names:
            if hint := form.others.get(_find_word(name)):
                raise CaseError([f"{text} and has `{name}`; {hint}."])
        if "" in head.names:
            text += "; the empty names look like several data sets side by side, of which one is read"
        text += f"; name the columns as in `{','.join(form.columns)}`, the first {len(form.needed)} at least"
        raise CaseError([f"{text}. Where they stand further down, begin the lines above with `#`."])
    if unclear:
        raise CaseError([unclear])
    for column, leader in form.follows.items():
        if column in indices and _understand(head.names[indices[column][0]], form)[1] is None:
            indices[column] = indices[column][0], indices[leader][1]
    return indices


def _find_size(where: str, column: str, unit: str | None, units: dict[str, float]) -> float:
    """The `unit` of a column in SI units; 1 where its head says none."""
    size = 1.0 if unit is None else find_size(unit, units)
    if size is None:
        known = ", ".join(units) or "none"
        raise CaseError([f"{where} gives {column} in `{_shorten(unit or '')}`; units that are read: {known}."])
    return size


def _read_numbers(file: str, lines: Iterable[tuple[int, str]], head: _Head, indices: list[int]) -> Iterator[float]:
    """The numbers at `indices` of every row, one after the other."""
    separator, width = head.separator, len(head.names)
    signs = DecimalSigns(file, separator)
    for number, line in lines:
        text = line.strip()
        if not text or (text[0] == "#" and not _LACKING.match(text)):
            continue
        fields = _split(line.rstrip("\r\n") if separator else text, separator)
        if not any(entry.strip() for entry in fields):
            continue  # a row of a spreadsheet that was emptied
        if len(fields) != width and (len(fields) < width or any(extra.strip() for extra in fields[width:])):
            raise CaseError([_format_width(file, number, text, len(fields), head)])
        for index in indices:
            entry = fields[index]
            if "," in entry:
                signs.see_comma(number, entry, head.names[index])
            elif not signs.point and "." in entry:
                signs.see_point(number)
            elif separator == "," and _FRACTION.fullmatch(entry):
                told = f"{file}: line {number}, `{_shorten(text)}`, has `{entry}` for {head.names[index]}"
                raise CaseError([f"{told}; {_COMMAS}"])
            yield _read_number(file, number, entry, head.names[index])
    signs.require_clear()


def _read_number(file: str, line: int, entry: str, column: str) -> float:
    try:
        if "_" in entry:
            raise ValueError
        value = float(entry.replace(",", ".") if entry.count(",") == 1 else entry)
    except ValueError:
        shown = f"`{_shorten(entry.strip())}`" if entry.strip() else "nothing"
        strange = next((f" (with the character U+{ord(sign):04X})" for sign in entry if ord(sign) > 127), "")
        unit = entry.strip(_BRACKETS)
        mend = f"write it into the header, as `{column} [{unit}]`" if _is_unit(unit) else "give a number"
        raise CaseError([f"{file}: line {line} has {shown}{strange} for {column}; {mend}."]) from None
    if not math.isfinite(value):
        raise CaseError([f"{file}: line {line} has `{_shorten(entry.strip())}` for {column}; give a finite number."])
    return value


def _is_unit(word: str) -> bool:
    return any(find_size(word, units) for units in (LENGTHS, TIMES, SPEEDS, DENSITIES))


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True


def _format_width(file: str, line: int, text: str, found: int, head: _Head) -> str:
    width = len(head.names)
    told = (
        f"{file}: line {line}, `{_shorten(text)}`, has {found} columns and the header, `{_shorten(head.line)}`, {width}"
    )
    if head.separator == "," and found == 2 * width:
        return f"{told}; {_COMMAS}"
    return f"{told}; give every row the columns of the header."


def _shorten(text: str) -> str:
    shown = text if text.isprintable() else text.encode("unicode_escape").decode("ascii")
    return shown if len(shown) <= _SHOWN else f"{shown[:_SHOWN]}..."
