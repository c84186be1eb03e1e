"""Particles that came and went: their mass against time, and how long those that left had stayed."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.style import BLUE, GREY, ORANGE, PAGE, inset_axes, new_figure
from fbcouple.results.reader import NotMeantError, Results

FEWEST = 20
"""Particles that came in and left, below which their residence times are no distribution."""
_BINS = 30


def find_residence(results: Results) -> np.ndarray:
    """Residence times [s] of the particles that a feed brought and that have left."""
    if "exit_time" not in results.data:
        return np.empty(0)
    fed = results.data["exit_feed"].values > 0
    return (results.data["exit_time"].values - results.data["exit_entry_time"].values)[fed]


@figure
def throughput(results: Results) -> Figure:
    """Mass that came in, left and is held against time; residence times of the particles that a feed brought and that
    left."""
    if "mass_fed" not in results.data:
        raise NotMeantError([f"{results.path} has no particles that come or go."])
    residence = find_residence(results)
    picture = new_figure(results.title, PAGE, 2.5, _describe(residence, _name(results)))
    many = len(residence) >= FEWEST
    width = (PAGE - 1.9) / 2 if many else PAGE - 1.0
    _draw_mass(inset_axes(picture, 0.7, 0.45, width, 1.95), results)
    if many:
        axes = inset_axes(picture, 0.7 + width + 0.9, 0.45, width, 1.95)
        axes.hist(residence, bins=_BINS, density=True, color=BLUE)
        axes.axvline(float(residence.mean()), color=ORANGE, linewidth=1.2)
        axes.set(xlabel="Residence time [s]", ylabel=r"Density [s$^{-1}$]", xlim=(0.0, None))
    return picture


def _draw_mass(axes: Axes, results: Results) -> None:
    time = results.data["time"].values
    fed, removed = (1e3 * results.history(f"mass_{way}").values for way in ("fed", "removed"))
    axes.plot(time, fed, color=BLUE, label="came in")
    axes.plot(time, removed, color=ORANGE, label="left")
    axes.plot(time, fed - removed, color=GREY, linestyle=":", label="came in less left")
    axes.set(xlabel="Time [s]", ylabel="Mass [g]", xlim=(0.0, float(time[-1]) or None))
    axes.legend(loc="upper left")


def _name(results: Results) -> str:
    return "parcels" if results.case["particles"].get("coarse_graining") else "particles"


def _describe(residence: np.ndarray, what: str) -> str:
    if not len(residence):
        return f"no {what[:-1]} that a feed brought has left yet"
    mean = f"{len(residence)} {what} that feeds brought have left, after {residence.mean():.4g} s in the mean"
    return f"{mean} (standard deviation {residence.std():.3g} s)"
