"""The averaging window in words: from when to when, and whether it holds the start-up of the bed, or a change of the
inlet."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fbcouple.postproc.statistics import SIGNALS, format_not_reached, summarise
from fbcouple.results.reader import NotDrawableError, Results
from fbcouple.results.start_up import LIMIT

DIGITS = 2
"""Digits behind the first one of the length of a window to which its ends are written."""


@dataclass(frozen=True)
class Mark:
    """What time means hold beside a steady bed, or may: briefly, for notes of figures and tables, and as a sentence."""

    brief: str
    sentence: str


def find_start_up_in_means(results: Results) -> Mark | None:
    """Whether the time means reach into the start-up; None if they do not, or the run has no such means or histories.

    The start-up is over where all of `SIGNALS` are steady; a row of the history before that within the window counts.
    A run that looked for the end of its start-up itself, in its maps, too, has told.
    """
    if "start_up_over" in results.data.attrs:
        return _mark_found(results)
    known = [name for name in SIGNALS if name in results.data]
    is_averaged = any({"z", "y", "x"} <= set(field.dims) for field in results.data.data_vars.values())
    if results.window is None or not known or not is_averaged:
        return None
    means = f"the time means over {format_window(results)}"
    try:
        found = [summarise(results, name) for name in known]
    except NotDrawableError as lack:
        sentence = f"whether the start-up lies in {means} cannot be told: {lack}"
        return Mark("start-up not seen to be over", sentence)
    going_on = [steady.name for steady in found if math.isnan(steady.start)]
    if going_on:
        sentence = f"{means} begin in the start-up: {format_not_reached(', '.join(going_on), found[0].end)}"
        return Mark("start-up not over", sentence)
    last = max(found, key=lambda steady: steady.start)
    time = results.data["time"].values
    if not ((time >= results.window[0]) & (time < last.start)).any():
        return None
    sentence = f"{means} begin in the start-up: {last.name} is steady from {last.start:.3g} s on"
    sentence += '; set averages.start to that, or to "auto".'
    return Mark("start-up included", sentence)


def _mark_found(results: Results) -> Mark | None:
    about = results.data.attrs
    if about["start_up_over"]:
        return None
    drift = float(about.get("start_up_drift", math.nan))
    seen = "the record is too short to tell" if math.isnan(drift) else f"drift {drift:.3g}, at most {LIMIT:g} is wanted"
    sentence = f"the run has not seen its start-up end ({seen}): the time means over {format_window(results)}"
    return Mark("start-up not over", f"{sentence} begin where it drifts least; let it run longer.")


def find_inlet_change_in_means(results: Results) -> Mark | None:
    """Whether the inlet was changed, as the run went on from a checkpoint, within the averaging window."""
    if results.window is None:
        return None
    start, end = results.window
    times = [time for time in results.inlet_changes if start < time < end]
    if not times:
        return None
    when = ", ".join(f"{time:.4g} s" for time in times)
    sentence = f"the inlet was changed at {when}, within the time means over {format_window(results)}"
    return Mark(f"inlet changed at {when}", f"{sentence}: they are of both.")


def list_marks(results: Results) -> list[Mark]:
    """Everything that marks the time means of a run."""
    return [mark for find in (find_start_up_in_means, find_inlet_change_in_means) if (mark := find(results))]


def format_window(results: Results) -> str:
    """The averaging window, "0.02–0.05 s", to digits that its length makes sense of; nothing where there is none.

    The last step ends a little behind end_time: 0.05001 s.
    """
    if results.window is None:
        return ""
    length = results.window[1] - results.window[0]
    decimals = max(DIGITS - math.floor(math.log10(length)), 0) if length > 0.0 else 6
    start, end = (f"{round(time, decimals):.10g}" for time in results.window)
    return f"{start}–{end} s" + (f" of {results.replicas} replicas" if results.replicas > 1 else "")


def averaging_text(results: Results) -> str:
    """The averaging window, what marks its means, and whether the run has ended, for the note of a figure."""
    parts = [f"time mean over {format_window(results)}"] if results.window else []
    if parts and (axes := results.case.get("averages", {}).get("mirror")):
        parts.append(f"with mirror images in {' and '.join(axes)}")
    parts += [mark.brief for mark in list_marks(results)]
    return "; ".join(parts if results.complete else [*parts, "run not complete"])


def mark_runs(runs: Sequence[Results]) -> str:
    """For a note on several runs, "; start-up not over: a, b; ..." of those whose means are marked, or nothing."""
    marked: dict[str, list[str]] = {}
    for run in runs:
        for mark in list_marks(run):
            marked.setdefault(mark.brief, []).append(run.label)
    if len(runs) == 1:
        return "".join(f"; {brief}" for brief in marked)
    return "".join(f"; {brief}: {', '.join(labels)}" for brief, labels in marked.items())


def list_warnings(runs: Sequence[Results]) -> list[str]:
    """A sentence for each mark of the time means of each run."""
    return [f"{run.label}: {mark.sentence}" for run in runs for mark in list_marks(run)]
