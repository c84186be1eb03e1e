"""How far the bed is two-dimensional: slices and profiles along its depth (figures 10 and 11 of the paper).

The paper's slices are of one moment, which a frame holds; the time mean stands in results.nc in all three directions.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from fbcouple.postproc.averaging import averaging_text
from fbcouple.postproc.figures.heights import format_height, list_heights
from fbcouple.postproc.figures.layout import Panel, draw_panels
from fbcouple.postproc.figures.maps import DENSE, EDGE_LINE, PACKED, draw_edge
from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.scales import format_scale, velocity_scale
from fbcouple.postproc.style import COLUMN, GREY, LINES, lay_out
from fbcouple.postproc.symbols import explain
from fbcouple.postproc.views.frames import list_frames, number_of, read_frame
from fbcouple.results.depth_means import at_height
from fbcouple.results.reader import NotDrawableError, Results

SLICES = (0.2, 0.5, 0.8)  # y/D, Hamidouche et al. 2019, figure 10
MOMENT = 12_000.0  # t U_f/d_p of figure 10
DEPTH_PLACES = (0.1, 0.3, 0.5, 0.7, 0.9)  # x/L; the paper's text does not give its own


@figure
def slices(results: Results) -> Figure:
    """Time-mean solids fraction on slices at y/D = 0.2, 0.5 and 0.8; each shows the cells that it passes through."""
    _require_depth(results)
    cuts = _cut(results.mean("solids_fraction"))
    panels = [Panel(results, cut, name, partial(draw_edge, results=results, field=cut)) for name, cut in cuts]
    label = r"Solids fraction $\langle \alpha_p \rangle$ [–]"
    return draw_panels(panels, results.title, averaging_text(results), label, (0.0, PACKED), DENSE, EDGE_LINE)


@figure
def moment_slices(results: Results) -> Figure:
    """Solids fraction of one moment on slices at y/D = 0.2, 0.5 and 0.8: that of t U_f/d_p = 12 000, or the last."""
    time, cuts = cut_moment(results)
    panels = [Panel(results, cut, name, None) for name, cut in cuts]
    label = r"Solids fraction $\alpha_p$ [–]"
    return draw_panels(panels, results.title, f"t = {time:.3f} s", label, (0.0, PACKED))


def cut_moment(results: Results) -> tuple[float, list[tuple[str, xr.DataArray]]]:
    """Time [s] of that moment, and the solids fraction (z, x) on each of `SLICES` with its name."""
    frame = read_frame(_choose_moment(results, list_frames(results)))
    if frame.voidage is None:
        raise NotDrawableError([f"the frames of {results.path.parent} have no voidage: the case has no gas."])
    axes = {axis: results.data[axis].values for axis in "zyx"}
    return float(frame.time), _cut(xr.DataArray(1.0 - frame.voidage.astype(float), dims=tuple("zyx"), coords=axes))


def _require_depth(results: Results) -> None:
    """Raise NotDrawableError of a reduced pool."""
    if results.data.attrs.get("reduced"):
        raise NotDrawableError([f"{results.path} has depth averages alone (a reduced pool)."])


def _choose_moment(results: Results, paths: list[Path]) -> Path:
    """The frame of t U_f/d_p = 12 000, or the last before it; without gas that flows in the last."""
    every = results.case.get("output", {}).get("particles_every")
    if results.inlet_speed is None or every is None or "particles" not in results.case:
        return paths[-1]
    last = round(MOMENT * results.case["particles"]["diameter"] / results.inlet_speed / every)
    return max((path for path in paths if number_of(path) <= last), default=paths[0])


def _cut(field: xr.DataArray) -> list[tuple[str, xr.DataArray]]:
    """The cells that each of `SLICES` passes through, with their names."""
    rows = [min(int(position * field.sizes["y"]), field.sizes["y"] - 1) for position in SLICES]
    return [(f"y/D = {position:g}", field.isel(y=row, drop=True)) for position, row in zip(SLICES, rows, strict=True)]


def depth_lines(results: Results) -> dict[float, np.ndarray]:
    """Time-mean vertical solids velocity over U_f at the highest of the heights of profiles: x/L -> values along the
    cells in y, shape (ny,).

    Linear between the cell centres around height and place. Places beside the outermost centres, and those where no
    particle ever came, are left out.
    """
    _require_depth(results)
    upward = results.particle_mean("solids_velocity").sel(component="z")
    layer: xr.DataArray = at_height(upward, results.corner[2] + max(list_heights(results))) / velocity_scale(results)[0]
    lines = layer.transpose("y", "x").values
    x = results.share("x")
    known = [position for position in DEPTH_PLACES if x[0] <= position <= x[-1]]
    along = {position: np.array([np.interp(position, x, line) for line in lines]) for position in known}
    return {position: line for position, line in along.items() if np.isfinite(line).any()}


@figure
def depth_profiles(results: Results) -> Figure:
    """Time-mean vertical solids velocity along the depth at one height, at five places across the bed."""
    height = format_height(max(list_heights(results)), results)
    lines = depth_lines(results)
    if not lines:
        raise NotDrawableError([f"no particle ever came to {height}."])
    _, divisor, unit = velocity_scale(results)
    symbol = rf"$\langle U_{{p,z}} \rangle{divisor}$"
    note = f"{height}; {averaging_text(results)}{format_scale([results])}"
    note = f"{note}; {explain(symbol, 'x/L', 'y/D', 'z/H', known=note)}"
    picture = lay_out(results.title, COLUMN, 2.6, note)
    axes = picture.subplots()
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    y = results.share("y")
    for (position, line), look in zip(lines.items(), LINES, strict=False):
        axes.plot(y, line, label=f"$x/L$ = {position:g}", markersize=3.5, **look)
    axes.set(xlabel="$y/D$ [–]", ylabel=f"Upward solids velocity\n{symbol} [{unit}]", xlim=(0, 1))
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=2.2)
    return picture
