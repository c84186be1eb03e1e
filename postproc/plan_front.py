"""What a plan found: error of the means against cost, with the Pareto front of a case."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from fbcouple.errors import CaseError
from fbcouple.postproc.style import INK, LINES, PAGE, VERMILION, journal_style, lay_out, mark_logarithm, save

FORMATS = (".png", ".svg", ".pdf")
COSTS = {"wall_seconds": "wall time [s]", "core_hours": "core-hours [h]"}
"""What a plan without a time counts as cost, and one with a time."""
_BODY = 3.2
"""Height of the axes [in]."""
_KNOBS = ("preset and fluid step", "overlap", "cells over d", "parcels")


def require_format(path: Path) -> None:
    """Raise CaseError if the name of a picture ends in none of `FORMATS`."""
    if path.suffix not in FORMATS:
        allowed = ", ".join(FORMATS)
        raise CaseError([f"--picture: {path.name} is given, a name that ends in {allowed} is allowed."])


def draw_front(plan: dict[str, Any], path: Path) -> Path:
    """Draw the numbers of a plan, as `Plan.describe` has them, to `path` in the format of its ending.

    Returns: the file. Raises: CaseError if it is of another format or cannot be written.
    """
    require_format(path)
    note = "Lines: the same numerics with longer means. Dashed: the Pareto front, the least cost of an error."
    if plan["within_seconds"] is not None:
        note += f" Nothing is shown that takes longer than {plan['within_seconds']:g} s."
    title = f"{plan['case']}: error of the mean map of solids flux against cost, on {plan['ranks']} ranks"
    with journal_style():
        figure = lay_out(title, PAGE, _BODY, note)
        axes = figure.subplots()
        _draw_curves(axes, plan)
        return save(figure, path, title)


def _draw_curves(axes: Axes, plan: dict[str, Any]) -> None:
    cost = "wall_seconds" if plan["within_seconds"] is None else "core_hours"
    axes.set_xscale("log")
    axes.set_yscale("log")
    for look, curve in zip(LINES * len(plan["curves"]), plan["curves"], strict=False):
        label = ", ".join(curve[0][knob] for knob in curve[0] if knob in _KNOBS)
        axes.plot(*_list_points(curve, cost), markersize=3, linewidth=0.8, label=label, **look)
    if plan["front"]:
        axes.plot(
            *_list_points(plan["front"], cost), "--", color=INK, linewidth=2.4, alpha=0.45, zorder=0, label="front"
        )
    for key, label in (("chosen", "chosen"), ("best", "the best that can be had")):
        if plan[key]:
            axes.plot(*_list_points([plan[key]], cost), "o", mfc="none", mec=VERMILION, markersize=11, label=label)
    axes.axhline(plan["error"], color=INK, linewidth=0.6, linestyle=":", label="wanted")
    axes.set_xlabel(COSTS[cost])
    axes.set_ylabel("error over the map [-]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    for axis in (axes.xaxis, axes.yaxis):
        mark_logarithm(axis)


def _list_points(rows: list[dict[str, Any]], cost: str) -> tuple[list[float], list[float]]:
    return [row[cost] for row in rows], [row["error"] for row in rows]
