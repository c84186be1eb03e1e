"""Measured lines that a report compares with: `quantity@height=file`, of a part of the depth
`quantity@height,front:back=file`, over the radius of a column `quantity@height,r=file`, and a CSV file of x (or r),
value and error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.input_files.number_table import Form, read_table
from fbcouple.input_files.units import LENGTHS, SPEEDS, guess_frame

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

RADIAL = "r"
"""What stands behind the height of a line over the radius."""

PARTS = ("solids_fraction", "voidage")
"""Quantities that are parts of 1; points read off a figure may lie outside by SLACK."""
SLACK = 0.1

_VALUE_UNITS: dict[str, dict[str, float]] = {
    "1": {"1": 1.0, "-": 1.0, "": 1.0, "%": 1e-2},
    "m s-1": SPEEDS,
    "m2 s-2": {"m2 s-2": 1.0, "m2/s2": 1.0, "m^2/s^2": 1.0, "m²/s²": 1.0},
    "kg m-2 s-1": {"kg m-2 s-1": 1.0, "kg/m2s": 1.0, "kg/(m2 s)": 1.0, "kg/m2/s": 1.0, "kg/m^2/s": 1.0},
    "Pa": {"Pa": 1.0, "kPa": 1e3},
}
UNCLEAR = {
    word: "if it is the half width of an error bar call it `error`, else remove it"
    for word in (
        *("err", "errors", "error bar", "std", "sd", "sigma", "stderr", "std err", "std error", "standard error"),
        *("stdev", "std dev", "standard deviation", "uncertainty", "dev", "deviation", "value error", "rms"),
    )
}
"""Words in a head that could mean `error`, and what to do about it."""

LARGEST = 10_000_000
"""Bytes that a file of measured points may have."""


@dataclass(frozen=True)
class Reference:
    """A measured line across the bed: `quantity` against x at z = `height` [m], averaged over the depth, or from y =
    depth[0] to depth[1] [m] alone, as a camera sees the layer behind the front wall; if `is_radial`, against the
    distance r from the middle of a column, averaged over rings; in `file`."""

    quantity: str
    height: float
    file: str
    depth: tuple[float, float] | None = None
    is_radial: bool = False

    @property
    def axis(self) -> str:
        """What its points are placed by, x or r."""
        return "r" if self.is_radial else "x"

    @property
    def name(self) -> str:
        """`quantity@height`, with `,front:back` of a part of the depth, `,r` over the radius."""
        part = ",r" if self.is_radial else f",{self.depth[0]:g}:{self.depth[1]:g}" if self.depth else ""
        return f"{self.quantity}@{self.height:g}{part}"

    def __str__(self) -> str:
        return f"{self.name}={self.file}"


@dataclass(frozen=True)
class Points:
    """Measured points: `x`, or r, [m], `value` and, if the file has them, `error` in SI units; shape (n,) each.

    `unread`: heads of columns of the file that are not looked at.
    """

    x: np.ndarray
    value: np.ndarray
    error: np.ndarray | None
    unread: tuple[str, ...] = ()


def parse_reference(text: str) -> Reference:
    """Read `quantity@height=file`, as `solids_velocity@0.025=uy2.csv` or `solids_velocity@0.025,0:0.005=uy2.csv`
    or `solids_velocity@0.025,r=uy2.csv`.

    Raises: CaseError (one text) that says which part is wrong.
    """
    line, equals, file = text.partition("=")
    quantity, at, rest = line.partition("@")
    height, comma, part = rest.partition(",")
    shape = (
        "write quantity@height=file, as solids_velocity@0.025=uy2.csv (height in m), or of a part of the depth "
        "quantity@height,front:back=file (y in m), or over the radius of a column quantity@height,r=file."
    )
    if not equals or not at or not file.strip():
        raise CaseError([f"`{text[:80]}` is not a reference; {shape}"])
    if quantity.strip() not in QUANTITIES:
        raise CaseError([f"`{quantity[:40]}` in `{text[:80]}` is given, allowed are: {', '.join(QUANTITIES)}; {shape}"])
    metres = _read_number(height)
    if not math.isfinite(metres):
        raise CaseError([f"`{height[:40]}` in `{text[:80]}` is given, a height in m is allowed; {shape}"])
    if not comma:
        return Reference(quantity.strip(), metres, file.strip())
    if part.strip() == RADIAL:
        return Reference(quantity.strip(), metres, file.strip(), is_radial=True)
    ends = [_read_number(end) for end in part.split(":")]
    if len(ends) != 2 or not -math.inf < ends[0] < ends[1] < math.inf:
        given = f"`{part[:40]}` in `{text[:80]}` is given, two places y in m, the lower first, or {RADIAL} are allowed"
        raise CaseError([f"{given}; {shape}"])
    return Reference(quantity.strip(), metres, file.strip(), (ends[0], ends[1]))


def _read_number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def read_points(path: Path, quantity: str, axis: str = "x") -> Points:
    """Read the columns `x`, or `r` as `axis` has it, `value` and, if there is one, `error` of a file of points.

    quantity: one of QUANTITIES; the column of the values may have its name in place of `value`. The head may name the
    unit of the values, or another that is converted; errors whose head names none have that of the values.
    Returns: the points in the order of x.
    Raises: CaseError (one text) naming the file and the line that is wrong.
    """
    values = _VALUE_UNITS[QUANTITIES[quantity]]
    names = {quantity: "value", quantity.replace("_", " "): "value"}
    mend = f"this line is of {quantity}: name its column `value` or `{quantity}`, or give the line as {{}}@height=file"
    others = {name.replace("_", " "): mend.format(name) for name in QUANTITIES if name != quantity}
    units = {axis: LENGTHS, "value": values, "error": values}
    form = Form(units, (axis, "value"), "points", LARGEST, names, UNCLEAR, others, {"error": "value"})
    table = read_table(path, form)
    columns = table.columns
    order = np.argsort(columns[axis], kind="stable")
    x, value, error = (columns[name][order] if name in columns else None for name in form.columns)
    assert x is not None and value is not None
    if error is not None and error.min() < 0.0:
        raise CaseError([f"{path.name} holds an error below zero; give half widths in the unit of the value."])
    return Points(x, value, error, table.unread)


def _require_radii(file: str, low: float, high: float, largest: float) -> None:
    if low < 0.0 or high > largest:
        guess = guess_frame([low], [high], [largest]) if low >= 0.0 else ""
        mend = "give the distance from the middle in m (another unit in the head, as `r [mm]`)."
        raise CaseError([f"{file} has r from {low:g} to {high:g} m, 0 to {largest:g} m is allowed{guess}; {mend}"])


def read_line(
    reference: Reference, path: Path, size: Sequence[float], corner: Sequence[float] = (0.0, 0.0, 0.0)
) -> Points:
    """The points of `reference`, read from `path`, for a box of width, depth and height `size` [m] from `corner` [m];
    of a mesh from a file x, y and height are those of its own coordinates.

    Raises: CaseError (one text) as `read_points`, and if the line or a point lies outside of the box, or a value is
    none that the quantity can have.
    """
    points = read_points(path, reference.quantity, reference.axis)
    width, depth, height = size
    (left, front, floor), top = corner, corner[2] + height
    if not floor <= reference.height <= top:
        mend = f"the box is {height:g} m high; give m."
        if floor:
            mend = f"the mesh goes from {floor:g} to {top:g} m; give m, as the mesh has them."
        raise CaseError([f"{reference} is at {reference.height:g} m, {mend}"])
    if reference.depth and not (front <= reference.depth[0] and reference.depth[1] <= front + depth):
        given = f"{reference} is from y = {reference.depth[0]:g} to {reference.depth[1]:g} m"
        raise CaseError([f"{given}, {front:g} to {front + depth:g} m is allowed (domain.size); give m."])
    low, high = float(points.x[0]), float(points.x[-1])
    if reference.is_radial:
        _require_radii(path.name, low, high, 0.5 * min(width, depth))
    elif low < left or high > left + width:
        given = f"{path.name} has x from {low:g} to {high:g} m"
        mend = "give x in m from the left wall (another unit in the head, as `x [mm]`)."
        guess = guess_frame([low], [high], [width])
        if left:
            mend, guess = "give x as the mesh has it (another unit in the head, as `x [mm]`).", ""
        raise CaseError([f"{given}, {left:g} to {left + width:g} m is allowed (domain.size){guess}; {mend}"])
    wrong = np.flatnonzero(np.abs(points.value - 0.5) > 0.5 + SLACK)
    if wrong.size and reference.quantity in PARTS:
        given = f"{path.name} has {points.value[wrong[0]]:g} at x = {points.x[wrong[0]]:g} m"
        text = f"{given}, {reference.quantity} is 0 to 1"
        raise CaseError([f"{text}; give it as a part of 1 (percent with the head `value [%]`)."])
    return points
