"""Time means over the radius of a column: rings about its axis, of the places that the regular grid has in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fbcouple.postproc.figures.heights import list_heights, read_heights
from fbcouple.results.depth_means import at_height
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results

QUANTITIES: dict[str, str] = {
    "solids_fraction": "1",
    "solids_velocity": "m s-1",
    "solids_flux": "kg m-2 s-1",
    "gas_flux": "m s-1",
}
"""What is averaged over rings, with its unit; of a vector the upward component."""
PARTICLE = ("solids_velocity", "agitation", "granular_temperature")
"""Quantities of particles, which are averaged with the solids as weight."""
OPTION = "radial_heights"


@dataclass(frozen=True)
class RadialProfile:
    """A quantity at `height` [m above the floor]: mean `radius` [m] of the places of each ring, `value`, nan where a
    ring never had what it is of, and `stderr` of the time mean, where that is known; (rings,) each."""

    quantity: str
    height: float
    radius: np.ndarray
    value: np.ndarray
    stderr: np.ndarray | None


def list_radial_heights(results: Results) -> tuple[float, ...]:
    """Heights of radial profiles: those asked for, else `output.radial_heights` of the case, else, of a cylinder, those
    of all profiles.

    Raises: NotMeantError of a bed that is no column.
    """
    given = read_heights(results, OPTION)
    is_round = results.case["domain"].get("shape", "box") == "cylinder"
    if not (is_round or given):
        raise NotMeantError([f"the bed of {results.path} is no cylinder, and its case has no output.{OPTION}."])
    return results.view.heights or given or list_heights(results)


def list_radial_profiles(results: Results, heights: Sequence[float]) -> dict[str, list[RadialProfile]]:
    """The profiles of each quantity that the results have, one a height. Raises: NotDrawableError if there is none."""
    if results.data.attrs.get("reduced"):
        raise NotDrawableError([f"{results.path} has depth averages alone (a reduced pool)."])
    quantities = [name for name in QUANTITIES if name in results.data]
    if not quantities:
        raise NotDrawableError([f"{results.path} has no time means of particles or gas."])
    return {name: [find_radial_profile(results, name, height) for height in heights] for name in quantities}


def find_radial_profile(results: Results, quantity: str, height: float) -> RadialProfile:
    """The mean of a time mean, of a vector its upward component, over rings about the middle of the bed, each as wide
    as a place of the regular grid, linear in z between layers of places; of PARTICLE with the solids as weight.

    The standard error is the mean over the ring: an upper bound, reached if its places err together.
    Raises: NotDrawableError if the results lack the quantity, or the height is not between two layers.
    """
    level = results.corner[2] + height
    radius, ring, count = _find_rings(results)

    def lay(field: xr.DataArray) -> np.ndarray:
        upward = field.sel(component="z") if "component" in field.dims else field
        return at_height(upward, level).transpose("y", "x").values

    weight = np.ones(radius.shape)
    if quantity in PARTICLE:
        values, weight = lay(results.particle_mean(quantity).fillna(0.0)), lay(results.mean("solids_fraction"))
    else:
        values = lay(results.mean(quantity))
    places = (ring >= 0) & np.isfinite(values) & np.isfinite(weight)

    def average(of: np.ndarray, by: np.ndarray) -> np.ndarray:
        known = places & np.isfinite(of)
        total = np.bincount(ring[known], by[known], count)
        summed = np.bincount(ring[known], (by * of)[known], count)
        return np.divide(summed, total, out=np.full(count, np.nan), where=total > 0.0)

    name, stderr = f"{quantity}_stderr", None
    if name in results.data:
        stderr = average(lay(results.error(name)), weight)
        stderr = stderr if np.isfinite(stderr).any() else None
    return RadialProfile(quantity, height, average(radius, np.ones(radius.shape)), average(values, weight), stderr)


def _find_rings(results: Results) -> tuple[np.ndarray, np.ndarray, int]:
    """Radius [m] of each place of a layer (ny, nx), the number of its ring, -1 beyond the last, and how many there are:
    as many as places across half the bed."""
    (left, front, _), (width, depth, _) = results.corner, results.size
    x = results.data["x"].values.astype(float) - left - 0.5 * width
    y = results.data["y"].values.astype(float) - front - 0.5 * depth
    radius = np.hypot(*np.meshgrid(x, y))
    outer = 0.5 * min(width, depth)
    count = max(1, min(len(x), len(y)) // 2)
    ring = np.minimum(np.floor(radius / outer * count).astype(int), count)
    return radius, np.where(ring < count, ring, -1), count
