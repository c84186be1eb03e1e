"""Profiles over the radius of a column at some heights."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fbcouple.postproc.averaging import averaging_text
from fbcouple.postproc.figures.heights import format_height
from fbcouple.postproc.figures.probes import LABELS
from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.radial import RadialProfile, list_radial_heights, list_radial_profiles
from fbcouple.postproc.style import COLUMN, GREY, LINES, lay_out
from fbcouple.postproc.symbols import explain
from fbcouple.results.reader import Results

_EACH = 1.5


@figure
def radial_profiles(results: Results) -> Figure:
    """Solids fraction, upward velocity and flux of the particles and upward gas flux over the radius of a column, means
    over rings, a line each height, with bands of one standard error."""
    heights = list_radial_heights(results)
    found = list_radial_profiles(results, heights)
    note = f"{'; '.join(format_height(z, results) for z in heights)}; means over rings about the middle"
    note += f"; {averaging_text(results)}; {_tell_bands(found)}"
    picture = lay_out(results.title, COLUMN, 0.9 + _EACH * len(found), f"{note}; {explain('z/H', known=note)}")
    panels = picture.subplots(len(found), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (quantity, profiles) in zip(panels, found.items(), strict=True):
        for index, profile in enumerate(profiles):
            _draw(axes, profile, index)
        axes.set_ylabel(LABELS[quantity])
        axes.margins(y=0.1)
        if quantity != "solids_fraction":
            axes.axhline(0.0, color=GREY, linewidth=0.7, zorder=0)
    panels[-1].set_xlabel("$r$ [mm]")
    panels[0].set_xlim(0.0, 500.0 * min(results.size[:2]))
    if len(heights) > 1:
        panels[0].legend(loc="lower left", bbox_to_anchor=(-0.02, 1.01), ncols=2, handlelength=1.8, borderaxespad=0.0)
    return picture


def _tell_bands(found: Mapping[str, Sequence[RadialProfile]]) -> str:
    """For a note: what the bands are, and which lines have none, as their standard errors are not known."""
    bare = [name for name, profiles in found.items() if any(profile.stderr is None for profile in profiles)]
    if len(bare) == len(found):
        return "standard errors not known: no bands"
    words = ", ".join(name.replace("_", " ") for name in bare)
    return "bands: ± 1 standard error" + (f", not known of {words}" if bare else "")


def _draw(axes: Axes, profile: RadialProfile, index: int) -> None:
    look, radius = LINES[index % len(LINES)], 1e3 * profile.radius
    if profile.stderr is not None:
        low, high = profile.value - profile.stderr, profile.value + profile.stderr
        axes.fill_between(radius, low, high, color=look["color"], alpha=0.2, linewidth=0)
    axes.plot(radius, profile.value, markersize=3.0, label=f"$z$ = {1e3 * profile.height:.3g} mm", **look)
