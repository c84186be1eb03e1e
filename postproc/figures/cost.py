"""Where the wall time went."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.patches import Patch

from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.style import BLUE, COLUMN, ORANGE, inset_axes, new_figure
from fbcouple.results.reader import NotDrawableError, Results

SOLVERS = ("dem", "cfd")  # time inside the solvers' own steps; every other stage is the coupling


def stage_seconds(results: Results) -> dict[str, float]:
    """Wall seconds of each stage over the whole run, the slowest rank's, largest first."""
    total = results.history("wall_seconds").sum("time")
    seconds = {str(stage): float(value) for stage, value in zip(total["stage"].values, total.values, strict=True)}
    return dict(sorted(seconds.items(), key=lambda item: -item[1]))


@figure
def cost(results: Results) -> Figure:
    """Wall time by stage as bars: the solvers in one colour, the coupling in another."""
    seconds = stage_seconds(results)
    total = sum(seconds.values())
    if total <= 0.0:
        raise NotDrawableError([f"`wall_seconds` in {results.path} adds up to {total:g} s."])
    unit, length = _time_unit(max(seconds.values()))
    stages = list(seconds)
    bars = [value / length for value in seconds.values()]
    picture = new_figure(results.title, COLUMN, 0.5 + 0.22 * len(stages), _sum_text(results, total))
    axes = inset_axes(picture, 0.62, 0.42, COLUMN - 0.72, 0.22 * len(stages))
    axes.barh(stages, bars, height=0.68, color=[BLUE if stage in SOLVERS else ORANGE for stage in stages])
    for row, (bar, value) in enumerate(zip(bars, seconds.values(), strict=True)):
        text = f"{100.0 * value / total:.1f} % ({_duration(value)})"
        axes.annotate(text, (bar, row), (3, 0), textcoords="offset points", va="center", size="small")
    axes.invert_yaxis()
    axes.set(xlabel=f"Wall time of the slowest rank [{unit}]", xlim=(0.0, 1.42 * max(bars)))
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.legend([Patch(color=BLUE), Patch(color=ORANGE)], ["solvers", "coupling"], loc="lower right", handlelength=1.0)
    return picture


def _sum_text(results: Results, total: float) -> str:
    text = f"sum of stages {_duration(total)}"
    if "core_seconds" in results.data.attrs:
        text += f"; {float(results.data.attrs['core_seconds']) / 3600:.3g} core hours"
    return text if results.complete else f"{text}; run not complete"


def _duration(seconds: float) -> str:
    unit, length = _time_unit(seconds)
    return f"{seconds / length:.3g} {unit}"


def _time_unit(seconds: float) -> tuple[str, float]:
    """Unit in which a time reads well, and its length in seconds."""
    if seconds < 300.0:
        return "s", 1.0
    return ("min", 60.0) if seconds < 7200.0 else ("h", 3600.0)
