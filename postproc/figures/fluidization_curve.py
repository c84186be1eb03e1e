"""Pressure drop against superficial velocity under a ramp of the inlet, and the onset of fluidization on it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import nnls

from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.style import BLUE, COLUMN, GREY, VERMILION, inset_axes, new_figure
from fbcouple.postproc.value_text import with_error
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results

PACKED = (0.1, 0.85)
"""Pressure drop over the bed's weight per area, from and to which a bed counts as packed and at rest."""
RAISED = 1.02
"""Height of the centre of mass over its lowest on a branch above which the bed is expanded, or still falls."""
FEWEST = 5
"""Rows of a packed bed from which a line is laid through them."""
GROUPS = 10
"""Groups of rows, each left out once, by which the error of an onset is told."""
STILL = 1e-9
"""Change of the velocity from row to row, over the fastest, below which the gas is neither turned up nor down."""
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
    error: float
    """Its standard error [m/s], by leaving out one group of neighbouring rows after the other."""
    rows: np.ndarray
    """Which rows of the branch are of the packed bed, (n,)."""

    def pressure(self, velocity: np.ndarray) -> np.ndarray:
        """Of the packed bed at `velocity` (n,) [m/s], in Pa."""
        return self.linear * velocity + self.square * velocity**2


def find_onset(
    velocity: np.ndarray, pressure: np.ndarray, weight: float, centre: np.ndarray | None = None
) -> Onset | None:
    """The onset on one branch, of whose rows (n,) `velocity` [m/s], `pressure` drop [Pa] and height of the `centre` of
    mass [m] are given; `weight` per area [Pa].

    None if the branch has fewer than `FEWEST` rows of a packed bed. Least squares with a, b >= 0; the error is that of
    the jackknife by groups (Tukey 1958; Miller 1974, Biometrika 61:1).
    """
    above = velocity[pressure > PACKED[1] * weight]
    packed = (pressure > PACKED[0] * weight) & (pressure < PACKED[1] * weight) & (velocity > 0.0)
    packed &= velocity < (above.min() if above.size else math.inf)
    if centre is not None:
        packed &= centre <= RAISED * centre.min()
    if packed.sum() < FEWEST:
        return None
    speeds, losses = velocity[packed], pressure[packed]
    linear, square, onset = _fit(speeds, losses, weight)
    parts = np.array_split(np.arange(len(speeds)), min(GROUPS, len(speeds)))
    others = np.array([_fit(np.delete(speeds, part), np.delete(losses, part), weight)[2] for part in parts])
    error = math.sqrt((len(parts) - 1) * float(others.var()))
    return Onset(linear, square, onset, error, packed)


def _fit(velocity: np.ndarray, pressure: np.ndarray, weight: float) -> tuple[float, float, float]:
    """a and b of the line, and where it reaches the weight."""
    (linear, square), _ = nnls(np.column_stack([velocity, velocity**2]), pressure)
    onset = 2.0 * weight / (linear + math.sqrt(linear**2 + 4.0 * square * weight))
    return float(linear), float(square), float(onset)


@dataclass(frozen=True)
class Branch:
    """The rows of a ramp while the gas is turned up, or down: velocity [m/s] and pressure drop [Pa] (n,), its onset,
    the mean voidage of the packed bed on it, and U_mf [m/s] by the case's drag at that voidage; nan where not known."""

    name: str
    velocity: np.ndarray
    pressure: np.ndarray
    onset: Onset | None
    voidage: float
    by_drag: float


def list_branches(results: Results) -> list[Branch]:
    """The branches that a run has, up before down.

    Raises: NotDrawableError if the gas does not change, NotMeantError if it has no ramp or there is no bed.
    """
    weight = results.weight_per_area
    if "inlet_velocity" not in results.data or weight is None:
        raise NotMeantError([f"{results.path} has no ramp of the inlet, or no bed."])
    speed, pressure = results.history("inlet_velocity").values, results.history("pressure_drop").values
    change = np.gradient(speed) if len(speed) > 1 else np.zeros_like(speed)
    known = np.isfinite(speed) & np.isfinite(pressure)
    least = STILL * float(np.nanmax(np.abs(speed)))
    centre = results.history("solids_centre_z").values if "solids_centre_z" in results.data else None
    branches = []
    for name, (sign, *_) in BRANCHES.items():
        chosen = known & (sign * change > least)
        if chosen.any():
            heights = None if centre is None else centre[chosen]
            onset = find_onset(speed[chosen], pressure[chosen], weight, heights)
            voidage = _find_voidage(results, np.flatnonzero(chosen)[onset.rows]) if onset else math.nan
            by_drag = _find_by_drag(results, voidage)
            branches.append(Branch(name, speed[chosen], pressure[chosen], onset, voidage, by_drag))
    if not branches:
        raise NotDrawableError([f"{results.path}: the velocity of the inlet does not change."])
    return branches


def _find_voidage(results: Results, rows: np.ndarray) -> float:
    """Mean voidage of the bed in `rows` of the history, twice as high as its centre of mass; nan if not recorded."""
    needed = "solids_volume", "bed_section"
    if "solids_centre_z" not in results.data or any(name not in results.data.attrs for name in needed):
        return math.nan
    volume, section = (float(results.data.attrs[name]) for name in needed)
    return 1.0 - volume / section / (2.0 * float(results.history("solids_centre_z").values[rows].mean()))


def _find_by_drag(results: Results, voidage: float) -> float:
    if "drag_onset_velocity" not in results.data:
        return math.nan
    known = results.data["drag_onset_velocity"]
    return float(np.interp(voidage, known["packed_voidage"], known, left=math.nan, right=math.nan))


@figure
def fluidization_curve(results: Results) -> Figure:
    """Pressure drop against superficial velocity under a ramp, both ways, with U_mf of each, its standard error, and
    U_mf by the case's drag at the voidage that the bed has there."""
    branches, weight = list_branches(results), results.weight_per_area
    assert weight is not None
    note = "means since the last row; lines: a U + b U$^2$ of the packed bed, which ends in U$_{mf}$ at the weight"
    picture = new_figure(results.title, COLUMN, 3.5, note)
    axes = inset_axes(picture, 0.66, 1.02, COLUMN - 0.78, 2.4)
    axes.axhline(weight, color=GREY, linestyle=":", linewidth=1.0, label=f"weight per area, {weight:.4g} Pa")
    for branch in branches:
        _draw(axes, branch)
    axes.set(xlabel="Superficial velocity [m s$^{-1}$]", ylabel="Pressure drop [Pa]")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    picture.legend(*axes.get_legend_handles_labels(), loc="lower left", fontsize="small")
    return picture


def _draw(axes: Axes, branch: Branch) -> None:
    _, colour, marker = BRANCHES[branch.name]
    look: Any = {"color": colour, "markersize": 2.5, "markerfacecolor": "none"}
    axes.plot(branch.velocity, branch.pressure, marker, label=_describe(branch), **look)
    if branch.onset:
        line = np.linspace(0.0, branch.onset.velocity, 50)
        axes.plot(line, branch.onset.pressure(line), color=colour, linewidth=1.0)
        axes.axvline(branch.onset.velocity, color=colour, linestyle="--", linewidth=0.7)
    if math.isfinite(branch.by_drag):
        axes.axvline(branch.by_drag, color=colour, linestyle=":", linewidth=0.9)


def _describe(branch: Branch) -> str:
    if branch.onset is None:
        return f"{branch.name}: no packed bed seen"
    words = f"{branch.name}: U$_{{mf}}$ = {with_error(branch.onset.velocity, branch.onset.error)} m/s (dashed)"
    if math.isnan(branch.by_drag):
        return words
    return f"{words};\nby the drag law at voidage {branch.voidage:.3f}: {branch.by_drag:.3g} m/s (dotted)"
