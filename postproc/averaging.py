"""The averaging window in words: from when to when, and whether it holds the start-up of the bed, or a change of the
inlet."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fbcouple.postproc.statistics import format_not_reached, summarise, tell_not_reached
from fbcouple.results.reader import NotDrawableError, Results
from fbcouple.results.start_up import LIMIT
from fbcouple.results.steady_part import FEWEST, SIGNALS
from fbcouple.results.told import DRIFT, LATER, OVER, complete_told

DIGITS = 2
"""Digits behind the first one of the length of a window to which its ends are written."""
UNSEEN, GOING_ON, INCLUDED = "start-up not seen to be over", "start-up not over", "start-up included"
_LATER = "`fbcouple pool RUN -o later.nc --from SECONDS`"
"""The command that takes the later blocks of a window."""


@dataclass(frozen=True)
class Mark:
    """What time means hold beside a steady bed, or may: briefly, for notes of figures and tables, and as a sentence."""

    brief: str
    sentence: str


def find_start_up_in_means(results: Results) -> Mark | None:
    """Whether the time means reach into the start-up; None if they do not, or the run has no such means or histories.

    The start-up is over where all of `SIGNALS` are steady; a row of the history before that within the window counts.
    A run that looked for the end of its start-up itself, in its maps, too, has told. Of replicas each counts.
    """
    if told := complete_told(results.data):
        return _mark_replicas(results, told)
    return _mark_found(results) if OVER in results.data.attrs else _mark_run(results)


def _mark_run(results: Results) -> Mark | None:
    known = [name for name in SIGNALS if name in results.data]
    is_averaged = any({"z", "y", "x"} <= set(field.dims) for field in results.data.data_vars.values())
    if results.window is None or not known or not is_averaged:
        return None
    means = f"the time means over {format_window(results)}"
    try:
        found = [summarise(results, name) for name in known]
    except NotDrawableError as lack:
        sentence = f"whether the start-up lies in {means} cannot be told: {lack}"
        return Mark(UNSEEN, sentence)
    going_on = [steady.name for steady in found if math.isnan(steady.start)]
    if going_on:
        sentence = f"{means} begin in the start-up: {format_not_reached(', '.join(going_on), found[0].end)}"
        return Mark(GOING_ON, sentence)
    last = max(found, key=lambda steady: steady.start)
    time = results.data["time"].values
    if not ((time >= results.window[0]) & (time < last.start)).any():
        return None
    sentence = f"{means} begin in the start-up: {last.name} is steady from {last.start:.3g} s on"
    sentence += f'; set averages.start to that, or to "auto", or take the blocks from then on: {_LATER}.'
    return Mark(INCLUDED, sentence)


def _mark_found(results: Results) -> Mark | None:
    about = results.data.attrs
    if about[OVER]:
        return None
    sentence = f"the run has not seen its start-up end ({_tell_drift(about)}): the time means over"
    sentence += f" {format_window(results)} begin where it drifts least; let it run longer."
    return Mark(GOING_ON, sentence)


def _tell_drift(about: Mapping[Any, Any]) -> str:
    drift = math.nan if about.get(DRIFT) is None else float(about[DRIFT])
    return "the record is too short to tell" if math.isnan(drift) else f"drift {drift:.3g}, at most {LIMIT:g} is wanted"


def _mark_replicas(results: Results, told: Sequence[Mapping[str, Any]]) -> Mark | None:
    """The marks of all replicas as one: how many have which, and why each."""
    names = [name for name in SIGNALS if name in results.data]
    found = [(one["name"], mark) for one in told if (mark := _mark_replica(one, names))]
    if not found:
        return None
    means = f"the time means over {format_window(results)}"
    if len(told) == 1:
        brief, sentence = found[0][1].brief, f"{means}: {found[0][1].sentence}"
        return Mark(brief, f"{sentence}; let the run go on, or begin its means later ({_LATER}).")
    briefs = [mark.brief for _, mark in found]
    parts = [f"{brief} in {briefs.count(brief)} of {len(told)} replicas" for brief in dict.fromkeys(briefs)]
    whys = "; ".join(f"{name}: {mark.sentence}" for name, mark in found)
    return Mark(
        "; ".join(parts), f"{means}: {whys}; let these go on, begin their means later ({_LATER}), or leave them out."
    )


def _mark_replica(one: Mapping[str, Any], names: Sequence[str]) -> Mark | None:
    """Why the means of a replica are marked; `names`: the histories that count."""
    if OVER in one:
        why = f"the run has not seen its start-up end ({_tell_drift(one)})"
        return None if one[OVER] else Mark(GOING_ON, why)
    if "steady_from" not in one:
        return Mark(UNSEEN, "an older file does not tell of its start-up; pool its run again")
    starts = one["steady_from"]
    if lacking := [name for name in names if name not in starts]:
        return Mark(UNSEEN, f"{', '.join(lacking)}: fewer than {FEWEST} rows, or one that is not finite")
    if going_on := [name for name in names if starts[name] is None]:
        return Mark(GOING_ON, tell_not_reached(", ".join(going_on), float(one["simulated"])))
    last = max(names, key=lambda name: starts[name], default="")
    if not last or one["first_row"] is None or starts[last] <= one["first_row"]:
        return None
    why = f"{last} is steady from {starts[last]:.3g} s on, and they begin at {one['window'][0]:.3g} s"
    return Mark(INCLUDED, f"{why} (by the rows that an older file has)" if one.get(LATER) else why)


def list_late(results: Results, name: str, start: float) -> list[str]:
    """That the history `name` is steady from `start` [s] on only, and the means begin before; of each of replicas."""
    told = [one for one in complete_told(results.data) if name in one.get("steady_from", {})]
    pairs = [(f" in {one['name']}", one["steady_from"][name], one["window"][0]) for one in told]
    if len(told) < 2 and results.window is not None:
        pairs = [("", start, results.window[0])]
    return [
        f"{name} is steady from {steady:.3g} s only{where}; the time means begin at {begin:.3g} s."
        for where, steady, begin in pairs
        if steady > begin
    ]


def find_inlet_change_in_means(results: Results) -> Mark | None:
    """Whether the inlet was changed, as the run went on from a checkpoint, within the averaging window."""
    times = [time for time in results.inlet_changes if any(start < time < end for start, end in results.windows)]
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
