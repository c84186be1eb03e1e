"""What a validation leaves: CSV and JSON of its table, a picture of the measured points, and one page of HTML."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from fbcouple.postproc.style import INK, LINES, PAGE, journal_style, lay_out, save
from fbcouple.results.reader import Results
from fbcouple.results.tables import write_page, write_tables
from fbcouple.validate.comparisons import COMPARISONS, find_unit
from fbcouple.validate.runs import Fact, list_facts
from fbcouple.validate.score import BEYOND, RUN, Panel, Result
from fbcouple.validate.source import Bed

NAME = "validation"
COLUMNS = (
    "measurement",
    "by",
    "unit",
    "measured",
    "computed",
    "stderr",
    "rms",
    "rms stderr",
    "largest",
    "amplitude",
    "amplitude stderr",
    "wanted",
    "verdict",
)
"""What the terminal and the page show of a row; the files have all of it."""
_ACROSS = 2
_MILLI = {"m": ("mm", 1e3)}
"""Units of an axis that are drawn in another."""


def write_result(bed: Bed, results: Results, result: Result, folder: Path) -> tuple[list[Path], list[Fact]]:
    """Write validation.json, .csv, .png and .html to `folder`. Returns: the files, and the facts about the run."""
    facts = list_facts(bed, results)
    about = {"title": bed.title, "run": {fact["what"]: fact["value"] for fact in facts}, "remarks": result.remarks}
    files = write_tables(folder, NAME, {NAME: result.rows}, about)
    pictures = [draw(bed, result.panels, folder / f"{NAME}.png")] if result.panels else []
    rows = [{name: row[name] for name in COLUMNS} for row in map(drop_blank, result.rows)]
    sources = {row["by"]: row["source"] for row in result.rows}
    tables: dict[str, list[dict[str, Any]]] = {"Measured and computed": rows, "The run": facts}
    if peers := [{"by": by, "source": source} for by, source in sources.items() if source]:
        tables["What others computed"] = peers
    if result.remarks:
        tables["Remarks"] = [{"": text} for text in result.remarks]
    note = f"{bed.about.source}. Amplitude: largest less smallest computed value over the same of the measured ones."
    page = write_page(folder / f"{NAME}.html", bed.title, note, pictures, tables, _is_beyond)
    return [*files, *pictures, page], facts


def _is_beyond(row: dict[str, Any]) -> bool:
    return row.get("verdict") == BEYOND


def drop_blank(row: dict[str, Any]) -> dict[str, Any]:
    """The row with nothing in place of numbers that are not known."""
    return {key: None if isinstance(value, float) and math.isnan(value) else value for key, value in row.items()}


def draw(bed: Bed, panels: list[Panel], path: Path) -> Path:
    """Draw the measured points of each panel, the run and the peers."""
    across = min(_ACROSS, len(panels))
    rows = -(-len(panels) // across)
    with journal_style():
        note = "marks: measured; lines: this run and what others computed"
        picture = lay_out(bed.title, PAGE, 0.6 + 2.1 * rows, note)
        grid = picture.subplots(rows, across, squeeze=False).ravel()
        for axes, panel in zip(grid, panels, strict=False):
            _draw_panel(axes, panel)
        for axes in grid[len(panels) :]:
            axes.remove()
        shown = [axes.get_legend_handles_labels() for axes in picture.axes]
        by_label = {label: handle for handles, labels in shown for handle, label in zip(handles, labels, strict=True)}
        legend = picture.legend(
            list(by_label.values()), list(by_label), loc="outside lower center", ncols=4, handlelength=2.4
        )
        for text in legend.get_texts():
            text.set_parse_math(False)
        return save(picture, path, bed.title)


def _draw_panel(axes: Axes, panel: Panel) -> None:
    measurement, points = panel.task.measurement, panel.task.points
    chosen = COMPARISONS[measurement.compare]
    unit, scale = _MILLI.get(chosen.unit, (chosen.unit, 1.0))
    axes.errorbar(
        scale * points.x, points.value, points.error, fmt="o", color=INK, markersize=3, elinewidth=0.7, label="measured"
    )
    if panel.found is not None and panel.found.curve is not None:
        x, curve = panel.found.curve
        axes.plot(scale * x, curve, color=LINES[0]["color"], label=RUN)
    for number, one in enumerate(panel.peers, start=1):
        if one.points is not None:
            look = LINES[number % len(LINES)]
            axes.plot(
                scale * one.points.x,
                one.points.value,
                color=look["color"],
                linestyle=look["linestyle"],
                label=one.peer.name,
            )
    value = find_unit(measurement)
    axes.set(xlabel=f"{chosen.axis.capitalize()} [{unit}]" if chosen.axis != "x" else f"x [{unit}]")
    axes.set_ylabel(f"[{'–' if value == '1' else value}]")
    axes.set_title(measurement.name, loc="left", size="small", pad=2.0, parse_math=False)
