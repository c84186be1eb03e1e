"""Maps side by side: true proportions, dimensionless axes, one colour scale and one colour bar."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fbcouple.postproc.style import PAGE, SKY, colours, extend, inset_axes, new_figure
from fbcouple.results.reader import Results

MOST_ACROSS = 5
"""Maps in one row; more of them stand in rows below, on the same scale."""
LEFT, BOTTOM, BAR_GAP, BAR, RIGHT, TOP, GAP = 0.52, 0.42, 0.12, 0.13, 0.62, 0.12, 0.14  # inches
LINE = 0.14  # inches, a line of a map's own title


@dataclass(frozen=True)
class Panel:
    """One map: the run it is of, its `field` (z, x), the title above it, and what is drawn onto it."""

    results: Results
    field: xr.DataArray
    title: str
    adorn: Callable[[Axes], None] | None


def draw_panels(
    panels: Sequence[Panel],
    heading: str,
    note: str,
    label: str,
    limits: tuple[float, float],
    mark: float | None = None,
    cmap: str = "magma_r",
) -> Figure:
    """Draw maps on one colour scale with these `limits`; `mark`: a value to mark on the colour bar."""
    columns = min(len(panels), MOST_ACROSS)
    rows = -(-len(panels) // columns)
    shapes = [panel.results.size[2] / panel.results.size[0] for panel in panels]
    room = (PAGE - LEFT - BAR_GAP - BAR - RIGHT - (columns - 1) * GAP) / columns
    across = min(3.0, 5.2 / max(shapes), room)
    up, titles = across * max(shapes), LINE * max(panel.title.count("\n") + bool(panel.title) for panel in panels)
    full = max(LEFT + columns * across + (columns - 1) * GAP + BAR_GAP + BAR + RIGHT, 2.6)
    each = up + titles + GAP
    body = BOTTOM + rows * each - GAP + TOP
    picture = new_figure(heading, full, body, note)
    meshes = []
    for place, panel in enumerate(panels):
        row, column = divmod(place, columns)
        is_lowest = place + columns >= len(panels)
        axes = inset_axes(
            picture,
            LEFT + column * (across + GAP),
            BOTTOM + (rows - 1 - row) * each,
            across,
            across * shapes[place],
        )
        meshes.append(_draw(axes, panel, limits, cmap, column == 0, is_lowest))
    bar = inset_axes(
        picture, LEFT + columns * across + (columns - 1) * GAP + BAR_GAP, BOTTOM + (rows - 1) * each, BAR, up
    )
    _draw_bar(picture, bar, meshes, limits, label)
    if mark is not None:
        bar.axhline(mark, color="black", linewidth=0.8, linestyle="--")
    return picture


def _draw(
    axes: Axes, panel: Panel, limits: tuple[float, float], cmap: str, is_first: bool, is_lowest: bool
) -> QuadMesh:
    """Colour each cell with its own value: nothing is smoothed."""
    width, _, height = panel.results.size
    mesh = axes.pcolormesh(
        np.linspace(0.0, 1.0, panel.field.sizes["x"] + 1),
        np.linspace(0.0, 1.0, panel.field.sizes["z"] + 1),
        np.ma.masked_invalid(panel.field.transpose("z", "x").values),
        cmap=colours(cmap, over=SKY),
        vmin=limits[0],
        vmax=limits[1],
    )
    axes.set(xlim=(0, 1), ylim=(0, 1), aspect=height / width)
    axes.set_xticks([0, 0.5, 1], ["0", "0.5", "1"])
    axes.set_facecolor("#C8C8C8")
    axes.tick_params(labelbottom=is_lowest, labelleft=is_first)
    if is_lowest:
        axes.set_xlabel("$x/L$ [–]")
    if is_first:
        axes.set_ylabel("$z/H$ [–]")
    if panel.title:
        axes.set_title(panel.title, size="small", pad=2.5, parse_math=False)
    if panel.adorn:
        panel.adorn(axes)
    return mesh


def _draw_bar(picture: Figure, bar: Axes, meshes: Sequence[QuadMesh], limits: tuple[float, float], label: str) -> None:
    values = np.concatenate([np.ma.compressed(np.ma.asarray(mesh.get_array())) for mesh in meshes])
    arrows = extend(values, *limits)
    ticks = MaxNLocator(7, steps=[1, 2, 5, 10])
    picture.colorbar(meshes[0], cax=bar, extend=arrows, extendfrac=0.03, label=label, ticks=ticks)
