"""Time means over the depth of the bed, all of it or a part, and at a height."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fbcouple.results.conventions import STANDARD_ERROR
from fbcouple.results.reader import NotDrawableError, Results

_ROUNDING = 1e-9
"""Part of a cell that is none."""


def depth_average(field: xr.DataArray, shares: xr.DataArray | None = None) -> xr.DataArray:
    """Mean over y, the paper's <.>_xz; cells are of one size, of which `shares` (y,) count, all of each if absent. Of a
    mesh the mean over what is inside of it.

    For a standard error this is the bound that holds if the errors along the depth are fully correlated.
    """
    if "inside" not in field.coords and shares is None:
        return field.mean("y", skipna=False)
    counted = (field["inside"] if "inside" in field.coords else xr.ones_like(field, bool)) * _fill_shares(shares)
    total = (field.where(counted > 0.0, 0.0) * counted).sum("y", skipna=False)
    count = counted.sum("y")
    return total / count.where(count > 0)


def mass_average(results: Results, name: str, shares: xr.DataArray | None = None) -> xr.DataArray:
    """Mean over y of a particle quantity, or of its standard errors, weighted with the solids, of each cell its part of
    `shares` (y,); nan where no particle ever came. Of errors it is the bound that `depth_average` has."""
    values = results.error(name) if name.endswith(STANDARD_ERROR) else results.particle_mean(name)
    weight = results.mean("solids_fraction") * _fill_shares(shares)
    total = weight.sum("y")
    return (weight * values.where(weight > 0.0, 0.0)).sum("y") / total.where(total > 0.0)


def _fill_shares(shares: xr.DataArray | None) -> xr.DataArray | float:
    return 1.0 if shares is None else shares


def share_depth(results: Results, depth: tuple[float, float]) -> xr.DataArray:
    """The part of each cell of the row over the depth that lies between y = depth[0] and depth[1] [m]; shape (ny,)."""
    y = results.data["y"]
    half = 0.5 * results.size[1] / y.size
    upper, lower = np.minimum(y.values + half, depth[1]), np.maximum(y.values - half, depth[0])
    shares = np.clip((upper - lower) / (2.0 * half), 0.0, 1.0)
    return y.copy(data=np.where(shares > _ROUNDING, shares, 0.0)).reset_coords(drop=True)


def at_height(field: xr.DataArray, height: float) -> xr.DataArray:
    """Interpolate `field` linearly in z to `height` [m], between the centres of two layers of cells.

    Raises: NotDrawableError if the height is not between two centres, for nothing is extrapolated.
    """
    z = field["z"].values.astype(float)
    if z.size < 2 or not z[0] <= height <= z[-1]:
        told = f"height z = {height:g} m is outside the cell centres ({z[0]:g} to {z[-1]:g} m)"
        raise NotDrawableError([f"{told}; give a height between them, or use a finer mesh in z."])
    upper = min(max(int(np.searchsorted(z, height)), 1), z.size - 1)
    weight = (height - z[upper - 1]) / (z[upper] - z[upper - 1])
    return (1.0 - weight) * field.isel(z=upper - 1, drop=True) + weight * field.isel(z=upper, drop=True)
