"""How sure the time means had become, against what the run had cost by then: its error against run time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fbcouple.postproc.figures.registry import comparison, figure
from fbcouple.postproc.style import COLUMN, GREY, LINES, lay_out, mark_logarithm, wrap_label
from fbcouple.results.block_errors import compare_with_map, estimate_errors
from fbcouple.results.block_means import SAMPLES, START, has_blocks, pack_blocks
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results

MAPS = {"vertical solids flux": 4, "solids fraction": 0}
"""Depth-mean maps, and which number of a place in a block each is of."""
NOTE = "root mean square over the depth-mean map; dotted: as the root of the averaged time"
SHORT = 16
"""Letters of a label of which two stand side by side."""
_FEWEST = 3


@dataclass(frozen=True)
class Growing:
    """The standard error of a map over the map, root mean square, by the first blocks of the window: `error` (n,), with
    what the run had cost when the last of them was full, `core_hours` (n,), and at what `time` (n,) [s] that was."""

    error: np.ndarray
    core_hours: np.ndarray
    time: np.ndarray


def follow_error(results: Results, column: int) -> Growing:
    """The error of one of `MAPS` as the window grew, where it was known.

    Cost is the wall time of all coupling steps up to then times the ranks.

    Raises: NotMeantError without blocks of the solids, or of a pool; NotDrawableError if the window is too short to
    tell any error.
    """
    if not has_blocks(results.data) or results.replicas > 1:
        raise NotMeantError([f"{results.path} has no blocks of one run's window."])
    rows, starts = pack_blocks(results.data)[:, column], results.data[START].values
    full = results.data[SAMPLES].values >= results.data[SAMPLES].values[0]
    blocks, ends = rows[full], np.append(starts[1:], results.span[1])[full]
    found = []
    for count in range(_FEWEST, len(blocks) + 1):
        part = blocks[:count].reshape(count, -1, 1)
        found.append(compare_with_map(part.mean(axis=0), estimate_errors(part)))
    error, ends = np.array(found), ends[_FEWEST - 1 :]
    known = np.isfinite(error) & (error > 0.0) & (ends > results.span[0])  # blocks that are all alike tell none
    if not known.any():
        raise NotDrawableError([f"{results.path}: the window is too short against the correlation to tell an error."])
    return Growing(error[known], _count_core_hours(results, ends[known]), ends[known])


def _count_core_hours(results: Results, times: np.ndarray) -> np.ndarray:
    spent = results.history("wall_seconds").sum("stage").values.cumsum() * float(results.data.attrs.get("ranks", 1))
    return np.interp(times, results.data["time"].values, spent) / 3600.0


@figure
def means_error(results: Results) -> Figure:
    """Standard error of the mean maps of solids flux and fraction over the maps, against what the run had cost by
    then."""
    lines = {name: line for name, column in MAPS.items() if (line := _find_told(results, column))}
    if not lines:
        follow_error(results, MAPS["vertical solids flux"])
    picture = lay_out(results.title, COLUMN, 2.7, NOTE)
    axes = picture.subplots()
    for (name, line), style in zip(lines.items(), LINES, strict=False):
        _draw(axes, line, name, style, results)
    wanted = results.case.get("averages", {}).get("until_error")
    if wanted:
        axes.axhline(wanted, color=GREY, linewidth=0.8)
        axes.annotate(
            f"until_error = {wanted:g}",
            (0.02, wanted),
            (0, 2),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            color=GREY,
            size="small",
        )
    _finish(picture, axes)
    return picture


@comparison
def means_errors(runs: Sequence[Results]) -> Figure:
    """Standard error of the mean map of vertical solids flux over the map against what each run had cost."""
    told = [(run, line) for run in runs if (line := _find_told(run, MAPS["vertical solids flux"]))]
    if len(told) < 2:
        raise NotMeantError(["fewer than two runs tell an error of their means."])
    labels = [wrap_label(run.label) for run, _ in told]
    columns = 2 if max(map(len, labels)) <= SHORT else 1
    height = 2.5 + 0.16 * sum(label.count("\n") + 1 for label in labels) / columns
    picture = lay_out("Error of the mean solids flux against run time", COLUMN, height, NOTE)
    axes = picture.subplots()
    for (run, line), label, style in zip(told, labels, _cycle(len(told)), strict=True):
        _draw(axes, line, label, style, run)
    _finish(picture, axes, columns)
    return picture


def _find_told(results: Results, column: int) -> Growing | None:
    try:
        return follow_error(results, column)
    except NotDrawableError:
        return None


def _cycle(count: int) -> list[dict[str, object]]:
    return [LINES[number % len(LINES)] for number in range(count)]


def _draw(axes: Axes, line: Growing, name: str, style: dict[str, object], results: Results) -> None:
    """A line, and what its last point makes of the root of the averaged time."""
    begin = results.span[0]
    axes.loglog(line.core_hours, line.error, markersize=3.0, label=name, **style)
    guide = line.error[-1] * np.sqrt((line.time[-1] - begin) / (line.time - begin))
    axes.loglog(line.core_hours, guide, color=style["color"], linestyle=":", linewidth=0.8)


def _finish(picture: Figure, axes: Axes, columns: int = 2) -> None:
    axes.set(xlabel="Core-hours", ylabel="Standard error over the mean")
    for axis in (axes.xaxis, axes.yaxis):
        mark_logarithm(axis)
    picture.legend(loc="outside lower center", ncols=columns, handlelength=2.4)
