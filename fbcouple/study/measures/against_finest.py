"""Measures against the finest member: histories, maps, and how the bed moves."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import xarray as xr

from fbcouple.errors import CaseError
from fbcouple.input_files.measured_lines import QUANTITIES
from fbcouple.postproc.common_grid import bring_together
from fbcouple.postproc.measures import mean_of_history
from fbcouple.results.depth_means import depth_average
from fbcouple.results.reader import Results
from fbcouple.results.variables import HISTORIES
from fbcouple.study.measures.registry import Error, Finished, measure


@measure("finest", arguments=tuple(HISTORIES), needs_reference=True)
def compare_finest(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Root mean square distance of a history from the finest member's, over the range of that one."""
    assert reference is not None
    here, there = run.results.history(argument), reference.results.history(argument)
    known = np.isfinite(there.values)
    time, wanted = there["time"].values[known], there.values[known]
    found = np.isfinite(here.values)
    values = np.interp(time, here["time"].values[found], here.values[found])
    scale = float(np.ptp(wanted)) or abs(float(wanted[-1])) or 1.0
    error = float(np.sqrt(np.mean((values - wanted) ** 2))) / scale
    return Error(float(values[-1]), float(wanted[-1]), HISTORIES[argument][0], error)


@measure("history-mean", arguments=tuple(HISTORIES), needs_reference=True)
def compare_history_mean(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Time mean of a history over the averaging window against the finest member's; `stderr` is that of both."""
    assert reference is not None
    here, there = (mean_of_history(one.results, argument) for one in (run, reference))
    if not there.value:
        raise CaseError([f"history-mean:{argument}: the finest member's is 0, and nothing is a part of it."])
    error, chance = abs(here.value / there.value - 1.0), math.hypot(here.error, there.error) / abs(there.value)
    return Error(here.value, there.value, HISTORIES[argument][0], error, chance)


@measure("means", arguments=tuple(QUANTITIES), needs_reference=True, needs=("[averages]",))
def compare_means(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Root mean square distance of a time mean over width and height from the finest member's, depth means both, on the
    coarser of their meshes, over the range of the finest member's; `stderr` is the distance that the block errors of
    the two alone would make, nan where they are not known."""
    return _compare_maps(run, "means", argument, reference, lambda there: float(there.max() - there.min()))


@measure("maps", arguments=tuple(QUANTITIES), needs_reference=True, needs=("[averages]",))
def compare_maps(run: Finished, argument: str, reference: Finished | None) -> Error:
    """As `means`, over the root mean square of the finest member's map in place of its range: so the standard error of
    a map is told, `averages.until_error`."""
    return _compare_maps(run, "maps", argument, reference, lambda there: math.sqrt(float((there**2).mean())))


def _compare_maps(
    run: Finished,
    kind: str,
    argument: str,
    reference: Finished | None,
    find_scale: Callable[[xr.DataArray], float],
) -> Error:
    assert reference is not None
    size, name = reference.results.size, f"{kind}:{argument}"
    if not np.allclose(run.results.size, size, rtol=1e-9):
        raise CaseError([f"{name}: the box is not that of the finest member, and maps of both have no common grid."])
    finest = _average(reference.results, argument)
    here, there = bring_together(_average(run.results, argument), finest, size, with_gaps=True)
    own, others = (_average(one.results, f"{argument}_stderr") for one in (run, reference))
    noise = np.hypot(*bring_together(own, others, size, with_gaps=True)) ** 2
    known = np.isfinite(here - there)
    scale = find_scale(finest)
    if not known.any() or not scale:
        raise CaseError([f"{name}: the map of the finest member is 0, or has no place in common with this one."])
    rms = math.sqrt(float(np.mean((here - there)[known] ** 2)))
    told = noise[known & np.isfinite(noise)]
    chance = math.sqrt(float(told.mean())) / scale if told.size else math.nan
    return Error(float(here[known].mean()), float(there[known].mean()), QUANTITIES[argument], rms / scale, chance)


def _average(results: Results, name: str) -> xr.DataArray:
    """Depth average of a time mean, (z, x), of a vector its vertical component. Raises: NotDrawableError without it."""
    field = results.error(name)  # nan where nothing is known of it
    return depth_average(field.sel(component="z", drop=True) if "component" in field.dims else field)
