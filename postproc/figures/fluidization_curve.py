"""Pressure drop against superficial velocity under a ramp of the inlet, and the onset of fluidization on it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import nnls

from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.style import BLUE, COLUMN, GREY, VERMILION, inset_axes, new_figure
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results

PACKED = (0.1, 0.85)
"""Pressure drop over the bed's weight per area, from and to which a bed counts as packed and at rest."""
FEWEST = 5
"""Rows of a packed bed from which a line is laid through them."""
BRANCHES = {"up": (1.0, BLUE, "o"), "down": (-1.0, VERMILION, "s")}
"""Sign of the change of velocity, colour and marker of each."""


@dataclass(frozen=True)
class Onset:
    """Where the line a U + b U^2 (Ergun's form) through the packed rows of a branch reaches the bed's weight."""

    linear: float
    """a [Pa s/m]."""
    square: float
    """b [Pa s2/m2]."""
    velocity: float
    """Minimum fluidization velocity U_mf [m/s]."""

    def pressure(self, velocity: np.ndarray) -> np.ndarray:
        """Of the packed bed at `velocity` (n,) [m/s], in Pa."""
        return self.linear * velocity + self.square * velocity**2


def find_onset(velocity: np.ndarray, pressure: np.ndarray, weight: float) -> Onset | None:
    """The onset on one branch: `velocity` [m/s] and `pressure` drop [Pa] of its rows (n,), `weight` per area [Pa].

    None if the branch has fewer than `FEWEST` rows of a packed bed. Least squares with a, b >= 0.
    """
    above = velocity[pressure > PACKED[1] * weight]
    packed = (pressure > PACKED[0] * weight) & (pressure < PACKED[1] * weight) & (velocity > 0.0)
    packed &= velocity < (above.min() if above.size else math.inf)
    if packed.sum() < FEWEST:
        return None
    speeds = velocity[packed]
    (linear, square), _ = nnls(np.column_stack([speeds, speeds**2]), pressure[packed])
    onset = 2.0 * weight / (linear + math.sqrt(linear**2 + 4.0 * square * weight))
    return Onset(float(linear), float(square), float(onset))


def list_branches(results: Results) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Velocity [m/s] and pressure drop [Pa] of the rows while the gas is turned up, and down."""
    speed, pressure = results.history("inlet_velocity").values, results.history("pressure_drop").values
    change = np.gradient(speed) if len(speed) > 1 else np.zeros_like(speed)
    known = np.isfinite(speed) & np.isfinite(pressure)
    rows = {name: known & (sign * change > 0.0) for name, (sign, *_) in BRANCHES.items()}
    return {name: (speed[chosen], pressure[chosen]) for name, chosen in rows.items() if chosen.any()}


@figure
def fluidization_curve(results: Results) -> Figure:
    """Pressure drop against superficial velocity under a ramp, both ways, with U_mf of each."""
    if "inlet_velocity" not in results.data or results.weight_per_area is None:
        raise NotMeantError([f"{results.path} has no ramp of the inlet, or no bed."])
    branches, weight = list_branches(results), results.weight_per_area
    if not branches:
        raise NotDrawableError([f"{results.path}: the velocity of the inlet does not change."])
    picture = new_figure(results.title, COLUMN, 2.9, "means since the last row; lines: a U + b U$^2$ of the packed bed")
    axes = inset_axes(picture, 0.66, 0.42, COLUMN - 0.78, 2.4)
    axes.axhline(weight, color=GREY, linestyle=":", linewidth=1.0, label="weight per area")
    for name, (speed, pressure) in branches.items():
        _, colour, marker = BRANCHES[name]
        onset = find_onset(speed, pressure, weight)
        words = f"{name}: U$_{{mf}}$ = {onset.velocity:.3g} m/s" if onset else f"{name}: no packed bed seen"
        axes.plot(speed, pressure, marker, color=colour, markersize=2.5, markerfacecolor="none", label=words)
        if onset:
            line = np.linspace(0.0, onset.velocity, 50)
            axes.plot(line, onset.pressure(line), color=colour, linewidth=1.0)
    axes.set(xlabel="Superficial velocity [m s$^{-1}$]", ylabel="Pressure drop [Pa]")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="lower right", fontsize="small")
    return picture
