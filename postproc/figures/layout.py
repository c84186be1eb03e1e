"""Maps side by side: true proportions, dimensionless axes, one colour scale and one colour bar."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from fbcouple.postproc.figures.heights import find_tops
from fbcouple.postproc.style import (
    COLUMN,
    FONT_SIZE,
    PAGE,
    SKY,
    colours,
    extend,
    inset_axes,
    measure,
    new_figure,
    shorten_numbers,
)
from fbcouple.postproc.symbols import explain
from fbcouple.results.reader import Results

MOST_ACROSS = 5
"""Maps in one row; more of them stand in rows below, on the same scale."""
LEFT, BOTTOM, BAR_GAP, BAR, RIGHT, TOP, GAP = 0.52, 0.42, 0.12, 0.13, 0.62, 0.12, 0.14  # inches
LINE = 0.14  # inches, a line of a map's own title
WIDEST = COLUMN - LEFT - BAR_GAP - BAR - RIGHT  # inches, a map that stands alone in a column of a journal
OWN_SCALE = 0.42  # inches between maps of boxes of different heights, each with its own scale
ENTRY = 0.16  # inches, a line of the legend
TICK = 0.2  # inches between two numbers along an axis
LETTER = 0.53 * (FONT_SIZE - 1) / 72  # inches, the width of a mean letter
EMPTY = "#C8C8C8"


@dataclass(frozen=True)
class Panel:
    """One map: the run it is of, its `field` (z, x), the title above it, and what is drawn onto it."""

    results: Results
    field: xr.DataArray
    title: str
    adorn: Callable[[Axes], None] | None


@dataclass(frozen=True)
class Line:
    """A line that is drawn onto maps: its style, and in words what it is."""

    style: Literal["-", "--"]
    words: str


def draw_panels(
    panels: Sequence[Panel],
    heading: str,
    note: str,
    label: str,
    limits: tuple[float, float],
    mark: float | None = None,
    line: Line | None = None,
    cmap: str = "magma_r",
    empty: str = "no particles",
) -> Figure:
    """Draw maps on one colour scale with these `limits`, each up to a little above the bed.

    mark: a value to mark on the colour bar; line: what is drawn onto the maps, for the legend; empty: what places
    without a value are.
    """
    tops = find_tops([panel.results for panel in panels])
    columns = min(len(panels), MOST_ACROSS)
    rows = -(-len(panels) // columns)
    shapes = [top * panel.results.size[2] / panel.results.size[0] for panel, top in zip(panels, tops, strict=True)]
    gap = GAP if len({panel.results.size[2] for panel in panels}) == 1 else OWN_SCALE
    across = _share_width(columns, gap, RIGHT, max(shapes))
    folded = _fold_label(label, across * max(shapes))
    right = RIGHT + LINE * folded.count("\n")
    across = _share_width(columns, gap, right, max(shapes))
    titles = [_wrap(panel.title, max(int(across / LETTER), 8)) for panel in panels]
    up, above = across * max(shapes), LINE * max(title.count("\n") + bool(title) for title in titles)
    full = max(LEFT + columns * across + (columns - 1) * gap + BAR_GAP + BAR + right, 2.6)
    each = up + above + GAP
    handles = _list_handles(panels, tops, limits, line, empty)
    lines = [handle.get_label().split("\n") for handle in handles]
    beside = max(int(full / (LETTER * max((len(line) for label in lines for line in label), default=1) + 0.5)), 1)
    longest = max(map(measure, folded.split("\n")))
    below = max(BOTTOM + ENTRY * -(-sum(map(len, lines)) // beside), longest - up + GAP)
    words = "; ".join(filter(None, [_tell_top(note, panels, tops), explain(label, "x/L", "z/H", known=note)]))
    picture = new_figure(heading, full, below + rows * each - GAP + TOP, words)
    meshes = []
    for index, (panel, title) in enumerate(zip(panels, titles, strict=True)):
        row, column = divmod(index, columns)
        corner = LEFT + column * (across + gap), below + (rows - 1 - row) * each
        axes = inset_axes(picture, *corner, across, across * shapes[index])
        meshes.append(_draw(axes, panel, tops[index], limits, cmap))
        axes.set_title(title, size="small", pad=2.5, parse_math=False)
        axes.tick_params(labelbottom=index + columns >= len(panels), labelleft=column == 0 or gap == OWN_SCALE)
        axes.set_xlabel("$x/L$ [–]" if index + columns >= len(panels) else "")
        axes.set_ylabel("$z/H$ [–]" if column == 0 else "")
    corner = LEFT + columns * across + (columns - 1) * gap + BAR_GAP, below + (rows - 1) * each
    bar = inset_axes(picture, *corner, BAR, up)
    _draw_bar(picture, bar, meshes, (tops, limits), folded)
    if longest > up:
        bar.set_ylabel(folded, loc="top")
    if mark is not None:
        bar.axhline(mark, color="black", linewidth=0.8, linestyle=line.style if line else "--")
    if handles:
        picture.legend(handles=handles, loc="lower left", ncols=beside, handlelength=1.6, borderaxespad=0.3)
    return picture


def _share_width(columns: int, gap: float, right: float, shape: float) -> float:
    """Width [inches] of a map, of `columns` beside each other, the highest of which is `shape` times as high."""
    room = (PAGE - LEFT - BAR_GAP - BAR - right - (columns - 1) * gap) / columns
    return min(WIDEST, 5.2 / shape, room)


def _fold_label(label: str, length: float) -> str:
    """The label of a colour bar, its symbol on a second line where it is longer than the bar [inches]."""
    return label.replace(" $", "\n$", 1) if measure(label) > length else label


def _wrap(title: str, letters: int) -> str:
    """Each line of a title in lines of at most so many letters."""
    return "\n".join(textwrap.fill(line, letters) for line in title.split("\n"))


def _tell_top(note: str, panels: Sequence[Panel], tops: Sequence[float]) -> str:
    """The note, and how far up the maps go where that is not all."""
    if min(tops) == 1.0:
        return note
    heights = [panel.results.size[2] for panel in panels]
    shown = f"up to z = {1e3 * min(tops) * heights[tops.index(min(tops))]:.3g} mm of {1e3 * max(heights):.3g} mm"
    return f"{note}; {shown}".lstrip("; ")


def _see(panel: Panel, top: float) -> np.ndarray:
    """The values (z, x) of a map that are shown below z/H = `top`."""
    values = panel.field.transpose("z", "x").values
    return np.asarray(values[: round(top * len(values))])


def _list_handles(
    panels: Sequence[Panel], tops: Sequence[float], limits: tuple[float, float], line: Line | None, empty: str
) -> list[Any]:
    """Legend of what the colour bar does not tell, of that only what is there."""
    shown = [_see(panel, top) for panel, top in zip(panels, tops, strict=True)]
    handles: list[Any] = []
    if line is not None:
        handles.append(Line2D([], [], color="black", linewidth=0.8, linestyle=line.style, label=line.words))
    if any((values[np.isfinite(values)] > limits[1]).any() for values in shown):
        handles.append(Patch(color=SKY, label=f"above {limits[1]:.3g}, the end of the scale"))
    if any(not np.isfinite(values).all() for values in shown):
        is_box = all(panel.results.is_box for panel in panels)
        handles.append(Patch(color=EMPTY, label=empty if is_box else f"{empty},\nor outside of the mesh"))
    return handles


def _draw(axes: Axes, panel: Panel, top: float, limits: tuple[float, float], cmap: str) -> QuadMesh:
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
    axes.set(xlim=(0, 1), ylim=(0, top), aspect=height / width)
    axes.set_xticks([0, 0.5, 1], ["0", "0.5", "1"])
    axes.yaxis.set_major_locator(_find_ticks(axes, 6))
    axes.set_facecolor(EMPTY)
    if panel.adorn:
        panel.adorn(axes)
    return mesh


def _draw_bar(
    picture: Figure,
    bar: Axes,
    meshes: Sequence[QuadMesh],
    scale: tuple[Sequence[float], tuple[float, float]],
    label: str,
) -> None:
    """The colour bar of all maps; `scale`: up to where each is shown, and the limits of the colours."""
    tops, limits = scale
    arrays: list[Any] = [np.ma.asarray(mesh.get_array()) for mesh in meshes]
    shown = [values[: round(top * len(values))] for values, top in zip(arrays, tops, strict=True)]
    arrows = extend(np.concatenate([np.ma.compressed(values) for values in shown]), *limits)
    picture.colorbar(meshes[0], cax=bar, extend=arrows, extendfrac=0.03, label=label, ticks=_find_ticks(bar, 7))
    shorten_numbers(bar.yaxis)


def _find_ticks(axes: Axes, most: int) -> MaxNLocator:
    """Round ticks along the height of `axes`, so many that their numbers keep clear of each other."""
    inches = axes.get_position().height * axes.get_figure(root=True).get_figheight()  # type: ignore[union-attr]
    return MaxNLocator(min(max(int(inches / TICK), 1), most), steps=[1, 2, 5, 10])
