"""How far runs differ: error norms of maps and profiles on the coarser grid, against what the runs cost."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fbcouple.postproc.common_grid import bring_together
from fbcouple.postproc.figures.heights import list_heights
from fbcouple.postproc.scales import velocity_scale
from fbcouple.postproc.style import GREY, LINES, PAGE, lay_out, mark_logarithm, wrap_label
from fbcouple.results.depth_means import at_height, depth_average
from fbcouple.results.reader import NotDrawableError, Results

Field = Callable[[Results, str], xr.DataArray]
FIELDS: dict[str, Field] = {}
"""What is compared, dimensionless, on (z, x) or one of them; the suffix "_stderr" asks for its standard error."""
MARKS = "os^DvPX*<>h"
"""With the eight colours of lines 88 different looks."""
FLUX_PROFILE = "profile of the vertical solids flux over ρ U_f"
"""Taken at the first of the base's heights of profiles."""


@dataclass(frozen=True)
class Difference:
    """Norms of run minus base over the box, each cell weighted by its volume; dimensionless as the field is.

    `l1` mean of the absolute difference, `l2` root mean square, `largest` maximum; `relative` is l2 over the root mean
    square of the base. `noise` is the l2 that the statistical errors of both runs make alone (an upper bound, as errors
    along the depth count as correlated); nan if a run has no errors yet.
    """

    run: str
    base: str
    quantity: str
    l1: float
    l2: float
    largest: float
    relative: float
    noise: float


def field(name: str) -> Callable[[Field], Field]:
    """Register a field under the words of the table."""

    def register(function: Field) -> Field:
        FIELDS[name] = function
        return function

    return register


@field("map of the solids fraction")
def _solids_fraction(results: Results, suffix: str) -> xr.DataArray:
    return depth_average(results.mean(f"solids_fraction{suffix}"))


def _flux_scale(results: Results) -> float:
    if results.gas_flux is None:
        raise NotDrawableError([f"{results.path} has no inlet flow of gas to put fluxes in proportion to."])
    return results.gas_flux


@field("map of the vertical solids flux over ρ U_f")
def _vertical_flux(results: Results, suffix: str) -> xr.DataArray:
    return depth_average(results.mean(f"solids_flux{suffix}").sel(component="z", drop=True)) / _flux_scale(results)


@field("map of the horizontal solids flux over ρ U_f")
def _horizontal_flux(results: Results, suffix: str) -> xr.DataArray:
    return depth_average(results.mean(f"solids_flux{suffix}").sel(component="x", drop=True)) / _flux_scale(results)


@field("map of the vertical gas flux over U_f")
def _gas_flux(results: Results, suffix: str) -> xr.DataArray:
    return depth_average(results.mean(f"gas_flux{suffix}").sel(component="z", drop=True)) / velocity_scale(results)[0]


@field(FLUX_PROFILE)
def _flux_profile(results: Results, suffix: str) -> xr.DataArray:
    return at_height(_vertical_flux(results, suffix), results.corner[2] + list_heights(results)[0])


@field("profile over the height of the solids fraction")
def _height_profile(results: Results, suffix: str) -> xr.DataArray:
    return _solids_fraction(results, suffix).mean("x")


def compare(runs: Sequence[Results]) -> tuple[list[Difference], list[str]]:
    """Differences of every run to the first, and why some could not be told."""
    base = runs[0]
    rows, left_out = [], []
    for run in runs[1:]:
        if not np.allclose(run.size, base.size, rtol=1e-9):
            left_out.append(f"{run.label} is not compared with {base.label}: their boxes differ.")
            continue
        for name in FIELDS:
            try:
                rows.append(find_difference(run, base, name))
            except NotDrawableError as lack:
                left_out.append(f"{name}: {lack}")
    return rows, left_out


def find_difference(run: Results, base: Results, name: str) -> Difference:
    """Norms of field `name` of `run` minus that of `base`, both on the coarser of their grids along each axis."""
    if name == FLUX_PROFILE:
        run, base = (replace(each, view=replace(each.view, heights=list_heights(base)[:1])) for each in (run, base))
    one, other = bring_together(FIELDS[name](run, ""), FIELDS[name](base, ""), run.size)
    inside = np.isfinite(one) & np.isfinite(other)
    if not inside.any():
        raise NotDrawableError([f"{run.label} and {base.label} have no place of it in common."])
    apart, other = (one - other)[inside], other[inside]
    root = float(np.sqrt(np.mean(other**2)))
    l2 = float(np.sqrt(np.mean(apart**2)))
    relative = l2 / root if root > 0.0 else np.nan
    largest = float(np.max(np.abs(apart)))
    return Difference(
        run.label, base.label, name, float(np.mean(np.abs(apart))), l2, largest, relative, _noise(run, base, name)
    )


def _noise(run: Results, base: Results, name: str) -> float:
    try:
        errors = bring_together(FIELDS[name](run, "_stderr"), FIELDS[name](base, "_stderr"), run.size)
    except NotDrawableError:
        return np.nan
    squares = errors[0] ** 2 + errors[1] ** 2
    known = np.isfinite(squares)
    return float(np.sqrt(np.mean(squares[known]))) if known.any() else np.nan


def core_hours(results: Results) -> float:
    """Core-hours per simulated second; NotDrawableError if the results do not tell both."""
    time = results.simulated
    if "core_seconds" not in results.data.attrs or time <= 0.0:
        raise NotDrawableError([f"{results.path} does not tell its `core_seconds` or has no time yet."])
    return float(results.data.attrs["core_seconds"]) / 3600.0 / time


@dataclass(frozen=True)
class Point:
    """An error of a run, in words what of, and the core-hours per simulated second that the run took."""

    run: str
    error: str
    value: float
    noise: float
    cost: float


def draw_error_against_time(points: Sequence[Point], base: float | None) -> Figure:
    """Draw each error above 0 against run time: a colour and a mark of its own an error, a name above it a run.

    base: run time of the run that the others are compared with, as a dotted line.
    """
    shown = [point for point in points if point.value > 0.0]
    if not shown:
        raise NotDrawableError(["no error above 0 to draw against run time."])
    errors = list(dict.fromkeys(point.error for point in shown))
    costs = {point.run: point.cost for point in shown}
    names = {error: wrap_label(error, 44) for error in errors}
    lines = sum(name.count("\n") + 1 for name in names.values())
    note = "" if base is None else "dotted line: run time of the run that the others are compared with"
    body = max(2.9 + 0.13 * len(costs), 0.6 + 0.15 * lines)
    picture = lay_out("Error against run time", PAGE, body, note)
    axes = picture.subplots()
    for number, error in enumerate(errors):
        line = sorted((point.cost, point.value) for point in shown if point.error == error)
        look = {"color": LINES[number % len(LINES)]["color"], "marker": MARKS[number % len(MARKS)]}
        axes.plot(*zip(*line, strict=True), linewidth=0.7, markersize=4, label=names[error], **look)
    axes.set(xscale="log", yscale="log", xlabel="Core-hours per simulated second", ylabel="Error [–]")
    axes.margins(x=0.12, y=0.08)
    axes.grid(which="major", linewidth=0.4)
    for axis in (axes.xaxis, axes.yaxis):
        mark_logarithm(axis)
    _name_runs(axes, costs)
    if base is not None:
        axes.axvline(base, color=GREY, linestyle=":", linewidth=1.0)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=1.8)
    return picture


def _name_runs(axes: Axes, costs: dict[str, float]) -> None:
    """The name of each run above its run time, each on a line of its own."""
    low, high = axes.get_xlim()
    for row, (run, cost) in enumerate(sorted(costs.items(), key=lambda item: item[1])):
        is_left = cost < math.sqrt(low * high)
        axes.axvline(cost, color=GREY, linewidth=0.4, zorder=0)
        axes.annotate(
            f"| {run}" if is_left else f"{run} |",
            (cost, 1.0),
            (0, 3 + 9 * row),
            xycoords=axes.get_xaxis_transform(),
            textcoords="offset points",
            ha="left" if is_left else "right",
            size="small",
            parse_math=False,
        )
