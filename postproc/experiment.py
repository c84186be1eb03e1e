"""Runs beside measured lines: the run at the measured points, and the root mean square of the difference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from fbcouple.errors import CaseError
from fbcouple.reference import QUANTITIES, Points, Reference, parse_reference, read_points
from postproc.dataset import NotDrawableError, Results, at_height, depth_average, mass_average
from postproc.style import INK, LINES, PAGE, inset_axes, new_figure

_PARTICLE = ("solids_velocity", "agitation", "granular_temperature")
_VECTORS = ("solids_velocity", "solids_flux", "gas_velocity", "gas_flux")
_ACROSS = 2


@dataclass(frozen=True)
class Measured:
    """A measured line: what it is of, and its points."""

    reference: Reference
    points: Points


@dataclass(frozen=True)
class Comparison:
    """A run against a measured line, in the unit of the quantity.

    `rms` of run minus measurement at the measured points, `bias` their mean, `largest` the greatest distance; `error`
    is the root mean square of the errors that the measurement gives and `noise` that of the run's standard errors
    there (nan if there are none); `range` is largest minus smallest measured value. `zeros`: where the measured and
    where the run's line change sign, x [m].
    """

    run: str
    reference: str
    quantity: str
    unit: str
    height: float
    points: int
    rms: float
    bias: float
    largest: float
    range: float
    error: float
    noise: float
    measured_zeros: list[float]
    zeros: list[float]


def gather_references(runs: Sequence[Results], texts: Sequence[str]) -> list[Measured]:
    """Measured lines that the runs' cases name (files beside results.nc) and those of `texts`, each once.

    Raises: CaseError with every reference that cannot be read.
    """
    found: dict[tuple[str, float, bytes], Measured] = {}
    problems: list[str] = []
    named = [(text, run.path.parent) for run in runs for text in run.case.get("output", {}).get("references", [])]
    for text, folder in [*named, *((text, Path()) for text in texts)]:
        try:
            reference = parse_reference(text)
            points = read_points(folder / reference.file)
        except CaseError as error:
            problems += error.problems
            continue
        key = (reference.quantity, reference.height, points.x.tobytes() + points.value.tobytes())
        found.setdefault(key, Measured(reference, points))
    if problems:
        raise CaseError(problems)
    return list(found.values())


def line_of(results: Results, reference: Reference, suffix: str = "") -> np.ndarray:
    """The run's time mean along the reference's line, at its cell centres in x, averaged over the depth; shape (nx,).

    Quantities of particles are averaged with the solids as weight; of vectors it is the vertical component.
    """
    name = f"{reference.quantity}{suffix}"
    if suffix:
        flat = depth_average(results.error(name))
    else:
        flat = (mass_average if reference.quantity in _PARTICLE else _plain_average)(results, name)
    if reference.quantity in _VECTORS:
        flat = flat.sel(component="z", drop=True)
    return at_height(flat, reference.height).values


def _plain_average(results: Results, name: str) -> xr.DataArray:
    return depth_average(results.mean(name))


def compare_with(results: Results, measured: Measured) -> Comparison:
    """Compare a run with a measured line, linearly between its cell centres, constant from the last one to the wall.

    Raises: NotDrawableError if the run lacks the quantity, or never had particles on the line.
    """
    reference, points = measured.reference, measured.points
    x, line = results.data["x"].values, line_of(results, reference)
    if not np.isfinite(line).all():
        raise NotDrawableError([f"{results.label}: no particle ever came to some places of {reference}."])
    apart = np.interp(points.x, x, line) - points.value
    return Comparison(
        results.label,
        f"{reference.quantity}@{reference.height:g}={Path(reference.file).name}",
        reference.quantity,
        QUANTITIES[reference.quantity],
        reference.height,
        len(points.x),
        float(np.sqrt(np.mean(apart**2))),
        float(np.mean(apart)),
        float(np.max(np.abs(apart))),
        float(np.ptp(points.value)),
        math.nan if points.error is None else float(np.sqrt(np.mean(points.error**2))),
        _noise(results, measured),
        find_zeros(points.x, points.value),
        find_zeros(x, line),
    )


def _noise(results: Results, measured: Measured) -> float:
    try:
        line = line_of(results, measured.reference, "_stderr")
    except NotDrawableError:
        return math.nan
    return float(np.sqrt(np.mean(np.interp(measured.points.x, results.data["x"].values, line) ** 2)))


def find_zeros(x: np.ndarray, values: np.ndarray) -> list[float]:
    """Places where the straight lines between the points change sign; shape (n,) each."""
    before, after = values[:-1], values[1:]
    changes = np.flatnonzero(before * after < 0.0)
    part = before[changes] / (before[changes] - after[changes])
    return (x[changes] + part * (x[changes + 1] - x[changes])).tolist()


def draw_measured_lines(runs: Sequence[Results], lines: Sequence[Measured]) -> Figure:
    """Draw each measured line with its errors and the runs on it."""
    rows = -(-len(lines) // _ACROSS)
    each, gap, left, bottom = 1.75, 0.5, 0.66, 0.75
    body = bottom + rows * (each + gap)
    picture = new_figure("Against measured lines", PAGE, body, "marks: measured; lines: time means of the runs")
    room = (PAGE - _ACROSS * left - 0.15) / _ACROSS
    for place, measured in enumerate(lines):
        row, column = divmod(place, _ACROSS)
        axes = inset_axes(picture, left + column * (room + left), bottom + (rows - 1 - row) * (each + gap), room, each)
        points, reference = measured.points, measured.reference
        axes.errorbar(
            1e3 * points.x,
            points.value,
            points.error,
            fmt="o",
            color=INK,
            markersize=3,
            label="measured",
            elinewidth=0.7,
        )
        for number, run in enumerate(runs):
            look = {key: LINES[number % len(LINES)][key] for key in ("color", "linestyle")}
            try:
                axes.plot(1e3 * run.data["x"].values, line_of(run, reference), label=run.label, **look)
            except NotDrawableError:
                continue  # told in the table
        unit = (
            QUANTITIES[reference.quantity].replace("1", "–")
            if QUANTITIES[reference.quantity] == "1"
            else (QUANTITIES[reference.quantity])
        )
        axes.set(xlabel="x [mm]", ylabel=f"{reference.quantity.replace('_', ' ')} [{unit}]")
        axes.set_title(f"z = {1e3 * reference.height:g} mm", loc="left", size="small", pad=2.0)
    handles, labels = picture.axes[0].get_legend_handles_labels()
    picture.legend(handles, labels, loc="lower center", ncols=4, handlelength=2.4)
    return picture
