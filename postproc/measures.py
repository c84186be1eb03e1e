"""Numbers of a run that the paper's statements speak of, each with its statistical standard error."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fbcouple.postproc.figures.profiles import Profile, vertical_flux
from fbcouple.postproc.jackknife import estimate_number_error, mirror_flux
from fbcouple.postproc.joined_rows import require_own_rows
from fbcouple.results.depth_means import depth_average
from fbcouple.results.reader import NotDrawableError, Results

BLOCKS = 10
DENSE = 0.2
"""Solids fraction of the dense bed (section 4.2)."""
FLUX_HEIGHT = 0.092
"""z/H of the measured profiles of the flux (section 4.1)."""
FREEBOARD = 0.375
"""z/H above which the paper sees no particles (section 4.2)."""
WALL_STRIP = 5e-3
"""Width [m] of the strips along the side walls that count as near them."""
PLACES = 4
"""Places of a map that move on their own, at the fewest: a quarter of the bed has a bubble of its own."""


@dataclass(frozen=True)
class Measured:
    """A value and its standard error, in the same unit."""

    value: float
    error: float

    def __sub__(self, other: Measured) -> Measured:
        return Measured(self.value - other.value, math.hypot(self.error, other.error))

    def is_above(self, limit: float) -> bool | None:
        """Whether the value is above `limit`; None if it lies within two standard errors of it, or has none."""
        if not math.isfinite(self.error) or abs(self.value - limit) <= 2.0 * self.error:
            return None
        return bool(self.value > limit)


def average(values: Sequence[Measured]) -> Measured:
    """Mean of values of runs that err on their own."""
    count = len(values)
    return Measured(
        sum(value.value for value in values) / count, math.hypot(*(value.error for value in values)) / count
    )


def in_window(results: Results, name: str) -> np.ndarray:
    """History `name` within the averaging window; of replicas that of the first within its own."""
    return cut_to_window(results, name)[1]


def cut_to_window(results: Results, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and values of the same. Raises: NotDrawableError without a window, or if the rows are of no run."""
    require_own_rows(results, name)
    values = results.history(name)
    if results.first_window is None:
        raise NotDrawableError([f"{results.path} has no averaging window."])
    start, end = results.first_window
    time = values["time"].values.astype(float)
    inside = (time >= start) & (time <= end)
    return time[inside], values.values[inside]


def mean_of_history(results: Results, name: str) -> Measured:
    """Mean of a history over the averaging window; the error from the means of `BLOCKS` blocks, of a pool as it has
    both."""
    if (pooled := results.window_mean(name)) is not None:
        return Measured(*pooled)
    values = in_window(results, name)
    if len(values) < 2 * BLOCKS:
        raise NotDrawableError([f"`{name}` in {results.path} has {len(values)} rows in the window; too few."])
    means = np.array([block.mean() for block in np.array_split(values, BLOCKS)])
    return Measured(float(values.mean()), float(means.std(ddof=1) / math.sqrt(BLOCKS)))


def bed_height(results: Results) -> Measured:
    """Time-mean height [m] of the bed."""
    return mean_of_history(results, "bed_height")


def centre_fluctuation(results: Results) -> Measured:
    """Standard deviation of the height of the particles' centre of mass over its mean: bubbles lift and drop it."""
    require_own_rows(results, "solids_centre_z", is_of_spread=True)
    values = in_window(results, "solids_centre_z")
    mean = mean_of_history(results, "solids_centre_z").value
    parts = np.array([block.var() for block in np.array_split(values, BLOCKS)])
    variance, error = float(values.var()), float(parts.std(ddof=1) / math.sqrt(BLOCKS))
    deviation = math.sqrt(variance)
    return Measured(deviation / mean, error / (2.0 * deviation) / mean if deviation else 0.0)


def measure(results: Results, number: Callable[[Results], float]) -> Measured:
    """`number` of the time means of a run, with its standard error by blocks, nan where they tell none."""
    try:
        error = estimate_number_error(results, number)
    except NotDrawableError:
        error = math.nan
    return Measured(number(results), error)


def freeboard_solids(results: Results) -> Measured:
    """Solids fraction above z/H = 0.375, mean over the width, of the layer that has most."""
    return measure(results, lambda run: float(_rows(run, "solids_fraction")[run.share("z") >= FREEBOARD].mean(1).max()))


def agitation_peak(results: Results, height: float, allowed: float) -> tuple[float, Measured]:
    """z/H of the layer with most agitation per mass below z/H = 0.375, and by how much [m2 s-2] the largest value
    within `allowed` of z/H = `height` is above the largest elsewhere."""

    def lead(run: Results) -> float:
        heights, layers = _layer_agitation(run)
        near = np.abs(heights - height) <= allowed
        return float(layers[near].max() - layers[~near].max())

    heights, layers = _layer_agitation(results)
    return float(heights[np.argmax(layers)]), measure(results, lead)


def _layer_agitation(results: Results) -> tuple[np.ndarray, np.ndarray]:
    """z/H of the layers below z/H = 0.375 and their agitation per mass [m2 s-2], 0 where no particle ever was."""
    weight, agitation = results.mean("solids_fraction").values, _agitation(results)
    below = results.share("z") < FREEBOARD
    mass, total = (values[below].sum(axis=(1, 2)) for values in (weight, weight * agitation))
    return results.share("z")[below], np.divide(total, mass, out=np.zeros_like(mass), where=mass > 0.0)


def bed_agitation(results: Results) -> Measured:
    """Mean agitation per mass [m2 s-2] of the dense bed."""

    def number(run: Results) -> float:
        weight, agitation = run.mean("solids_fraction").values, _agitation(run)
        dense = weight > DENSE
        return float((weight * agitation)[dense].sum() / weight[dense].sum())

    return measure(results, number)


def _flux_profile(results: Results) -> Profile:
    return vertical_flux(results, FLUX_HEIGHT * results.size[2])


def middle_flux(results: Results) -> Measured:
    """Vertical solids flux over rho U_f at z/H = 0.092, mean of the middle third of the width."""

    def number(run: Results) -> float:
        profile = _flux_profile(run)
        return float(profile.value[np.abs(profile.position - 0.5) < 1.0 / 6.0].mean())

    return measure(results, number)


def wall_flux(results: Results) -> Measured:
    """Vertical solids flux over rho U_f at z/H = 0.092 in the cells next to the side walls, mean of both."""
    return measure(results, lambda run: float(_flux_profile(run).value[[0, -1]].mean()))


def flux_magnitude(results: Results) -> Measured:
    """Magnitude of the depth-mean solids flux [kg m-2 s-1], mean below z/H = 0.375; of a bed that is its own mirror
    image that of the flux averaged with its image, as chance alone makes them differ and a magnitude adds chance up."""

    def number(run: Results) -> float:
        flux = mirror_flux(run, np.array([_rows(run, "solids_flux", axis) for axis in "xz"]))
        return float(np.hypot(*flux)[run.share("z") < FREEBOARD].mean())

    return measure(results, number)


def wall_solids(results: Results) -> Measured:
    """Solids fraction within 5 mm of the side walls, mean below z/H = 0.25, the height of the dense bed."""

    def number(run: Results) -> float:
        x, below = run.share("x"), run.share("z") < 0.25
        strip = np.minimum(x, 1.0 - x) * run.size[0] < WALL_STRIP
        return float(_rows(run, "solids_fraction")[below][:, strip].mean())

    return measure(results, number)


def map_difference(one: Results, other: Results) -> Measured:
    """Root mean square difference of two depth-mean solids-fraction maps below z/H = 0.375, over the largest value,
    less what chance makes of it: the square root of D^2 - S^2, or 0, with D as seen and S of the standard errors.

    Its standard error is S over the root of `PLACES`, as D holds twice the product of the difference and the noise.
    """
    fields = [_rows(results, "solids_fraction") for results in (one, other)]
    errors = [_rows(results, "solids_fraction_stderr") for results in (one, other)]
    below = one.share("z") < FREEBOARD
    top = max(float(field.max()) for field in fields)
    seen = float(np.mean((fields[0] - fields[1])[below] ** 2))
    chance = float(np.mean(errors[0][below] ** 2 + errors[1][below] ** 2))
    return Measured(math.sqrt(max(seen - chance, 0.0)) / top, math.sqrt(chance / PLACES) / top)


def _rows(results: Results, name: str, axis: str | None = None) -> np.ndarray:
    """Depth mean (z, x) of a time mean, or of one component of it."""
    field = _require_errors(results, name) if name.endswith("_stderr") else results.mean(name)
    return depth_average(field.sel(component=axis) if axis else field).values


def _require_errors(results: Results, name: str) -> xr.DataArray:
    """The standard errors of a mean; NotDrawableError where there is none, as the window is too short to tell them."""
    errors = results.error(name)
    if not bool(np.isfinite(errors).any()):
        raise NotDrawableError([f"`{name}` in {results.path} has no standard error yet; run longer."])
    return errors


def _agitation(results: Results) -> np.ndarray:
    """Agitation (z, y, x) [m2 s-2], 0 where no particle ever was."""
    if "agitation" not in results.data:
        raise NotDrawableError([f"{results.path} has no `agitation`."])
    return np.nan_to_num(results.data["agitation"].values.astype(float))
