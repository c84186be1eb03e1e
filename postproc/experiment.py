"""Runs beside measured lines: the run at the measured points, and the root mean square of the difference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.input_files.companion_files import find_companion
from fbcouple.input_files.measured_lines import QUANTITIES, Points, Reference, parse_reference, read_line
from fbcouple.postproc.deviation import find_deviation
from fbcouple.postproc.radial import PARTICLE, find_radial_profile
from fbcouple.results.depth_means import at_height, depth_average, mass_average, share_depth
from fbcouple.results.reader import NotDrawableError, Results

_ROUNDING = 1e-9
_VECTORS = ("solids_velocity", "solids_flux", "gas_velocity", "gas_flux")


@dataclass(frozen=True)
class Measured:
    """A measured line: what it is of, its points, the labels of the runs that it is compared with, and how it was given
    for all of them, if it was."""

    reference: Reference
    points: Points
    runs: frozenset[str] = frozenset()
    given: str | None = None


@dataclass(frozen=True)
class Comparison:
    """A run against a measured line, in the unit of the quantity.

    `rms` of run minus measurement at the measured points, `bias` their mean, `largest` the greatest distance; `error`
    is the root mean square of the errors that the measurement gives and `noise` that of the run's standard errors
    there (nan if there are none); `range` is largest minus smallest measured value, `amplitude` that of the run at the
    same points over it. `zeros`: where the measured and where the run's line change sign, x [m]. `name`: the line in
    words, for legends.
    """

    run: str
    reference: str
    name: str
    quantity: str
    unit: str
    height: float
    points: int
    rms: float
    bias: float
    largest: float
    range: float
    amplitude: float
    error: float
    noise: float
    measured_zeros: list[float]
    zeros: list[float]


def gather_references(runs: Sequence[Results], texts: Sequence[str]) -> list[Measured]:
    """Measured lines, each once: those that a run's case names belong to that run, those of `texts` to all runs.

    The files of a case lie beside its results.nc, as `output.references` has them; those of `texts` anywhere.

    Raises: CaseError with every reference that cannot be read, or does not fit into the bed of a run that it is for.
    """
    found: dict[tuple[str, bytes], Measured] = {}
    problems: list[str] = []
    named = [(run, text, False) for run in runs for text in _list_named(run)]
    for run, text, is_given in [*named, *((run, text, True) for text in texts for run in runs)]:
        try:
            reference = parse_reference(text)
            points = _read_for(run, reference, is_given)
        except CaseError as error:
            problems += [problem for problem in error.problems if problem not in problems]
            continue
        key = (reference.name, points.x.tobytes() + points.value.tobytes())
        known = found.get(key, Measured(reference, points))
        found[key] = replace(known, runs=known.runs | {run.label}, given=str(reference) if is_given else known.given)
    if problems:
        raise CaseError(problems)
    return list(found.values())


def _list_named(run: Results) -> list[str]:
    """The references of the run's case; results.nc may come from anybody."""
    output = run.case.get("output", {})
    named = output.get("references", []) if isinstance(output, dict) else None
    if not isinstance(named, list) or not all(isinstance(text, str) for text in named):
        raise CaseError([f"{run.path}: output.references of its case is no list of texts; set the run up again."])
    if "replicas_of" in run.data.attrs:  # a file of a pool may be anywhere
        return [text for text in named if (run.path.parent / parse_reference(text).file).is_file()]
    return named


def _read_for(run: Results, reference: Reference, is_given: bool) -> Points:
    try:
        path = Path(reference.file) if is_given else find_companion(run.path.parent, reference.file, ".csv")
        return read_line(reference, path, run.size, run.corner)
    except CaseError as error:
        raise CaseError([f"{run.label}, {reference}: {problem}" for problem in error.problems]) from None


def tell_given(runs: Sequence[Results], lines: Sequence[Measured]) -> list[str]:
    """Remarks on the lines that were given for all of several runs, whatever their cases say."""
    if len(runs) < 2:
        return []
    return [
        f"{line.given}: given by --reference, so all {len(runs)} runs are compared with it; whether the experiment is "
        "that of their cases is not known."
        for line in lines
        if line.given
    ]


def tell_unread(lines: Sequence[Measured]) -> list[str]:
    """Remarks on columns of files of measured lines that are not looked at."""
    return [
        f"{line.reference}: its columns {', '.join(map(repr, line.points.unread))[:200]} are not looked at; half "
        "widths of error bars are read from a column `error`."
        for line in lines
        if line.points.unread
    ]


def line_of(results: Results, reference: Reference, suffix: str = "") -> np.ndarray:
    """The run's time mean along the reference's line, at its cell centres in x, averaged over the depth, or its part;
    shape (nx,).

    Quantities of particles are averaged with the solids as weight; of vectors it is the vertical component.
    """
    name = f"{reference.quantity}{suffix}"
    shares = share_depth(results, reference.depth) if reference.depth else None
    if reference.quantity in PARTICLE:
        flat = mass_average(results, name, shares)
    elif suffix:
        flat = depth_average(results.error(name), shares)
    else:
        flat = depth_average(results.mean(name), shares)
    if reference.quantity in _VECTORS:
        flat = flat.sel(component="z", drop=True)
    return at_height(flat, reference.height).values


def name_line(reference: Reference) -> str:
    """A measured line in words: "solids velocity at z = 25 mm, measured"."""
    return f"{reference.quantity.replace('_', ' ')} at {name_place(reference)}, measured"


def name_place(reference: Reference) -> str:
    """Where a line lies: "z = 25 mm", with "y = 0 to 5 mm" of a part of the depth."""
    if reference.is_radial:
        return f"z = {1e3 * reference.height:.6g} mm, over the radius"
    part = f", y = {1e3 * reference.depth[0]:.6g} to {1e3 * reference.depth[1]:.6g} mm" if reference.depth else ""
    return f"z = {1e3 * reference.height:.6g} mm{part}"


def compare_with(results: Results, measured: Measured) -> Comparison:
    """Compare a run with a measured line, linearly between its cell centres, constant from the last one to the wall.

    Raises: NotDrawableError if the run lacks the quantity, or never had particles on the line.
    """
    reference, points = measured.reference, measured.points
    x, line, errors = read_run(results, reference)
    away = find_deviation(np.interp(points.x, x, line), points.value)
    return Comparison(
        results.label,
        f"{reference.name}={Path(reference.file).name}",
        name_line(reference),
        reference.quantity,
        QUANTITIES[reference.quantity],
        reference.height,
        len(points.x),
        away.rms,
        away.bias,
        away.largest,
        float(np.ptp(points.value)),
        away.amplitude,
        math.nan if points.error is None else float(np.sqrt(np.mean(points.error**2))),
        math.nan if errors is None else float(np.sqrt(np.mean(np.interp(points.x, x, errors) ** 2))),
        find_zeros(points.x, points.value),
        find_zeros(x, line),
    )


def read_run(results: Results, reference: Reference) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Places x [m] of the run's cells along a reference's line, or r of its rings, its values and their standard errors
    there, None without; shape (n,) each.

    Raises: NotDrawableError if the run lacks the quantity, or never had particles on the line.
    """
    if reference.is_radial:
        return _read_rings(results, reference)
    x, line = _leave_outside(results, reference, line_of(results, reference))
    _require_known(results, reference, line)
    try:
        _, errors = _leave_outside(results, reference, line_of(results, reference, "_stderr"))
    except NotDrawableError:
        return x, line, None
    return x, line, errors


def _read_rings(results: Results, reference: Reference) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    if results.case["domain"].get("shape", "box") == "box":
        raise NotDrawableError([f"{results.label}: {reference} is over a radius, and the bed is a box."])
    profile = find_radial_profile(results, reference.quantity, reference.height - results.corner[2])
    _require_known(results, reference, profile.value)
    return profile.radius, profile.value, profile.stderr


def _require_known(results: Results, reference: Reference, line: np.ndarray) -> None:
    if not np.isfinite(line).all():
        raise NotDrawableError([f"{results.label}: no particle ever came to some places of {reference}."])


def _leave_outside(results: Results, reference: Reference, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places x [m] and the values of `line` (nx,) there, without columns that are outside of a mesh at that height.

    Raises: NotDrawableError if all of them are.
    """
    x = results.data["x"].values
    if results.is_box:
        return x, line
    places = results.data["inside"]
    if reference.depth:
        places = places & (share_depth(results, reference.depth) > 0.0)
    inside = at_height(places.any("y").astype(float), reference.height).values > 1.0 - _ROUNDING
    if not inside.any():
        raise NotDrawableError([f"{results.label}: the mesh has no cell on the line of {reference}."])
    return x[inside], line[inside]


def find_zeros(x: np.ndarray, values: np.ndarray) -> list[float]:
    """Places where the straight lines between the points change sign, or a point is 0 between two of different signs;
    shape (n,) each."""
    before, after = values[:-1], values[1:]
    changes = np.flatnonzero(before * after < 0.0)
    part = before[changes] / (before[changes] - after[changes])
    points = 1 + np.flatnonzero((values[1:-1] == 0.0) & (values[:-2] * values[2:] < 0.0))
    return sorted([*(x[changes] + part * (x[changes + 1] - x[changes])).tolist(), *x[points].tolist()])
