"""A finished run of a measured bed against its data, and against what others computed of it: rows of a table."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fbcouple.postproc.averaging import list_warnings
from fbcouple.postproc.deviation import Deviation, find_deviation
from fbcouple.results.reader import NotDrawableError, Results
from fbcouple.validate.comparisons import COMPARISONS, Found, Task, find_unit
from fbcouple.validate.points import find_within
from fbcouple.validate.source import Bed, Scored

Row = dict[str, Any]
RUN = "this run"
WITHIN, BEYOND, UNDECIDED = "within", "BEYOND", "undecided"
_ROUNDING = 1e-9
"""Part of the bed's width by which a measured point may be outside of it: 43 mm are a little more than 0.043 m."""
SURE = 2.0
"""Standard errors by which a deviation is to be off what was wanted, or it is undecided."""


@dataclass(frozen=True)
class Panel:
    """What a picture shows of a measurement of several points: these, the run, and the peers whose points are known."""

    task: Task
    found: Found | None
    peers: tuple[Scored, ...]


@dataclass(frozen=True)
class Result:
    """All of a bed: the rows of the table, why rows are empty or to be read with care, and what can be drawn."""

    rows: list[Row]
    remarks: list[str]
    panels: list[Panel]


def score(bed: Bed, results: Results) -> Result:
    """Compare the run `results` with every measurement of `bed`; what it lacks for one is a remark."""
    rows: list[Row] = []
    remarks: list[str] = []
    panels: list[Panel] = []
    for task in bed.tasks:
        chosen, name = COMPARISONS[task.measurement.compare], task.measurement.name
        found: Found | None = None
        try:
            _require_in_bed(results, task)
            found = chosen.function(results, task)
        except NotDrawableError as lack:
            remarks.append(f"{name}: {lack}")
        rows.append(_score_run(task, found))
        peers = tuple(one for one in bed.peers if one.peer.of == name)
        rows += [_score_peer(task, one) for one in peers]
        remarks += [text for one in peers if (text := _tell_span(task, one))]
        if chosen.axis:
            panels.append(Panel(task, found, peers))
    return Result(rows, [*remarks, *list_warnings([results])], panels)


def _require_in_bed(results: Results, task: Task) -> None:
    """Raises: NotDrawableError if a line was measured outside of the run's bed, whatever the case was changed to."""
    if task.line is None:
        return
    left, width = results.corner[0], results.size[0]
    low, high = float(task.points.x[0]), float(task.points.x[-1])
    slack = _ROUNDING * width
    if low < left - slack or high > left + width + slack:
        text = f"it was measured from x = {low:g} to {high:g} m, the run's bed is from {left:g} to {left + width:g} m"
        raise NotDrawableError([f"{text}: it is another bed."])


def _score_run(task: Task, found: Found | None) -> Row:
    away = None if found is None else find_deviation(found.values, task.points.value, found.stderr)
    numbers: Row = {"computed": math.nan, "stderr": math.nan}
    if found is not None:
        numbers["computed"] = float(found.values.mean())
        if found.stderr is not None:
            numbers["stderr"] = float(np.sqrt(np.mean(found.stderr**2)))
    return _make_row(task, RUN, numbers, away, "")


def _score_peer(task: Task, one: Scored) -> Row:
    if one.points is None:
        row = _make_row(task, one.peer.name, {"computed": math.nan, "stderr": math.nan}, None, one.peer.source)
        return row | {"rms": one.peer.rms}
    within = find_within(task.points, one.points)
    values = one.points.value if len(one.points.x) == 1 else np.interp(within.x, one.points.x, one.points.value)
    away = find_deviation(values, within.value)
    numbers = {"computed": float(values.mean()), "stderr": math.nan}
    return _make_row(replace(task, points=within), one.peer.name, numbers, away, one.peer.source)


def _tell_span(task: Task, one: Scored) -> str:
    """Say that a peer is known along a part of the measured points only, and scored there."""
    if one.points is None or (count := len(find_within(task.points, one.points).x)) == len(task.points.x):
        return ""
    (first, last), unit = one.points.x[[0, -1]], COMPARISONS[task.measurement.compare].unit
    text = f"{task.measurement.name}: {one.peer.name} is known from {first:g} to {last:g} {unit}"
    return f"{text} and compared at the {count} of {len(task.points.x)} measured points there."


def _make_row(task: Task, by: str, numbers: Row, away: Deviation | None, source: str) -> Row:
    measurement, points = task.measurement, task.points
    known = away or Deviation(*[math.nan] * 6)
    return {
        "measurement": measurement.name,
        "by": by,
        "unit": find_unit(measurement),
        "points": len(points.x),
        "measured": float(points.value.mean()),
        "error of measurement": None if points.error is None else float(np.sqrt(np.mean(points.error**2))),
        **numbers,
        "bias": known.bias,
        "rms": known.rms,
        "rms stderr": known.rms_error,
        "largest": known.largest,
        "amplitude": known.amplitude,
        "amplitude stderr": known.amplitude_error,
        "wanted": measurement.wanted if by == RUN else None,
        "verdict": _judge(measurement.wanted, known) if by == RUN else "",
        "source": source,
    }


def _judge(wanted: float | None, away: Deviation) -> str:
    """Whether the deviation is within what was wanted; undecided within two of its standard errors."""
    if wanted is None or math.isnan(away.rms):
        return ""
    if not math.isnan(away.rms_error) and abs(away.rms - wanted) <= SURE * away.rms_error:
        return UNDECIDED
    return WITHIN if away.rms <= wanted else BEYOND
