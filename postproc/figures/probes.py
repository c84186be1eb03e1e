"""Fields at points and on lines against time, as the probes of the case took them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fbcouple.postproc.figures.history import keep_in_view
from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.sections import list_sections
from fbcouple.postproc.style import BLUE, LINES, PAGE, inset_axes, new_figure, wrap_label
from fbcouple.results.probes import VECTORS, Probed, read_probes
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results

LABELS = {
    "pressure": "Pressure\n[Pa]",
    "voidage": "Voidage\n[–]",
    "gas_velocity": "Upward gas\nvelocity [m s$^{-1}$]",
    "gas_flux": "Upward superficial\nvelocity [m s$^{-1}$]",
    "solids_fraction": "Solids fraction\n[–]",
    "solids_velocity": "Upward solids\nvelocity [m s$^{-1}$]",
    "solids_flux": "Upward solids flux\n[kg m$^{-2}$ s$^{-1}$]",
    "granular_temperature": "Granular temp.\n[m$^2$ s$^{-2}$]",
    "gas_temperature": "Gas temp.\n[K]",
    "solids_temperature": "Solids temp.\n[K]",
}
"""Of a vector its upward component is drawn."""
MOST_LINES = len(LINES)
"""Points that are drawn as lines; more of them, and those of a line, are a map over time."""
MOST_COLUMNS = 600
"""Columns of a map; where there are more samples each is a mean of several."""
_LEFT, _BOTTOM, _EACH, _GAP = 0.85, 0.42, 1.15, 0.42


@figure
def probes(results: Results) -> Figure:
    """Each quantity of each set of probes: of points against time, of a line over time, with its mean along the line.

    Of a velocity or a flux it is the upward component. The voidage of a section is in the figure `sections`.
    """
    if not (results.case.get("output") or {}).get("probes"):
        raise NotMeantError([f"the case of {results.path} has no probes (output.probes)."])
    sets = [found for found in read_probes(results.data, results.case) if found.times.size]
    if not sets:
        raise NotDrawableError([f"{results.path} has no sample of its probes yet."])
    cut = list_sections(results)
    rows = [(found, name) for found in sets for name in found.values if name != "voidage" or found.name not in cut]
    if not rows:
        raise NotMeantError([f"{results.path} has sections of the voidage alone; they are in `sections`."])
    picture = new_figure(results.title, PAGE, _BOTTOM + len(rows) * (_EACH + _GAP), _describe(sets))
    for row, (found, quantity) in enumerate(reversed(rows)):
        bottom = _BOTTOM + row * (_EACH + _GAP)
        draw = _draw_map if is_map(found) else _draw_series
        axes = draw(picture, bottom, found, quantity)
        axes.set_title(f"{found.name}: {quantity.replace('_', ' ')}", loc="left", size="small", pad=2.0)
        if row == 0:
            axes.set_xlabel("Time [s]", labelpad=1.0)
    return picture


def is_map(found: Probed) -> bool:
    """Is the set drawn as a map over time?"""
    return found.is_line or len(found.points) > MOST_LINES


def _describe(sets: list[Probed]) -> str:
    thinned = [found.name for found in sets if is_map(found) and len(found.times) > MOST_COLUMNS]
    means = f"; maps of {', '.join(thinned)}: means over {MOST_COLUMNS} equal numbers of samples" if thinned else ""
    has_means = "right: mean over all samples" if any(map(is_map, sets)) else ""
    return f"as sampled{'; ' * bool(has_means)}{has_means}{means}"


def _pick(found: Probed, quantity: str) -> np.ndarray:
    """Values (t, n): of a vector those of its upward component."""
    values = found.values[quantity]
    return values[..., 2] if quantity in VECTORS else values


def _draw_series(picture: Figure, bottom: float, found: Probed, quantity: str) -> Axes:
    axes = inset_axes(picture, _LEFT, bottom, PAGE - _LEFT - 1.75, _EACH)
    values = _pick(found, quantity)
    for index, series in enumerate(values.T):
        x, y, z = (1e3 * found.points[index]).tolist()
        look: dict[str, Any] = {key: LINES[index][key] for key in ("color", "linestyle")}
        axes.plot(found.times, series, linewidth=0.8, label=f"{x:.4g}, {y:.4g}, {z:.4g}", **look)
    if np.isfinite(values).any():
        keep_in_view(axes, np.repeat(found.times, values.shape[1]), values.ravel())
    axes.set_ylabel(LABELS[quantity])
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), title="x, y, z [mm]", title_fontsize="small")
    axes.margins(x=0.0)
    return axes


def _draw_map(picture: Figure, bottom: float, found: Probed, quantity: str) -> Axes:
    width, bar, mean = 3.75, 0.09, 0.95
    axes = inset_axes(picture, _LEFT, bottom, width, _EACH)
    times, values = thin(found.times, _pick(found, quantity), MOST_COLUMNS)
    along, label = _measure(found)
    image = axes.pcolormesh(times, along, values.T, cmap="viridis", shading="nearest", rasterized=True)
    scale = inset_axes(picture, _LEFT + width + 0.08, bottom, bar, _EACH)
    picture.colorbar(image, cax=scale).set_label(LABELS[quantity], size="small")
    axes.set_ylabel(label)
    beside = inset_axes(picture, PAGE - mean - 0.12, bottom, mean, _EACH)
    _, whole = thin(found.times, _pick(found, quantity), 1)
    beside.plot(whole[0], along, color=BLUE, linewidth=1.0)
    beside.set_ylim(axes.get_ylim())
    beside.xaxis.set_major_locator(MaxNLocator(2))
    beside.tick_params(labelleft=False)
    return axes


def _measure(found: Probed) -> tuple[np.ndarray, str]:
    """Where the points are along the line, and in what: the coordinate that alone changes, or the distance from the
    first; of points that are on no line their numbers."""
    if not found.is_line:
        return np.arange(1, len(found.points) + 1), "Point"
    (moving,) = np.nonzero(np.ptp(found.points, axis=0))
    if len(moving) == 1:
        return 1e3 * found.points[:, moving[0]], f"{'xyz'[moving[0]]} [mm]"
    return 1e3 * found.distances, wrap_label("Distance from the first point [mm]", 16)


def thin(times: np.ndarray, values: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """At most so many rows of `times` (t,) and `values` (t, n), each the mean of neighbours; nan counts for nothing."""
    size = -(-len(times) // most)
    starts = np.arange(0, len(times), size)
    known = np.isfinite(values)
    sums = np.add.reduceat(np.where(known, values, 0.0), starts)
    counts = np.add.reduceat(known.astype(float), starts)
    lengths = np.diff([*starts, len(times)])
    with np.errstate(invalid="ignore"):
        return np.add.reduceat(times, starts) / lengths, sums / counts
