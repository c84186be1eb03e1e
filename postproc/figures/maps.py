"""Maps of the depth-averaged time means in the x-z plane, of one run or of several in a row with one colour scale.

Figures 12, 14, 16, 17, 19, 21 and A1 of Hamidouche et al. 2019.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fbcouple.postproc.averaging import averaging_text, format_window, list_marks
from fbcouple.postproc.figures.arrows import sample_arrows
from fbcouple.postproc.figures.heights import SCARCE
from fbcouple.postproc.figures.layout import Line, Panel, draw_panels
from fbcouple.postproc.figures.registry import comparison, figure
from fbcouple.postproc.scales import flux_scale, format_scale, velocity_scale
from fbcouple.postproc.style import DPI
from fbcouple.results.depth_means import depth_average, mass_average
from fbcouple.results.reader import NotDrawableError, Results

PACKED = 0.6  # upper colour limit of every map of the solids fraction, so that runs can be compared
DENSE = 0.2  # solids fraction over which the paper calls the bed dense
EDGE_LINE = Line("--", f"edge of the dense bed, {DENSE:g}")
ARROWS_ACROSS = 11
LONGEST_ARROW = 1.1  # of the distance between arrows
HARDLY_ANY = 1e-3
"""Solids fraction below which agitation is not shown: that of a few particles which pass says nothing."""
SHORTEST_ARROW = 0.04  # of the longest; below this only the colour is shown


@figure
def solids_fraction(results: Results) -> Figure:
    """Map of the depth-averaged time-mean solids fraction, with the edge of the dense bed as a line."""
    return _row_of_fractions([results], results.title)


@comparison
def solids_fractions(runs: Sequence[Results]) -> Figure:
    """Depth-averaged time-mean solids fraction of each run; the dashed line is the edge of the dense bed."""
    return _row_of_fractions(runs, "Time-mean solids fraction")


def _row_of_fractions(runs: Sequence[Results], heading: str) -> Figure:
    panels = []
    for run in runs:
        field = depth_average(run.mean("solids_fraction"))
        panels.append(Panel(run, field, _window(run, runs), partial(draw_edge, results=run, field=field)))
    label = r"Solids fraction $\langle \alpha_p \rangle_{xz}$ [–]"
    return draw_panels(panels, heading, _note(runs), label, (0.0, PACKED), DENSE, EDGE_LINE)


@figure
def solids_flux(results: Results) -> Figure:
    """Map of the depth-averaged time-mean solids flux: magnitude of its (x, z) part as colour, direction as arrows."""
    return _row_of_fluxes([results], results.title)


@comparison
def solids_fluxes(runs: Sequence[Results], among: Sequence[Results] = ()) -> Figure:
    """Depth-averaged time-mean solids flux of each run: magnitude of its (x, z) part as colour, direction as arrows.

    among: further runs, which the scale holds, too.
    """
    return _row_of_fluxes(runs, "Time-mean solids flux", among)


def _row_of_fluxes(runs: Sequence[Results], heading: str, among: Sequence[Results] = ()) -> Figure:
    divisor, unit = common_flux_scale([*runs, *among])
    fluxes = [depth_average(run.mean("solids_flux")) / flux_scale(run)[0] for run in runs]
    magnitudes = [_find_magnitude(flux) for flux in fluxes]
    others = [_find_magnitude(depth_average(run.mean("solids_flux")) / flux_scale(run)[0]) for run in among]
    largest = max(float(magnitude.max()) for magnitude in [*magnitudes, *others])
    if largest == 0.0:
        raise NotDrawableError(["`solids_flux` is zero everywhere."])
    panels = [
        Panel(run, magnitude, _window(run, runs), partial(_arrows, results=run, flux=flux, largest=largest))
        for run, magnitude, flux in zip(runs, magnitudes, fluxes, strict=True)
    ]
    symbol = rf"$|\langle \alpha_p \rho_p \mathbf{{U}}_p \rangle_{{xz}}|{divisor}$"
    return draw_panels(
        panels, heading, _note(runs) + format_scale(runs), f"Solids flux {symbol} [{unit}]", (0.0, largest)
    )


def _find_magnitude(flux: xr.DataArray) -> xr.DataArray:
    """Of the (x, z) part."""
    return (flux.sel(component="x") ** 2 + flux.sel(component="z") ** 2) ** 0.5


@figure
def agitation(results: Results) -> Figure:
    """Map of the time-mean particle agitation about the time mean; grey where there are hardly any particles."""
    return _row_of_agitation([results], results.title)


@comparison
def agitations(runs: Sequence[Results], among: Sequence[Results] = ()) -> Figure:
    """Time-mean particle agitation of each run about its time mean; grey where there are hardly any particles.

    among: further runs, which the scale holds, too.
    """
    return _row_of_agitation(runs, "Particle agitation", among)


def _row_of_agitation(runs: Sequence[Results], heading: str, among: Sequence[Results] = ()) -> Figure:
    """Mean square of the particle velocity about the time mean over U_f^2, mass weighted over the depth.

    The scale ends at the largest value where the solids fraction is above `SCARCE`: above the bed a few particles give
    a number without significance (Hamidouche et al. 2019, section 4.2), and below `HARDLY_ANY` it is not shown.
    """
    scales = [velocity_scale(run) for run in [*runs, *among]]
    if len({unit for _, _, unit in scales}) > 1:
        raise NotDrawableError(["some runs have an inlet velocity and others have none: no common scale."])
    fields, tops = [], []
    for run, (scale, _, _) in zip([*runs, *among], scales, strict=True):
        field = mass_average(run, "agitation") / scale**2
        solids = depth_average(run.mean("solids_fraction"))
        fields.append(field.where(solids >= HARDLY_ANY))
        tops.append(float(field.where(solids > SCARCE).max()))
    if not max(tops) > 0.0:
        raise NotDrawableError(["`agitation` is zero everywhere."])
    panels = [Panel(run, field, _window(run, runs), None) for run, field in zip(runs, fields[: len(runs)], strict=True)]
    label = "Agitation $q_p^2$ [m$^2$ s$^{-2}$]" if scales[0][1] == "" else "Agitation $q_p^2 / U_f^2$ [–]"
    empty = f"hardly any particles, solids fraction below {HARDLY_ANY:g}"
    return draw_panels(panels, heading, _note(runs) + format_scale(runs), label, (0.0, max(tops)), empty=empty)


def common_flux_scale(runs: Sequence[Results]) -> tuple[str, str]:
    """What to append to the symbol of a flux, and its unit; the same for all runs, or NotDrawableError."""
    scales = {flux_scale(run)[1:] for run in runs}
    if len(scales) > 1:
        raise NotDrawableError(["some runs have an inlet flow of gas and others have none: no common flux scale."])
    return scales.pop()


def _note(runs: Sequence[Results]) -> str:
    texts = {averaging_text(run) for run in runs}
    return texts.pop() if len(texts) == 1 else "time means; the averaging window stands above each map"


def _window(run: Results, runs: Sequence[Results]) -> str:
    """What stands above a map: nothing for one run, else its label; where they differ, window and marks, too."""
    if len(runs) == 1:
        return ""
    if len({averaging_text(other) for other in runs}) == 1 or run.window is None:
        return run.label
    return "\n".join([run.label, format_window(run), *(mark.brief for mark in list_marks(run))])


def draw_edge(axes: Axes, results: Results, field: xr.DataArray) -> None:
    """Line where the solids fraction is that of the edge of the dense bed."""
    if np.min(field) < DENSE < np.max(field) and min(field.shape) > 1:
        axes.contour(
            results.share("x"),
            results.share("z"),
            field.transpose("z", "x").values,
            levels=[DENSE],
            colors="black",
            linewidths=0.8,
            linestyles="--",
        )


def _arrows(axes: Axes, results: Results, flux: xr.DataArray, largest: float) -> None:
    """Arrows of true direction, as long as the flux is strong, in black or white against the colour behind them.

    The `largest` flux of the row has the longest arrow.
    """
    width, _, height = results.size
    sideways, upward = (flux.sel(component=axis).transpose("z", "x").values for axis in ("x", "z"))
    x, z, across, up = sample_arrows(sideways, upward, (width, height), ARROWS_ACROSS)
    strength = np.hypot(across, up)
    shown = strength > SHORTEST_ARROW * largest
    inches = axes.get_window_extent().width / DPI
    axes.quiver(
        x[shown],
        z[shown],
        across[shown],
        up[shown],
        color=["white" if value > 0.55 * largest else "black" for value in strength[shown]],
        angles="uv",
        scale_units="x",
        scale=largest * x.shape[1] / LONGEST_ARROW,
        units="inches",
        width=min(0.011, 0.0085 * inches),
        headwidth=4.0,
        headlength=4.5,
        headaxislength=4.0,
        minlength=0,
        pivot="mid",
    )
