"""Runs on lines that were measured across the bed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fbcouple.input_files.measured_lines import QUANTITIES, Reference
from fbcouple.postproc.averaging import format_window, list_marks, mark_runs
from fbcouple.postproc.experiment import Measured, gather_references, line_of, name_place, read_run
from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.style import INK, LINES, PAGE, lay_out, wrap_label
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results

_ACROSS = 2


@figure
def measured_lines(results: Results) -> Figure:
    """The measured lines that the case names (output.references), and the run on them."""
    lines = gather_references([results], [])
    if not lines:
        raise NotMeantError([f"the case of {results.path} names no measured lines (output.references)."])
    return draw_measured_lines([results], lines, results.title)


def draw_measured_lines(
    runs: Sequence[Results], lines: Sequence[Measured], heading: str = "Against measured lines"
) -> Figure:
    """Draw each measured line with its errors and the runs that it belongs to."""
    across = min(_ACROSS, len(lines))
    rows = -(-len(lines) // across)
    windows = {format_window(run) for run in runs}
    means = f"time mean over {windows.pop()}" if len(windows) == 1 and windows != {""} else "time means of the runs"
    picture = lay_out(heading, PAGE, 0.6 + 2.1 * rows, f"marks: measured; lines: {means}{mark_runs(runs)}")
    grid = picture.subplots(rows, across, squeeze=False).ravel()
    for axes, measured in zip(grid, lines, strict=False):
        _draw_line(axes, runs, measured)
    for axes in grid[len(lines) :]:
        axes.remove()
    shown = [axes.get_legend_handles_labels() for axes in picture.axes]
    by_label = {label: handle for handles, labels in shown for handle, label in zip(handles, labels, strict=True)}
    picture.legend(list(by_label.values()), list(by_label), loc="outside lower center", ncols=4, handlelength=2.4)
    return picture


def _draw_line(axes: Axes, runs: Sequence[Results], measured: Measured) -> None:
    points, reference = measured.points, measured.reference
    look: dict[str, Any] = {"fmt": "o", "color": INK, "markersize": 3, "elinewidth": 0.7}
    axes.errorbar(1e3 * points.x, points.value, points.error, label="measured", **look)
    for number, run in enumerate(runs):
        if run.label not in measured.runs:
            continue
        drawn: dict[str, Any] = {key: LINES[number % len(LINES)][key] for key in ("color", "linestyle")}
        try:
            marks = "; ".join(mark.brief for mark in list_marks(run))
            label = wrap_label(f"{run.label} ({marks})" if marks else run.label, 26)
            x, line = _find_curve(run, reference)
            axes.plot(1e3 * x, line, label=label, **drawn)
        except NotDrawableError:
            continue  # the table says so
    unit = QUANTITIES[reference.quantity].replace(" ", "\u00a0")
    label = f"{reference.quantity.replace('_', ' ').capitalize()} [{'–' if unit == '1' else unit}]"
    axes.set(xlabel=f"{reference.axis} [mm]", ylabel=label)
    axes.set_title(name_place(reference), loc="left", size="small", pad=2.0)


def _find_curve(run: Results, reference: Reference) -> tuple[np.ndarray, np.ndarray]:
    """Where, in m, and what the run has on the line; gaps where no particle ever came."""
    if reference.is_radial:
        return read_run(run, reference)[:2]
    return run.data["x"].values, line_of(run, reference)
