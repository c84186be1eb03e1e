"""Statistics of histories after the start-up: mean, standard error and deviation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fbcouple.postproc.joined_rows import find_lack
from fbcouple.results.reader import NotDrawableError, Results
from fbcouple.results.steady_part import FEWEST, FEWEST_TIMES, SIGNALS, estimate_error, find_start_up
from fbcouple.results.told import complete_told


@dataclass(frozen=True)
class Steady:
    """A history after its start-up, which ended at `start` [s]: its mean, the standard error of that, its deviation.

    If the start-up is not over, `start` is nan, and so are the numbers: there is no steady part to take them from.
    """

    name: str
    unit: str
    start: float
    end: float
    values: int
    mean: float
    stderr: float
    deviation: float


def summarise(results: Results, name: str) -> Steady:
    """Start-up, mean, standard error and deviation of the history `name`; its first row, before any step, is left out.

    Of replicas: mean and standard error over the averaging windows of all, from where the last of them is steady, and
    the rows and deviation of the first over its own, nan where its rows are not those of a run.
    Raises: NotDrawableError if the history has too few rows or has holes.
    """
    time, values, unit = _read(results, name)
    pooled = results.window_mean(name)
    window = results.first_window
    if pooled is None or window is None:
        return _summarise_rows(name, unit, time, values)
    starts = [one["steady_from"][name] for one in complete_told(results.data) if name in one.get("steady_from", {})]
    if None in starts or not starts:
        return _tell_none(name, unit, time)
    rest = values[(time > window[0]) & (time <= window[1])]
    deviation = math.nan if find_lack(results, name, is_of_spread=True) else float(rest.std())
    return Steady(name, unit, max(starts), float(time[-1]), len(rest), *pooled, deviation)


def _read(results: Results, name: str) -> tuple[np.ndarray, np.ndarray, str]:
    """Times, values and unit of a history after its first row. Raises: NotDrawableError."""
    history = results.history(name)[1:]
    if len(history) < FEWEST:
        raise NotDrawableError([f"`{name}` in {results.path} has {len(history)} rows, {FEWEST} are needed."])
    if not np.isfinite(history.values).all():
        raise NotDrawableError([f"`{name}` in {results.path} has rows that are not finite."])
    unit = str(history.attrs.get("units", results.data[name].attrs.get("units", "")))
    return history["time"].values.astype(float), history.values, unit


def _summarise_rows(name: str, unit: str, time: np.ndarray, values: np.ndarray) -> Steady:
    cut = find_start_up(values)
    if cut is None:
        return _tell_none(name, unit, time)
    rest = values[cut:]
    numbers = float(rest.mean()), estimate_error(rest), float(rest.std())
    return Steady(name, unit, float(time[cut]), float(time[-1]), len(rest), *numbers)


def _tell_none(name: str, unit: str, time: np.ndarray) -> Steady:
    return Steady(name, unit, math.nan, float(time[-1]), 0, math.nan, math.nan, math.nan)


def find_steady_time(results: Results) -> float:
    """Time [s] from which all of `SIGNALS` that the run has are steady; of replicas those of the first.

    Raises: NotDrawableError if it has none of them, or the start-up is not over for one.
    """
    found = []
    for name in [name for name in SIGNALS if name in results.data]:
        time, values, unit = _read(results, name)
        found.append(_summarise_rows(name, unit, time, values))
    if not found:
        raise NotDrawableError([f"{results.path} has none of {', '.join(SIGNALS)}."])
    waited = [steady.name for steady in found if math.isnan(steady.start)]
    if waited:
        raise NotDrawableError([format_not_reached(", ".join(waited), found[0].end)])
    return max(steady.start for steady in found)


def format_not_reached(name: str, end: float) -> str:
    """Why there are no numbers of the history `name` of a run that came to `end` [s], and what to do."""
    return f"{tell_not_reached(name, end)}; let the run go on."


def tell_not_reached(name: str, end: float) -> str:
    """Why the history `name` of a run that came to `end` [s] has no steady part."""
    need = f"a steady part of {FEWEST_TIMES} correlation times after it is not seen in the record"
    return f"the start-up is not over at t = {end:.3g} s ({name}: {need})"
