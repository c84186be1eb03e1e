"""Maps of the depth-averaged time means in the x-z plane (figure 12 of Hamidouche et al. 2019)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Colormap
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from postproc.dataset import NotDrawableError, Results, cell_edges, depth_average, flux_scale
from postproc.figures import figure
from postproc.style import SKY, averaging_text, colours, extend, inset_axes, new_figure

PACKED = 0.6  # upper colour limit of every map of the solids fraction, so that runs can be compared
DENSE = 0.2  # solids fraction over which the paper calls the bed dense
ARROWS_ACROSS = 11
LONGEST_ARROW = 1.1  # of the distance between arrows
SHORTEST_ARROW = 0.04  # of the longest; below this only the colour is shown


@figure
def solids_fraction(results: Results) -> Figure:
    """Map of the depth-averaged time-mean solids fraction, with the edge of the dense bed as a line."""
    field = depth_average(results.mean("solids_fraction"))
    picture, axes, bar = _frame(results)
    limits = (0.0, PACKED)
    mesh = _paint(axes, results, field, colours("magma_r", over=SKY), limits)
    _colour_bar(picture, bar, mesh, limits, r"Solids fraction $\langle \alpha_p \rangle_{xz}$ [–]")
    if np.min(field) < DENSE < np.max(field) and min(field.shape) > 1:
        x, z = _dimensionless(results, field)
        axes.contour(x, z, field.values, levels=[DENSE], colors="black", linewidths=0.8, linestyles="--")
        bar.axhline(DENSE, color="black", linewidth=0.8, linestyle="--")
    return picture


@figure
def solids_flux(results: Results) -> Figure:
    """Map of the depth-averaged time-mean solids flux: magnitude of its (x, z) part as colour, direction as arrows."""
    scale, divisor, unit = flux_scale(results)
    flux = depth_average(results.mean("solids_flux")) / scale
    magnitude = (flux.sel(component="x") ** 2 + flux.sel(component="z") ** 2) ** 0.5
    largest = float(magnitude.max())
    if largest == 0.0:
        raise NotDrawableError(["`solids_flux` is zero everywhere."])
    picture, axes, bar = _frame(results)
    mesh = _paint(axes, results, magnitude, colours("magma_r", over=SKY), (0.0, largest))
    symbol = rf"$|\langle \alpha_p \rho_p \mathbf{{U}}_p \rangle_{{xz}}|{divisor}$"
    _colour_bar(picture, bar, mesh, (0.0, largest), f"Solids flux {symbol} [{unit}]")
    _arrows(axes, results, flux)
    return picture


def _frame(results: Results) -> tuple[Figure, Axes, Axes]:
    """Figure, axes with the true proportions of the bed, and axes of the colour bar."""
    width, _, height = results.size
    across = min(3.0, 5.2 * width / height)
    up = across * height / width
    left, bottom, gap, bar_width, right, top = 0.52, 0.42, 0.12, 0.13, 0.62, 0.12
    full = max(left + across + gap + bar_width + right, 2.6)
    picture = new_figure(results, full, bottom + up + top, averaging_text(results))
    axes = inset_axes(picture, left, bottom, across, up)
    bar = inset_axes(picture, left + across + gap, bottom, bar_width, up)
    axes.set(xlabel="$x/L$ [–]", ylabel="$z/H$ [–]", xlim=(0, 1), ylim=(0, 1), aspect=height / width)
    axes.set_xticks(np.linspace(0, 1, 3))
    return picture, axes, bar


def _paint(axes: Axes, results: Results, field: xr.DataArray, cmap: Colormap, limits: tuple[float, float]) -> QuadMesh:
    """Colour each cell with its own value: nothing is smoothed."""
    width, _, height = results.size
    return axes.pcolormesh(
        cell_edges(field["x"].values, width),
        cell_edges(field["z"].values, height),
        field.transpose("z", "x").values,
        cmap=cmap,
        vmin=limits[0],
        vmax=limits[1],
    )


def _colour_bar(picture: Figure, bar: Axes, mesh: QuadMesh, limits: tuple[float, float], label: str) -> None:
    arrows = extend(np.asarray(mesh.get_array()), *limits)
    ticks = MaxNLocator(7, steps=[1, 2, 5, 10])
    picture.colorbar(mesh, cax=bar, extend=arrows, extendfrac=0.03, label=label, ticks=ticks)


def _arrows(axes: Axes, results: Results, flux: xr.DataArray) -> None:
    """Arrows of true direction, as long as the flux is strong, in black or white against the colour behind them.

    They stand at places that do not depend on the mesh, so that meshes can be compared; a coarse mesh has fewer.
    """
    width, _, height = results.size
    columns = min(ARROWS_ACROSS, flux["x"].size)
    rows = min(max(1, round(columns * height / width)), flux["z"].size)
    along_x = _interpolation(flux["x"].values, width, columns)
    along_z = _interpolation(flux["z"].values, height, rows)
    across, up = (along_z @ flux.sel(component=axis).transpose("z", "x").values @ along_x.T for axis in ("x", "z"))
    x, z = np.meshgrid(_middles(columns), _middles(rows))
    strength = np.hypot(across, up)
    shown = strength > SHORTEST_ARROW * np.max(strength)
    axes.quiver(
        x[shown],
        z[shown],
        across[shown],
        up[shown],
        color=["white" if value > 0.55 * np.max(strength) else "black" for value in strength[shown]],
        angles="uv",
        scale_units="x",
        scale=np.max(strength) * columns / LONGEST_ARROW,
        units="inches",
        width=0.011,
        headwidth=4.0,
        headlength=4.5,
        headaxislength=4.0,
        minlength=0,
        pivot="mid",
    )


def _middles(parts: int) -> np.ndarray:
    return (np.arange(parts) + 0.5) / parts


def _interpolation(centres: np.ndarray, length: float, parts: int) -> np.ndarray:
    """Matrix (parts, n) that takes values at n cell centres linearly to the middles of `parts` <= n equal parts."""
    middles = _middles(parts) * length
    return np.stack([np.interp(middles, centres, unit) for unit in np.eye(centres.size)], axis=1)


def _dimensionless(results: Results, field: xr.DataArray) -> tuple[np.ndarray, np.ndarray]:
    width, _, height = results.size
    return field["x"].values / width, field["z"].values / height
