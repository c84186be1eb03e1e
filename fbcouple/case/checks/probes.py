"""Whether the probes of a case can be had: their names, phases and positions, and how much they write."""

from __future__ import annotations

import operator
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fbcouple.case.bed.probes import WAYS, list_points
from fbcouple.case.bed.region import read_mesh
from fbcouple.case.checks.bed import try_region
from fbcouple.case.checks.registry import check
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.probes import Probe
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.holders import find_holders
from fbcouple.geometry.polyhedra import find_centres, take_apart
from fbcouple.input_files.units import guess_frame
from fbcouple.results.probes import OF_GAS, OF_HEAT, count_columns

KEY = "output.probes"
MOST_POINTS = 10_000
MOST_NUMBERS = 50_000_000
"""Numbers of all sets in results.nc, 400 MB, which is rewritten while the run goes on."""
_NAME = re.compile(r"[a-z][a-z0-9_]*")
_ROUNDING = 1e-9


@check(KEY, "domain", "gas", "particles", "end_time")
def check_probes(case: Case, folder: Path) -> Iterator[Problem]:
    """Each set has a name of its own, quantities of a phase that is there, and points in the bed."""
    names: set[str] = set()
    for number, probe in enumerate(case.output.probes, start=1):
        for text in [*_check_words(case, probe, names), *_check_positions(case, folder, probe)]:
            yield Problem(KEY, f"set {number} ({show(probe.name)}): {text}")
        names.add(probe.name)


def _check_words(case: Case, probe: Probe, names: set[str]) -> Iterator[str]:
    if not _NAME.fullmatch(probe.name):
        allowed = "a small letter, then small letters, digits and underscores are allowed"
        yield f"{allowed} in a name; give such a name."
    if probe.name in names:
        yield "another set has this name; give each its own."
    if len(set(probe.quantities)) < len(probe.quantities):
        yield f"{show(probe.quantities)} is given; name each quantity once."
    for quantity in probe.quantities:
        section = "gas" if quantity in OF_GAS else "particles"
        if getattr(case, section) is None:
            yield f"{show(quantity)} is given and the case has no [{section}]; remove it or add [{section}]."
        if quantity in OF_HEAT and case.heat is None:
            yield f"{show(quantity)} is given and the case has no [heat]; remove it or add [heat]."
    if probe.start >= case.end_time:
        text = f"start = {probe.start:g} s is given and the run ends at {case.end_time:g} s"
        yield f"{text}; start before end_time."


def _check_ways(case: Case, probe: Probe) -> Iterator[str]:
    """Whether the set says in one way, and whole, where its points are."""
    given = [way for way in WAYS if getattr(probe, way) is not None]
    if len(given) != 1:
        text = f"{', '.join(given)} are given" if given else "none of them is given"
        yield f"one of {', '.join(WAYS)} says where the points are, {text}; give one (in m)."
        return
    if (probe.line is None) != (probe.count is None):
        missing, other = ("count", "line") if probe.count is None else ("line", "count")
        yield f"{other} is given and no {missing}; a line has both, points and a section have neither."
        return
    if probe.height is not None and case.domain.shape == "file":
        yield "height is given; a section wants a box or a cylinder, give the points of this mesh."
    if probe.height is not None and (count := case.domain.cells[0] * case.domain.cells[1]) > MOST_POINTS:
        yield f"height is given, with a point in each of {count} cells, at most {MOST_POINTS} are allowed; give points."


def _check_positions(case: Case, folder: Path, probe: Probe) -> Iterator[str]:
    if wrong := next(_check_ways(case, probe), None):
        yield wrong
        return
    points = list_points(probe, case.domain)
    if len(points) > MOST_POINTS:
        yield f"{len(points)} points are given, at most {MOST_POINTS} are allowed; part them among sets."
        return
    outside = _find_outside(case, folder, points)
    if outside.size:
        yield _format_outside(case, folder, points, outside)


@check(KEY, "end_time")
def check_size(case: Case, folder: Path) -> Iterator[Problem]:
    """The sets are not more than a file should hold that is rewritten all the time."""
    sets = [probe for probe in case.output.probes if not any(_check_ways(case, probe))]
    counts = [len(list_points(probe, case.domain)) for probe in sets]
    rates = [count_columns(probe.quantities) * count / probe.every for probe, count in zip(sets, counts, strict=True)]
    lengths = [max(case.end_time - probe.start, 0.0) for probe in sets]
    if (total := sum(map(operator.mul, rates, lengths))) > MOST_NUMBERS:
        text = f"{total:.3g} numbers up to the end are asked for, at most {MOST_NUMBERS:.3g} are allowed"
        yield Problem(KEY, f"{text}; sample more seldom (every), or fewer points or quantities.")


def _find_outside(case: Case, folder: Path, points: np.ndarray) -> np.ndarray:
    """Rows of the points that are not in the bed; none if its mesh cannot be read, which is told elsewhere."""
    if case.domain.shape == "box":
        size = np.array(case.domain.size)
        return np.flatnonzero(((points < -_ROUNDING * size) | (points > (1.0 + _ROUNDING) * size)).any(axis=1))
    if try_region(case, folder) is None:
        return np.empty(0, int)
    mesh = read_mesh(case, folder)
    cells = take_apart(mesh, find_centres(mesh), np.arange(mesh.count), np.arange(len(mesh.points)))
    return np.flatnonzero(find_holders(cells, points) < 0)


def _format_outside(case: Case, folder: Path, points: np.ndarray, outside: np.ndarray) -> str:
    row = int(outside[0])
    region = try_region(case, folder)
    low = np.array(region.corner if region else (0.0, 0.0, 0.0))
    high = low + case.domain.size
    ends = zip("xyz", low.tolist(), high.tolist(), strict=True)
    allowed = ", ".join(f"{axis} from {first:g} to {last:g}" for axis, first, last in ends)
    where = "the box" if case.domain.shape == "box" else "a cell of the mesh, which lies in the box"
    position = ", ".join(f"{value:g}" for value in points[row])
    more = f" and {len(outside) - 1} more are" if len(outside) > 1 else " is"
    guess = guess_frame(points.min(axis=0).tolist(), points.max(axis=0).tolist(), list(case.domain.size))
    guess = guess if region and not any(region.corner) else ""
    return (
        f"point {row + 1} at ({position}) m{more} not in {where} of {allowed} m{guess}; give points in the bed, in m."
    )
