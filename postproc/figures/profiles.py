"""Profiles across the bed at one height (figure 13 of Hamidouche et al. 2019)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from fbcouple.postproc.figures.maps import common_flux_scale
from fbcouple.postproc.figures.registry import comparison, figure
from fbcouple.postproc.scales import flux_scale, word_scale
from fbcouple.postproc.style import BLUE, COLUMN, GREY, LINES, PAGE, averaging_text, inset_axes, new_figure
from fbcouple.results.reader import Results, at_height, depth_average

PROFILE_HEIGHT = 0.092  # z/H of the measured profiles, Hamidouche et al. 2019, section 4.1


@dataclass(frozen=True)
class Profile:
    """A line across the bed: `position` x/L, `value` and, if two blocks of the window are full, its `stderr`; (nx,)."""

    position: np.ndarray
    value: np.ndarray
    stderr: np.ndarray | None


def vertical_flux(results: Results, height: float = PROFILE_HEIGHT) -> Profile:
    """Time-mean vertical solids flux over rho U_f at z/H = `height`, averaged over the depth, against x/L.

    Linear between the centres of the two layers of cells around the height. The standard error is the mean over the
    depth and the same weighted mean over the two layers: an upper bound, reached if these cells err together.
    Without an inlet flow of gas the flux stays in kg m-2 s-1.

    Raises: NotDrawableError without `solids_flux`, or if the height is not between two layers.
    """
    scale, _, _ = flux_scale(results)

    def line(field: xr.DataArray) -> np.ndarray:
        return at_height(depth_average(field.sel(component="z")), results.level(height)).values / scale

    value = line(results.mean("solids_flux"))
    stderr = line(results.error("solids_flux_stderr")) if "solids_flux_stderr" in results.data else None
    known = stderr is not None and bool(np.isfinite(stderr).all())
    return Profile(results.share("x"), value, stderr if known else None)


@figure
def flux_profile(results: Results) -> Figure:
    """Vertical solids flux across the bed at z/H = 0.092 with a band of one standard error."""
    profile = vertical_flux(results)
    _, divisor, unit = flux_scale(results)
    note = f"$z/H$ = {PROFILE_HEIGHT:g}; {averaging_text(results)}{word_scale([results])}"
    picture = new_figure(results.title, COLUMN, 2.8, note)
    axes = inset_axes(picture, 0.56, 0.42, COLUMN - 0.66, 1.95)
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    if profile.stderr is not None:
        low, high = profile.value - profile.stderr, profile.value + profile.stderr
        axes.fill_between(profile.position, low, high, color=BLUE, alpha=0.25, linewidth=0, label="± 1 standard error")
    net = f"time mean (average over $x$: {np.mean(profile.value):+.2g})".replace("-", "−")
    axes.plot(profile.position, profile.value, color=BLUE, marker="o", markersize=2.5, label=net)
    symbol = rf"$\langle \alpha_p \rho_p U_{{p,z}} \rangle_{{xz}}{divisor}$"
    axes.set(xlabel="$x/L$ [–]", ylabel=f"{symbol} [{unit}]", xlim=(0, 1))
    axes.margins(y=0.1)
    axes.legend(loc="lower left", bbox_to_anchor=(-0.02, 0.99), handlelength=1.6, borderaxespad=0.0)
    return picture


@comparison
def flux_profiles(runs: Sequence[Results]) -> Figure:
    """Vertical solids flux across the bed at z/H = 0.092 of each run, with bands of one standard error."""
    divisor, unit = common_flux_scale(runs)
    note = f"$z/H$ = {PROFILE_HEIGHT:g}; bands: ± 1 standard error{word_scale(runs)}"
    picture = new_figure("Time-mean vertical solids flux", PAGE, 3.0, note)
    axes = inset_axes(picture, 0.56, 0.42, PAGE - 2.6, 2.45)
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    for place, run in enumerate(runs):
        look, profile = LINES[place % len(LINES)], vertical_flux(run)
        if profile.stderr is not None:
            low, high = profile.value - profile.stderr, profile.value + profile.stderr
            axes.fill_between(profile.position, low, high, color=look["color"], alpha=0.18, linewidth=0)
        axes.plot(profile.position, profile.value, markersize=3.0, label=run.label, **look)
    symbol = rf"$\langle \alpha_p \rho_p U_{{p,z}} \rangle_{{xz}}{divisor}$"
    axes.set(xlabel="$x/L$ [–]", ylabel=f"{symbol} [{unit}]", xlim=(0, 1))
    axes.margins(y=0.1)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=2.4)
    return picture
