"""Measured points that are no line across the bed: series over time or angle from a file, and single numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.input_files.measured_lines import LARGEST, UNCLEAR, Points
from fbcouple.input_files.number_table import Form, read_table
from fbcouple.input_files.units import LENGTHS

_UNITS: dict[str, dict[str, float]] = {
    "s": {"s": 1.0, "ms": 1e-3},
    "deg": {"deg": 1.0, "°": 1.0},
    "m": LENGTHS,
    "kg": {"kg": 1.0, "g": 1e-3},
    "Pa": {"Pa": 1.0, "kPa": 1e3},
    "1": {"1": 1.0, "-": 1.0, "": 1.0},
}

_ROUNDING = 1e-9
"""Part of its stretch by which a line may end before a measured point."""


def read_series(path: Path, axis: str, axis_unit: str, unit: str) -> Points:
    """The columns of a file of measured points over time or angle, in the order of these; `error` where it has one.

    axis: what the points are over; its first word is the name of the column ("angle of impact": `angle`).
    Raises: CaseError (one text) naming the file and the line that is wrong.
    """
    word = axis.split(maxsplit=1)[0]
    values = _UNITS.get(unit, {unit: 1.0})
    units = {word: _UNITS[axis_unit], "value": values, "error": values}
    form = Form(units, (word, "value"), "points", LARGEST, unclear=UNCLEAR, follows={"error": "value"})
    columns = read_table(path, form).columns
    order = np.argsort(columns[word], kind="stable")
    error = columns["error"][order] if "error" in columns else None
    if error is not None and error.min() < 0.0:
        raise CaseError([f"{path.name} holds an error below zero; give half widths in the unit of the value."])
    return Points(columns[word][order], columns["value"][order], error)


def take_value(value: float, error: float | None) -> Points:
    """A single number as points."""
    return Points(np.array([np.nan]), np.array([value]), None if error is None else np.array([error]))


def find_within(points: Points, known: Points) -> Points:
    """The points that lie where `known` reaches, from its first to its last; a single number as it is."""
    if len(known.x) == 1:
        return points
    slack = _ROUNDING * float(known.x[-1] - known.x[0])
    inside = (points.x >= known.x[0] - slack) & (points.x <= known.x[-1] + slack)
    return Points(points.x[inside], points.value[inside], None if points.error is None else points.error[inside])


def take_span(points: Points, span: tuple[float, float] | None) -> Points:
    """The points of a line within `span` [m]. Raises: CaseError if there are none."""
    if span is None:
        return points
    inside = (points.x >= span[0]) & (points.x <= span[1])
    if not inside.any():
        low, high = points.x[0], points.x[-1]
        given = f"no measured point lies in {span[0]:g} to {span[1]:g} m"
        raise CaseError([f"{given}, they are from {low:g} to {high:g} m; give another span."])
    return Points(points.x[inside], points.value[inside], None if points.error is None else points.error[inside])
