"""Profiles across the bed at some heights (figure 13 of Hamidouche et al. 2019)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fbcouple.postproc.averaging import averaging_text, mark_runs
from fbcouple.postproc.figures.heights import format_height, list_heights
from fbcouple.postproc.figures.maps import common_flux_scale
from fbcouple.postproc.figures.registry import comparison, figure
from fbcouple.postproc.scales import flux_scale, format_scale
from fbcouple.postproc.style import COLUMN, GREY, LINES, PAGE, lay_out, wrap_label
from fbcouple.postproc.symbols import explain
from fbcouple.results.depth_means import at_height, depth_average
from fbcouple.results.reader import Results

SYMBOL = r"\langle \alpha_p \rho_p U_{p,z} \rangle_{xz}"


@dataclass(frozen=True)
class Profile:
    """A line across the bed: `position` x/L, `value` and, if two blocks of the window are full, its `stderr`; (nx,)."""

    position: np.ndarray
    value: np.ndarray
    stderr: np.ndarray | None


def vertical_flux(results: Results, height: float) -> Profile:
    """Time-mean vertical solids flux over rho U_f `height` [m] above the floor, averaged over the depth, against x/L.

    Linear between the centres of the two layers of cells around the height. The standard error is the mean over the
    depth and the same weighted mean over the two layers: an upper bound, reached if these cells err together.
    Without an inlet flow of gas the flux stays in kg m-2 s-1.

    Raises: NotDrawableError without `solids_flux`, or if the height is not between two layers.
    """
    scale, _, _ = flux_scale(results)

    def line(field: xr.DataArray) -> np.ndarray:
        return at_height(depth_average(field.sel(component="z")), results.corner[2] + height).values / scale

    value = line(results.mean("solids_flux"))
    stderr = line(results.error("solids_flux_stderr")) if "solids_flux_stderr" in results.data else None
    known = stderr is not None and bool(np.isfinite(stderr[np.isfinite(value)]).all())
    return Profile(results.share("x"), value, stderr if known else None)


@figure
def flux_profile(results: Results) -> Figure:
    """Vertical solids flux across the bed, a line each height, with bands of one standard error."""
    heights = list_heights(results)
    note = f"{'; '.join(format_height(z, results) for z in heights)}; {averaging_text(results)}"
    note += format_scale([results])
    note += _tell_bare([results], heights)
    note = f"{note}; {_explain(flux_scale(results)[1], note)}"
    picture = lay_out(results.title, COLUMN, 2.6 + 0.14 * len(heights), note)
    axes = picture.subplots()
    handles = []
    for height, style in zip(heights, _cycle_styles(len(heights)), strict=True):
        profile = vertical_flux(results, height)
        name = f"$z$ = {1e3 * height:.3g} mm" if len(heights) > 1 else "time mean"
        net = f"{name} (average over $x$: {_format_mean(profile.value)})"
        handles.append(_draw_profile(axes, profile, net, style))
    band = bool(axes.collections)
    _finish(axes, flux_scale(results)[1:])
    words = f"{'band: ' if len(heights) == 1 else 'bands: '}± 1 standard error" if band else None
    legend = {"handlelength": 1.8, "borderaxespad": 0.0, "title": words, "title_fontsize": "small"}
    axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(-0.02, 1.01), alignment="left", **legend)
    return picture


@comparison
def flux_profiles(runs: Sequence[Results]) -> Figure:
    """Vertical solids flux across the bed of each run at the first run's heights, bands of one standard error."""
    common_flux_scale(runs)
    heights = list_heights(runs[0])
    note = f"bands: ± 1 standard error{_tell_bare(runs, heights)}{format_scale(runs)}{mark_runs(runs)}"
    note = f"{note}; {_explain(flux_scale(runs[0])[1], note)}"
    picture = lay_out("Time-mean vertical solids flux", PAGE, 0.3 + 2.6 * len(heights), note)
    for axes, height in zip(picture.subplots(len(heights), 1, squeeze=False)[:, 0], heights, strict=True):
        for run, style in zip(runs, _cycle_styles(len(runs)), strict=True):
            _draw_profile(axes, vertical_flux(run, height), wrap_label(run.label), style)
        _finish(axes, flux_scale(runs[0])[1:])
        axes.set_title(format_height(height, runs[0]), loc="left", size="small", pad=2.0)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=2.4)
    return picture


def _tell_bare(runs: Sequence[Results], heights: Sequence[float]) -> str:
    """For a note, that there is no band for some runs, as their standard errors are not known; or nothing."""
    bare = [run.label for run in runs if any(vertical_flux(run, height).stderr is None for height in heights)]
    of = f" of {', '.join(bare)}" if len(runs) > 1 else ""
    return f"; standard error{of} not known: no band" if bare else ""


def _explain(divisor: str, known: str) -> str:
    """The letters of the axes and of the heights."""
    return explain(SYMBOL, divisor, "x/L", "z/H", known=known)


def _cycle_styles(count: int) -> list[dict[str, Any]]:
    return [LINES[index % len(LINES)] for index in range(count)]


def _format_mean(values: np.ndarray) -> str:
    """The mean over the places inside of the bed, in two digits, and no power of ten where they can be written out."""
    inside = values[np.isfinite(values)]
    return f"{float(f'{inside.mean():.2g}'):+g}".replace("-", "−") if inside.size else "none"


def _draw_profile(axes: Axes, profile: Profile, label: str, style: dict[str, Any]) -> Line2D:
    """Draw a profile with its band, if it has one."""
    if profile.stderr is not None:
        low, high = profile.value - profile.stderr, profile.value + profile.stderr
        axes.fill_between(profile.position, low, high, color=style["color"], alpha=0.2, linewidth=0)
    (line,) = axes.plot(profile.position, profile.value, markersize=3.0, label=label, **style)
    return line


def _finish(axes: Axes, scale: tuple[str, str]) -> None:
    """Name the axes of a flux over what `scale` (text after its symbol, unit) says."""
    divisor, unit = scale
    axes.axhline(0.0, color=GREY, linewidth=0.7, zorder=0)
    symbol = f"${SYMBOL}{divisor}$"
    axes.set(xlabel="$x/L$ [–]", ylabel=f"Upward solids flux\n{symbol} [{unit}]", xlim=(0, 1))
    axes.margins(y=0.1)
