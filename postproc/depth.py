"""How far the bed is two-dimensional: slices and profiles along its depth (figures 10 and 11 of the paper).

The paper's slices are of one moment; these are of the time mean, which results.nc holds in all three directions.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from postproc.dataset import NotDrawableError, Results, at_height, velocity_scale
from postproc.figures import figure
from postproc.maps import DENSE, PACKED, draw_edge
from postproc.panels import Panel, draw_panels
from postproc.style import COLUMN, GREY, LINES, averaging_text, inset_axes, new_figure

SLICES = (0.2, 0.5, 0.8)  # y/D, Hamidouche et al. 2019, figure 10
DEPTH_HEIGHT = 0.16  # z/H of figure 11
DEPTH_PLACES = (0.1, 0.3, 0.5, 0.7, 0.9)  # x/L; the paper's text does not give its own


@figure
def slices(results: Results) -> Figure:
    """Time-mean solids fraction on slices at y/D = 0.2, 0.5 and 0.8; each shows the cells that it passes through."""
    field = results.mean("solids_fraction")
    rows = [min(int(place * field.sizes["y"]), field.sizes["y"] - 1) for place in SLICES]
    fields = [field.isel(y=row, drop=True) for row in rows]
    panels = [
        Panel(results, cut, f"y/D = {place:g}", partial(draw_edge, results=results, field=cut))
        for place, cut in zip(SLICES, fields, strict=True)
    ]
    label = r"Solids fraction $\langle \alpha_p \rangle$ [–]"
    return draw_panels(panels, results.title, averaging_text(results), label, (0.0, PACKED), mark=DENSE)


def depth_lines(results: Results) -> dict[float, np.ndarray]:
    """Time-mean vertical solids velocity over U_f at z/H = 0.16: x/L -> values along the cells in y, shape (ny,).

    Linear between the cell centres around height and place.
    """
    width, _, height = results.size
    upward = results.particle_mean("solids_velocity").sel(component="z")
    layer: xr.DataArray = at_height(upward, DEPTH_HEIGHT * height) / velocity_scale(results)[0]
    lines = layer.transpose("y", "x").values
    x = results.data["x"].values / width
    return {place: np.array([np.interp(place, x, line) for line in lines]) for place in DEPTH_PLACES}


@figure
def depth_profiles(results: Results) -> Figure:
    """Time-mean vertical solids velocity along the depth at z/H = 0.16, at five places across the bed."""
    lines = depth_lines(results)
    if not any(np.isfinite(line).any() for line in lines.values()):
        raise NotDrawableError([f"no particle ever came to z/H = {DEPTH_HEIGHT:g}."])
    _, divisor, unit = velocity_scale(results)
    note = f"$z/H$ = {DEPTH_HEIGHT:g}; {averaging_text(results)}"
    picture = new_figure(results.title, COLUMN, 2.6, note)
    axes = inset_axes(picture, 0.56, 0.42, COLUMN - 1.5, 2.05)
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    y = results.data["y"].values / results.size[1]
    for (place, line), look in zip(lines.items(), LINES, strict=False):
        axes.plot(y, line, label=f"$x/L$ = {place:g}", markersize=3.5, **look)
    symbol = rf"$\langle U_{{p,z}} \rangle{divisor}$"
    axes.set(xlabel="$y/D$ [–]", ylabel=f"{symbol} [{unit}]", xlim=(0, 1))
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=2.2)
    return picture
