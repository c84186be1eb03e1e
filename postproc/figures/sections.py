"""Bubbles that pass horizontal sections, as tomography shows them."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fbcouple.postproc.figures.bubbles import EDGE, SMALLEST
from fbcouple.postproc.figures.probes import MOST_COLUMNS, thin
from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.sections import OPEN, Passing, Section, cut_section, find_passing, list_sections, read_section
from fbcouple.postproc.style import BLUE, ORANGE, PAGE, inset_axes, new_figure
from fbcouple.postproc.value_text import with_error
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results

FEWEST = 5
"""Bubbles from which on the standard error of their mean diameter is told."""
_BINS = 15
_LEFT, _BOTTOM, _EACH, _GAP, _RIGHT = 0.7, 0.45, 1.2, 0.3, 1.5


@figure
def sections(results: Results) -> Figure:
    """Of each horizontal section (probes at a height with the voidage): the voidage along its middle row against time,
    and the equivalent diameters of the bubbles that passed it within the averaging window."""
    names = list_sections(results)
    if not names:
        raise NotMeantError([f"the case of {results.path} has no probes of the voidage at a height."])
    found = [cut_section(read_section(results, name), results.first_window) for name in names]
    if not any(len(section.times) for section in found):
        raise NotDrawableError([f"{results.path} has no sample of its sections in the averaging window yet."])
    smallest = SMALLEST * float(results.case["particles"]["diameter"])
    note = (
        f"edge of a bubble: voidage {EDGE:g}; from {1e3 * smallest:.3g} mm; what covers {OPEN:g} of the section is "
        "none; equivalent diameter of each at its widest"
    )
    picture = new_figure(results.title, PAGE, _BOTTOM + len(names) * (_EACH + _GAP), note)
    least = min(float(np.nanmin(section.voidage)) for section in found if len(section.times))
    beside: list[Axes] = []
    largest = 0.0
    for row, (name, section) in enumerate(reversed(list(zip(names, found, strict=True)))):
        if not len(section.times):
            continue
        bottom, passing = _BOTTOM + row * (_EACH + _GAP), find_passing(section, smallest)
        axes = _draw_voidage(picture, bottom, section, least)
        title = f"{name}, z = {1e3 * section.height:.4g} mm: {_describe(passing)}"
        axes.set_title(title, loc="left", size="small", pad=2.0)
        beside.append(_draw_diameters(picture, bottom, passing))
        largest = max(largest, 1.1e3 * float(passing.diameters.max(initial=0.0)))
        if row == 0:
            axes.set_xlabel("Time [s]", labelpad=1.0)
            beside[0].set_xlabel("Equivalent diameter [mm]", labelpad=1.0)
    for sizes in beside:
        sizes.set_xlim(0.0, largest or 1.0)
    return picture


def _draw_voidage(picture: Figure, bottom: float, section: Section, least: float) -> Axes:
    axes = inset_axes(picture, _LEFT, bottom, PAGE - _LEFT - _RIGHT - 1.35, _EACH)
    middle = section.voidage[:, section.voidage.shape[1] // 2]
    times, values = thin(section.times, middle, MOST_COLUMNS)
    axes.set_ylabel("x [mm]")
    image = axes.pcolormesh(
        times, 1e3 * section.x, values.T, cmap="viridis", shading="nearest", rasterized=True, vmin=least, vmax=1.0
    )
    bar = inset_axes(picture, PAGE - _RIGHT - 1.27, bottom, 0.09, _EACH)
    picture.colorbar(image, cax=bar).set_label("Voidage [–]", size="small")
    return axes


def _draw_diameters(picture: Figure, bottom: float, passing: Passing) -> Axes:
    axes = inset_axes(picture, PAGE - _RIGHT, bottom, _RIGHT - 0.12, _EACH)
    axes.set_ylabel("Bubbles")
    axes.yaxis.set_major_locator(MaxNLocator(3, integer=True))
    if len(passing.diameters):
        axes.hist(1e3 * passing.diameters, bins=_BINS, color=BLUE)
        axes.axvline(1e3 * float(passing.diameters.mean()), color=ORANGE, linewidth=1.2)
    return axes


def _describe(passing: Passing) -> str:
    count = len(passing.diameters)
    text = "no bubble passes"
    if count:
        mean = f"{1e3 * passing.diameters.mean():.3g}"
        if count >= FEWEST:
            error = passing.diameters.std(ddof=1) / np.sqrt(count)
            mean = with_error(1e3 * passing.diameters.mean(), 1e3 * error)
        text = f"{count} bubble{'s' * (count > 1)} of {mean} mm"
    return f"{text}, {passing.open} void{'s' * (passing.open != 1)} cover{'s' * (passing.open == 1)} the section"
