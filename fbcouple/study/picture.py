"""Error against core-seconds a simulated second: a panel a measure, a colour a knob, the Pareto front as a line."""

from __future__ import annotations

import math
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from fbcouple.postproc.style import (
    BLUE,
    DPI,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PAGE,
    SKY,
    VERMILION,
    journal_style,
    mark_logarithm,
    save,
)

_COLOURS = (BLUE, VERMILION, GREEN, ORANGE, SKY, GREY)
_MARKERS = "os^DvPX*<>hp"
_PANEL = 2.9
"""Height of a panel [in]."""
_ROOM = 4.6, 2.2
"""About the size of its axes [in]."""
_OFFSETS = ((7.0, 5.0), (-7.0, 5.0), (7.0, -6.0), (-7.0, -6.0), (0.0, 9.0), (0.0, -9.0), (11.0, 0.0), (-11.0, 0.0))
"""Where the number of a point can stand [pt], the best first."""
_CLEAR = 7.0
"""Distance [pt] of a number from other points and numbers."""
Point = tuple[float, float]


def draw(rows: list[dict[str, Any]], knobs: list[str], title: str, path: Path) -> Path:
    """Draw the rows of `tabulate` to `path`; a member belongs to the first knob in which it is not the base."""
    shown = [row for row in rows if row["error"] and row["core_seconds_per_second"]]
    measures = list(dict.fromkeys(row["measure"] for row in rows))
    with journal_style():
        picture = Figure(figsize=(PAGE, _PANEL * len(measures) + 0.4), dpi=DPI, layout="constrained")
        FigureCanvasAgg(picture)
        picture.suptitle(title, parse_math=False, fontsize=9)
        panels = picture.subplots(len(measures), 1, squeeze=False)[:, 0]
        for axes, measure in zip(panels, measures, strict=True):
            _draw_panel(axes, [row for row in shown if row["measure"] == measure], knobs)
            if not any(row["measure"] == measure for row in shown):
                why = next((row["why"] for row in rows if row["measure"] == measure and row["why"]), "")
                text = textwrap.fill(f"no member has an error above zero{': ' * bool(why)}{why}", 70)
                axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", parse_math=False)
            axes.set_ylabel(f"{measure}\nrelative error [-]")
        panels[-1].set_xlabel("Core-seconds a simulated second")
        return save(picture, path, title)


def _draw_panel(axes: Axes, rows: list[dict[str, Any]], knobs: list[str]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    if not rows:
        return
    base = next((row for row in rows if row["member"] == "base"), rows[0])
    named: set[int] = set()
    for row in rows:
        differs = [n for n, knob in enumerate(knobs) if row[knob] != base[knob]]
        which = differs[0] if differs else len(knobs)
        label = (knobs[which] if differs else "base") if which not in named else None
        named.add(which)
        _draw_point(axes, row, which, label)
    front = sorted((row["core_seconds_per_second"], row["error"]) for row in rows if row["pareto"])
    axes.plot(*zip(*front, strict=True), color=INK, linewidth=0.8, linestyle="--", label="Pareto front", zorder=0)
    if any(map(_is_unsure, rows)):
        axes.plot([], [], "o", color=GREY, markerfacecolor="none", label="open: standard error\nnot known")
    _name_members(axes, rows)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    for axis in (axes.xaxis, axes.yaxis):
        mark_logarithm(axis)


def _draw_point(axes: Axes, row: dict[str, Any], which: int, label: str | None) -> None:
    """A member with the look of the knob `which`: with a bar, or open where its standard error is not known."""
    axes.errorbar(
        row["core_seconds_per_second"],
        row["error"],
        yerr=None if _is_unsure(row) else row["stderr"],
        fmt=_MARKERS[which % len(_MARKERS)],
        color=_COLOURS[which % len(_COLOURS)],
        markerfacecolor="none" if _is_unsure(row) else None,
        markersize=5,
        capsize=2,
        label=label,
    )


def _is_unsure(row: dict[str, Any]) -> bool:
    """Does chance play a part in the error of a row that nothing tells?"""
    return row["stderr"] is not None and math.isnan(row["stderr"])


def _name_members(axes: Axes, rows: list[dict[str, Any]]) -> None:
    """Number the members in the order of cost, and list the numbers above the panel."""
    ordered = sorted(rows, key=lambda row: row["core_seconds_per_second"])
    points = [(row["core_seconds_per_second"], row["error"]) for row in ordered]
    spots = place_numbers(measure_points(points, (axes.get_xlim(), axes.get_ylim())))
    for index, (point, offset) in enumerate(zip(points, spots, strict=True)):
        axes.annotate(
            str(index + 1), point, offset, textcoords="offset points", size=6, color=INK, ha="center", va="center"
        )
    names = [f"{index + 1}\u00a0{row['member']}" for index, row in enumerate(ordered)]
    words = textwrap.fill("   ".join(names), 120, break_on_hyphens=False)
    axes.set_title(words, loc="left", size=5.5, color=GREY, pad=3, parse_math=False)


def measure_points(points: list[Point], limits: tuple[Point, Point]) -> np.ndarray:
    """Where points of logarithmic axes with these `limits` lie [pt] in a panel of about its size; shape (n, 2)."""
    low, high = np.log(np.array(limits)).T
    shares = (np.log(np.array(points)) - low) / (high - low)
    return np.asarray(shares * np.array(_ROOM) * 72.0)


def place_numbers(points: np.ndarray) -> list[Point]:
    """For each of `points` (n, 2) [pt] the offset [pt] of its number that keeps clearest of all points and numbers."""
    offsets: list[Point] = []
    taken = [tuple(point) for point in points]
    for number, point in enumerate(points):
        others = [spot for index, spot in enumerate(taken) if index != number]

        def clearance(offset: Point, point: np.ndarray = point, others: list[Any] = others) -> float:
            return min((math.dist(point + offset, other) for other in others), default=math.inf)

        best = next((offset for offset in _OFFSETS if clearance(offset) >= _CLEAR), max(_OFFSETS, key=clearance))
        offsets.append(best)
        taken.append((float(point[0] + best[0]), float(point[1] + best[1])))
    return offsets
