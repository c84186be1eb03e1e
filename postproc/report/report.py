"""`fbcouple report`: runs on one HTML page that stands alone, and every number of its tables in a JSON file."""

from __future__ import annotations

import json
import logging
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from fbcouple.postproc.averaging import averaging_text, list_warnings
from fbcouple.postproc.differences import Difference, Point, compare, core_hours, draw_error_against_time
from fbcouple.postproc.experiment import Comparison, Measured, compare_with, gather_references, tell_given, tell_unread
from fbcouple.postproc.figures.heights import format_height, list_heights
from fbcouple.postproc.figures.measured_lines import draw_measured_lines
from fbcouple.postproc.figures.registry import COMPARISONS, FIGURES
from fbcouple.postproc.files import name_numbers, write_whole
from fbcouple.postproc.papers.hamidouche2019.claims import UNDECIDED, judge_claims
from fbcouple.postproc.papers.hamidouche2019.paper_runs import identify
from fbcouple.postproc.report import tables
from fbcouple.postproc.report.monitors import BEYOND
from fbcouple.postproc.report.pictures import make_picture
from fbcouple.postproc.report.predicted import tabulate_predicted
from fbcouple.postproc.report.wording import open_templates
from fbcouple.results.reader import NotDrawableError, Results, open_runs
from fbcouple.results.view import BED, View
from fbcouple.version import __version__

_FIRST = (
    "solids_fraction",
    "solids_flux",
    "agitation",
    "flux_profile",
    "radial_profiles",
    "depth_profiles",
    "slices",
    "moment_slices",
    "bed_views",
    "voidage_snapshots",
    "bubbles",
    "history",
    "spectrum",
)
"""Order of the figures of a run; others follow."""
_ELSEWHERE = ("measured_lines",)
"""Figures of a run that the comparison shows, with all runs in them."""
Content = dict[str, Any]

_log = logging.getLogger(__name__)


def write_report(folders: Sequence[Path], output: Path, references: Sequence[str] = (), view: View = BED) -> list[Path]:
    """Write the report of the runs in `folders` to `output` (HTML) and its numbers beside it (JSON).

    references: texts `quantity@height=file` besides those that the cases name; view: heights of profiles.
    Returns: the two files.
    Raises: CaseError if a run or a reference cannot be read, or `output` is no name of a page, or cannot be written.
    """
    numbers = name_numbers(output)
    runs = [replace(run, view=view) for run in open_runs(folders)]
    content = describe(runs, gather_references(runs, references))
    for text in content["warnings"]:
        _log.warning(text)
    page = _render(content, numbers.name)
    plain = tables.make_plain(_leave_out_pictures(content))
    text = json.dumps(plain, indent=1, allow_nan=False) + "\n"
    write_whole(output, lambda place: place.write_text(page, encoding="utf-8"))
    write_whole(numbers, lambda place: place.write_text(text, encoding="utf-8"))
    return [output, numbers]


def describe(runs: Sequence[Results], lines: Sequence[Measured]) -> Content:
    """Everything that the page shows: tables as lists of rows, pictures as data."""
    names = ", ".join(run.label for run in runs)
    content: Content = {
        "title": runs[0].title if len(runs) == 1 else f"Comparison of {names}",
        "version": __version__,
        "made": time.strftime("%Y-%m-%d %H:%M:%S %Z"),
        "runs": [_describe_run(run) for run in runs],
    }
    content["warnings"] = [*list_warnings(runs), *_list_beyond(content["runs"])]
    return content | _describe_comparison(runs, lines)


def _list_beyond(runs: Sequence[Content]) -> list[str]:
    """A sentence for each monitor of a run that is beyond its limit."""
    return [
        f"{run['label']}: {row['monitor']}: {row['value']:.4g}, wanted {row['wanted']}."
        for run in runs
        for row in run["monitors"]
        if row["verdict"] == BEYOND
    ]


def _describe_run(run: Results) -> Content:
    left_out: list[str] = []
    statistics, remarks = tables.tabulate_statistics(run)
    figures = [
        make_picture(lambda make=make: make(run), name, make.__doc__, run.label, left_out)  # type: ignore[misc]
        for name, make in sorted(FIGURES.items(), key=lambda item: _place(item[0]))
        if name not in _ELSEWHERE
    ]
    content: Content = {
        "label": run.label,
        "title": run.title,
        "solved": tables.tabulate_solved(run),
        "provenance": tables.tabulate_provenance(run),
        "figures": [figure for figure in figures if figure],
        "statistics": statistics,
        "spectra": _try(tables.tabulate_spectra, run),
        "onsets": _try(tables.tabulate_onsets, run),
        "mixing": _try(tables.tabulate_mixing, run),
        "bubbles": _try(tables.tabulate_bubbles, run),
        "monitors": tables.tabulate_monitors(run),
        "cost": _try(tables.tabulate_cost, run),
        "predicted": _try(tabulate_predicted, run),
        "parameters": tables.tabulate_parameters(run),
    }
    return content | {"left_out": remarks + left_out}


def _place(name: str) -> int:
    return _FIRST.index(name) if name in _FIRST else len(_FIRST)


def _try(tabulate: Callable[[Results], tables.Rows], run: Results) -> tables.Rows:
    """A table, or none where the figure of the same numbers says why there is none."""
    try:
        return tabulate(run)
    except NotDrawableError:
        return []


def _describe_comparison(runs: Sequence[Results], lines: Sequence[Measured]) -> Content:
    remarks: list[str] = tell_given(runs, lines) + tell_unread(lines)
    several = len(runs) > 1
    made = [
        make_picture(lambda make=make: make(runs), name, make.__doc__, "", remarks)  # type: ignore[misc]
        for name, make in COMPARISONS.items()
        if several
    ]
    differences, left_out = compare(runs)
    compared = _compare_with_all(runs, lines, remarks)
    points = _find_points(runs, differences, compared)
    base = _cost_of(runs[0]) if several else math.nan
    means = {run.label: averaging_text(run) for run in runs}
    drawings: Content = {"reference_figures": [], "error_figures": []}
    if compared:
        words = "Measured lines, and the runs on them."
        drawings["reference_figures"] = [
            make_picture(lambda: draw_measured_lines(runs, lines), "measured_lines", words, "", remarks)
        ]
    if points and several:
        words = "Error of each run against its core-hours per simulated second."
        floor = None if math.isnan(base) else base
        drawings["error_figures"] = [
            make_picture(lambda: draw_error_against_time(points, floor), "error_against_time", words, "", remarks)
        ]
    claims = [asdict(row) for row in judge_claims(runs)] if any(identify(run)[1] for run in runs) else []
    return {
        "comparisons": [figure for figure in made if figure],
        "cost": [_tell_cost(run) for run in runs],
        "settings": tables.tabulate_settings(runs) if several else [],
        "profile_height": _tell_height(runs[0]) if several else "",
        "differences": [_tell_difference(row) for row in differences],
        "means": means if compared else {},
        "references": [_tell_comparison(row, means[row.run]) for row in compared],
        "errors": [_tell_point(point) for point in points],
        "claims": claims,
        "decided": [row for row in claims if row["verdict"] != UNDECIDED],
        "remarks_on_comparison": remarks + left_out,
    } | {key: [figure for figure in figures if figure] for key, figures in drawings.items()}


def _compare_with_all(runs: Sequence[Results], lines: Sequence[Measured], remarks: list[str]) -> list[Comparison]:
    found = []
    for run in runs:
        for line in lines:
            if run.label not in line.runs:
                continue
            try:
                found.append(compare_with(run, line))
            except NotDrawableError as lack:
                remarks.append(f"{run.label}, {line.reference}: {lack}")
    return found


def _find_points(runs: Sequence[Results], differences: list[Difference], compared: list[Comparison]) -> list[Point]:
    """Errors with the run time that they were had for: relative differences, and rms over the measured range."""
    cost = {run.label: _cost_of(run) for run in runs}
    points = [
        Point(row.run, row.quantity, row.relative, row.noise * row.relative / row.l2 if row.l2 else 0.0, cost[row.run])
        for row in differences
    ]
    points += [
        Point(row.run, row.name, row.rms / row.range, row.noise / row.range, cost[row.run])
        for row in compared
        if row.range > 0.0
    ]
    return [point for point in points if math.isfinite(point.value) and math.isfinite(point.cost)]


def _tell_height(base: Results) -> str:
    """Where the profiles of the comparison are taken; nothing where the base has no solids."""
    try:
        return format_height(list_heights(base)[0], base).replace("$", "")
    except NotDrawableError:
        return ""


def _cost_of(run: Results) -> float:
    try:
        return core_hours(run)
    except NotDrawableError:
        return math.nan


def _tell_cost(run: Results) -> Content:
    ranks = run.data.attrs.get("ranks")
    return {
        "run": run.label,
        "core-hours per simulated second": _cost_of(run),
        "ranks": None if ranks is None else int(ranks),
        "simulated [s]": float(run.data["time"].values[-1]) if run.data.sizes.get("time") else math.nan,
        "cells": run.cells,
        "title": run.title,
    }


def _tell_difference(row: Difference) -> Content:
    return {
        "run": row.run,
        "quantity": row.quantity,
        "L1": row.l1,
        "L2": row.l2,
        "maximum": row.largest,
        "relative L2": row.relative,
        "L2 of statistical errors": row.noise,
    }


def _tell_comparison(row: Comparison, mean: str) -> Content:
    return {
        "run": row.run,
        "time mean of the run": mean,
        "line": row.name.removesuffix(", measured"),
        "file": row.reference.partition("=")[2],
        "unit": row.unit,
        "points": row.points,
        "rms": row.rms,
        "bias": row.bias,
        "maximum": row.largest,
        "error of measurement": row.error,
        "statistical error": row.noise,
        "measured range": row.range,
        "amplitude": row.amplitude,
        "measured zeros [m]": row.measured_zeros,
        "zeros [m]": row.zeros,
    }


def _tell_point(point: Point) -> Content:
    return {
        "run": point.run,
        "core-hours per simulated second": point.cost,
        "error of": point.error,
        "error": point.value,
        "statistical part": point.noise,
    }


def _leave_out_pictures(content: Content) -> Content:
    pictures = ("figures", "comparisons", "reference_figures", "error_figures")
    kept = {key: value for key, value in content.items() if key not in (*pictures, "decided")}
    return kept | {"runs": [{k: v for k, v in run.items() if k not in pictures} for run in content["runs"]]}


def _render(content: Content, json_name: str) -> str:
    return open_templates().get_template("report.html").render(content, json_name=json_name).lstrip()
