"""Measured lines that a report compares with: `quantity@height=file`, and a CSV file of x, value and error."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError

QUANTITIES: dict[str, str] = {
    "solids_fraction": "1",
    "solids_velocity": "m s-1",
    "solids_flux": "kg m-2 s-1",
    "agitation": "m2 s-2",
    "granular_temperature": "m2 s-2",
    "voidage": "1",
    "gas_velocity": "m s-1",
    "gas_flux": "m s-1",
    "pressure": "Pa",
}
"""Time means that can be compared, with the unit of the measured values; of a vector the vertical component."""

LARGEST = 10_000_000
"""Bytes that a file of measured points may have."""


@dataclass(frozen=True)
class Reference:
    """A measured line across the bed: `quantity` against x at z = `height` [m], averaged over the depth, in `file`."""

    quantity: str
    height: float
    file: str

    def __str__(self) -> str:
        return f"{self.quantity}@{self.height:g}={self.file}"


@dataclass(frozen=True)
class Points:
    """Measured points: `x` [m], `value` and, if the file has them, `error` in SI units; shape (n,) each."""

    x: np.ndarray
    value: np.ndarray
    error: np.ndarray | None


def parse_reference(text: str) -> Reference:
    """Read `quantity@height=file`, as `solids_velocity@0.025=uy2.csv`.

    Raises: CaseError (one text) that says which part is wrong.
    """
    line, equals, file = text.partition("=")
    quantity, at, height = line.partition("@")
    shape = "write quantity@height=file, as solids_velocity@0.025=uy2.csv (height in m)."
    if not equals or not at or not file.strip():
        raise CaseError([f"`{text[:80]}` is not a reference; {shape}"])
    if quantity.strip() not in QUANTITIES:
        raise CaseError([f"`{quantity[:40]}` in `{text[:80]}` is given, allowed are: {', '.join(QUANTITIES)}; {shape}"])
    try:
        metres = float(height)
    except ValueError:
        metres = math.nan
    if not 0.0 <= metres < math.inf:
        raise CaseError([f"`{height[:40]}` in `{text[:80]}` is given, a height in m from 0 is allowed; {shape}"])
    return Reference(quantity.strip(), metres, file.strip())


def read_points(path: Path) -> Points:
    """Read the columns `x`, `value` and, if there is one, `error` of a CSV file with a header line.

    Returns: the points in the order of x.
    Raises: CaseError (one text) naming the file and the line that is wrong.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise CaseError([f"{path.name} is larger than {LARGEST / 1e6:g} MB; a measured line has a few points."])
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.reader(line for line in file if not line.startswith("#")))
    except OSError as error:
        raise CaseError([f"{path} cannot be read: {error.strerror}; give a CSV file with columns x, value."]) from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise CaseError([f"{path} is not CSV text ({error}); give columns x, value, and error if known."]) from None
    header = [name.strip() for name in rows[0]] if rows else []
    if not {"x", "value"} <= set(header):
        raise CaseError([f"{path} has no columns x and value; start it with the line `x,value` or `x,value,error`."])
    columns: list[str] = [name for name in ("x", "value", "error") if name in header]
    points = [_read_row(path, number, row, header, columns) for number, row in enumerate(rows[1:], 1) if any(row)]
    if not points:
        raise CaseError([f"{path} holds no points; add a row for each below the header."])
    table = np.array(points)
    table = table[np.argsort(table[:, 0], kind="stable")].T
    if "error" in columns and table[2].min() < 0.0:
        raise CaseError([f"{path} holds an error below zero; give half widths in the unit of the value."])
    return Points(table[0], table[1], table[2] if "error" in columns else None)


def _read_row(path: Path, number: int, row: list[str], header: list[str], names: list[str]) -> list[float]:
    try:
        values = [float(row[header.index(name)]) for name in names]
    except (ValueError, IndexError):
        values = [math.nan]
    if not all(math.isfinite(value) for value in values):
        raise CaseError([f"{path}: row {number} below the header, `{','.join(row)[:60]}`, has no finite {names}."])
    return values
