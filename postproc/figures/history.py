"""What was recorded against time: is the bed steady, does the gas carry it, were the steps within their limits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fbcouple.postproc.averaging import averaging_text
from fbcouple.postproc.figures.maps import DENSE
from fbcouple.postproc.figures.registry import comparison, figure
from fbcouple.postproc.joined_rows import tell_joined
from fbcouple.postproc.style import (
    BLUE,
    GREY,
    LINES,
    PAGE,
    VERMILION,
    WINDOW_SHADE,
    inset_axes,
    lay_out,
    new_figure,
    wrap_label,
)
from fbcouple.results.reader import NotDrawableError, Results

Panel = Callable[[Axes, Results], None]
PANELS: dict[str, Panel] = {}
FAR = 1.5
"""Ranges of 98 of 100 rows beyond which the others do not set the axis."""
OTHER: dict[str, Any] = {"color": GREY, "linestyle": ":", "linewidth": 1.0}
HEAT_FLOWS = {
    "heat_given": "gas to particles",
    "heat_by_contacts": "walls to particles",
    "heat_by_walls": "walls to gas",
    "heat_by_inlets": "in by inlets",
    "heat_by_outlets": "in by outlets",
}


def panel(function: Panel) -> Panel:
    """Register `function(axes, results)`, which draws the history of the variable that it is named after."""
    PANELS[function.__name__] = function
    return function


@figure
def history(results: Results) -> Figure:
    """Bed height, inlet velocity, pressure drop, sub-steps, Courant number, temperatures and heat flows against time;
    the averaging window is shaded."""
    shown = [name for name in PANELS if name in results.data and (name != "substeps" or results.case.get("particles"))]
    if not shown or not results.data.sizes["time"]:
        raise NotDrawableError([f"{results.path} has none of the histories {', '.join(PANELS)}."])
    left, right, bottom, top, each, gap = 0.72, 1.15, 0.42, 0.1, 1.05, 0.14
    window = results.first_window
    shaded = "" if window is None else "shaded: window of the first; " if results.replicas > 1 else "shaded: "
    body = bottom + len(shown) * (each + gap) - gap + top
    dashed = "; dashed: the inlet was changed" if results.inlet_changes else ""
    joined = f"; {words}" if (words := tell_joined(results)) else ""
    picture = new_figure(results.title, PAGE, body, shaded + averaging_text(results) + dashed + joined)
    time = results.data["time"].values
    for row, name in enumerate(reversed(shown)):
        axes = inset_axes(picture, left, bottom + row * (each + gap), PAGE - left - right, each)
        if window is not None:
            axes.axvspan(*window, color=WINDOW_SHADE, linewidth=0, zorder=0)
        for moment in results.inlet_changes:
            axes.axvline(moment, color=GREY, linestyle="--", linewidth=0.8)
        PANELS[name](axes, results)
        axes.set_xlim(0.0, time[-1] if time[-1] > 0.0 else None)
        axes.grid(axis="y", color="white" if window else WINDOW_SHADE, linewidth=0.6)
        axes.set_axisbelow(True)
        axes.yaxis.set_label_coords(-0.37 / (PAGE - left - right), 0.5)
        axes.tick_params(labelbottom=row == 0)
        if row == 0:
            axes.set_xlabel("Time [s]")
    return picture


@comparison
def histories(runs: Sequence[Results]) -> Figure:
    """Bed height and pressure drop of each run against time."""
    signals = {"bed_height": ("Bed height\n[mm]", 1e3), "pressure_drop": ("Pressure drop\n[Pa]", 1.0)}
    runs = [run for run in runs if run.data.sizes.get("time")]
    shown = [name for name in signals if any(name in run.data for run in runs)]
    if not shown:
        raise NotDrawableError([f"none of the runs has any of the histories {', '.join(signals)}."])
    joined = [run.label for run in runs if tell_joined(run)]
    note = f"; each row stands for several of the run: {', '.join(joined)}" if joined else ""
    picture = lay_out("Histories", PAGE, 0.5 + 1.6 * len(shown), f"start-up included{note}")
    panels = picture.subplots(len(shown), 1, squeeze=False, sharex=True)[:, 0]
    longest = max(float(run.data["time"].values[-1]) for run in runs)
    for axes, name in zip(panels, shown, strict=True):
        text, factor = signals[name]
        rows = []
        for index, run in enumerate(runs):
            if name in run.data:
                look = {key: LINES[index % len(LINES)][key] for key in ("color", "linestyle")}
                rows.append((run.data["time"].values, factor * run.history(name).values))
                axes.plot(*rows[-1], linewidth=0.9, label=wrap_label(run.label), **look)
        keep_in_view(axes, *np.concatenate(rows, axis=1))
        axes.set(ylabel=text, xlim=(0.0, longest if longest > 0.0 else None))
    picture.align_ylabels(panels)
    panels[-1].set_xlabel("Time [s]")
    panels[0].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=2.4)
    return picture


@panel
def bed_height(axes: Axes, results: Results) -> None:
    """Height of the bed [mm], beside twice that of the centre of mass, which does not jump when a layer thins out."""
    _line(axes, results, "bed_height", factor=1e3, label=f"top layer denser\nthan {DENSE:g}")
    axes.set_ylabel("Bed height\n[mm]")
    if "solids_centre_z" in results.data:
        _line(axes, results, "solids_centre_z", factor=2e3, label="twice the height\nof the centre\nof mass", **OTHER)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=1.0, borderaxespad=0.3)


@panel
def inlet_velocity(axes: Axes, results: Results) -> None:
    """Superficial velocity of the gas that comes in [m/s], where it changes."""
    axes.plot(*_after_a_step(results, "inlet_velocity"), color=BLUE, linewidth=0.8)
    axes.set_ylabel("Superficial\nvelocity [m s$^{-1}$]")


@panel
def pressure_drop(axes: Axes, results: Results) -> None:
    """Pressure drop of the gas [Pa] beside the weight of the bed less its buoyancy over its cross-section."""
    _line(axes, results, "pressure_drop")
    axes.set_ylabel("Pressure drop\n[Pa]")
    keep_in_view(axes, results.data["time"].values, results.history("pressure_drop").values)
    weight = results.weight_history
    if weight is not None and len(weight) > 1:
        label = "weight less\nbuoyancy over\ncross-section"
        look: dict[str, Any] = {"color": VERMILION, "linestyle": "--", "linewidth": 1.0, "label": label}
        axes.plot(results.data["time"].values, weight, **look)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=1.4)
    elif weight is not None:
        _limit(axes, float(weight[0]), f"weight − buoyancy\nover cross-section\n{weight[0]:.1f} Pa")


@panel
def substeps(axes: Axes, results: Results) -> None:
    """DEM steps in one fluid step."""
    time, steps = _after_a_step(results, "substeps")
    axes.step(time, steps, where="post", color=BLUE, linewidth=0.8)
    axes.yaxis.set_major_locator(MaxNLocator(4, integer=True))
    if steps.size and not np.ptp(steps):
        axes.set_ylim(steps[0] - 1.0, steps[0] + 1.0)
    axes.set_ylabel("DEM steps\nper fluid step")


@panel
def max_courant(axes: Axes, results: Results) -> None:
    """Largest Courant number of the gas beside its limit."""
    axes.plot(*_after_a_step(results, "max_courant"), color=BLUE, linewidth=0.8)
    axes.set_ylabel("Largest Courant\nnumber [–]")
    limit = results.case.get("gas", {}).get("max_courant")
    if limit is not None:
        _limit(axes, limit, f"limit {limit:g}")
    axes.set_ylim(0.0, 1.15 * max(limit or 0.0, float(results.history("max_courant").max())))


@panel
def mean_particle_temperature(axes: Axes, results: Results) -> None:
    """Mean temperature of the particles [K], beside that of the gas where there is one."""
    _line(axes, results, "mean_particle_temperature", label="particles")
    axes.set_ylabel("Mean temperature\n[K]")
    if "mean_gas_temperature" in results.data:
        _line(axes, results, "mean_gas_temperature", label="gas", **OTHER)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=1.0, borderaxespad=0.3)


@panel
def heat_given(axes: Axes, results: Results) -> None:
    """Heat that comes to gas and particles [W], each way that any takes, as the mean since the row before; by inlets
    and outlets it counts from heat.gas_temperature."""
    flows = {name: _after_a_step(results, name) for name in HEAT_FLOWS if name in results.data}
    shown = [name for name, (_, heat) in flows.items() if np.any(heat)] or ["heat_given"]
    for index, name in enumerate(shown):
        look = {key: LINES[index][key] for key in ("color", "linestyle")}
        axes.plot(*flows[name], linewidth=0.8, label=HEAT_FLOWS[name], **look)
    keep_in_view(axes, *np.concatenate([flows[name] for name in shown], axis=1))
    axes.set_ylabel("Heat\n[W]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=1.8, borderaxespad=0.3)


def _line(axes: Axes, results: Results, name: str, factor: float = 1.0, **look: Any) -> None:
    drawn: Any = {"color": BLUE, "linewidth": 0.8} | look
    axes.plot(results.data["time"], factor * results.history(name), **drawn)


def _after_a_step(results: Results, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Times and values without the row of the start, where no step has been taken that it could tell of."""
    history = results.history(name)
    taken = slice(1 if history["time"].values[0] == 0.0 else 0, None)
    return history["time"].values[taken], history.values[taken]


def keep_in_view(axes: Axes, time: np.ndarray, values: np.ndarray) -> None:
    """Bound the axis by what 98 of 100 rows have where others are far off, and tell of those: a jet that starts takes
    thousands of Pa in its first step, and the bed would be a flat line."""
    time, values = time[np.isfinite(values)], values[np.isfinite(values)]
    low, high = np.percentile(values, (1.0, 99.0))
    room = FAR * (high - low)
    if not room or (values.min() >= low - room and values.max() <= high + room):
        return
    low, high = low - 0.2 * (high - low), high + 0.2 * (high - low)
    beyond = np.flatnonzero((values < low) | (values > high))
    worst = beyond[np.argmax(np.abs(values[beyond]))]
    axes.set_ylim(low, high)
    text = f"{len(beyond)} row{'s' * (len(beyond) > 1)} beyond, farthest {values[worst]:.3g} at {time[worst]:.3g} s"
    axes.annotate(text, (0.99, 0.04), xycoords="axes fraction", ha="right", size="small", color=VERMILION)


def _limit(axes: Axes, value: float, label: str) -> None:
    axes.axhline(value, color=VERMILION, linestyle="--", linewidth=1.0)
    axes.annotate(
        label,
        (1.0, value),
        xycoords=("axes fraction", "data"),
        xytext=(4, 0),
        textcoords="offset points",
        va="center",
        size="small",
        color=VERMILION,
        annotation_clip=False,
    )
