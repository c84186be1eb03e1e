"""What time means are averages over, beside the samples: a mean of several of them counts each with that."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

OF_MASS = ("solids_velocity", "solids_temperature")
OF_SOLIDS = ("agitation", "granular_temperature")
OF_VOIDAGE = ("gas_temperature",)
OF_PARTICLES = OF_MASS + OF_SOLIDS
"""Means that have no value where no particle ever came."""


def find_weight(data: xr.Dataset, case: Mapping[str, Any], name: str) -> xr.DataArray | None:
    """What a place counts in the mean `name` of the results `data` of a `case`, 0 where there is nothing: the mass of
    its particles [kg m-3], their solids fraction, or the voidage; None where a place counts as any other."""
    if name in OF_VOIDAGE and "voidage" in data:
        return data["voidage"].astype(float).fillna(0.0)
    if name not in OF_PARTICLES:
        return None
    solids = data["solids_fraction"].astype(float).fillna(0.0)
    return _find_mass(data, solids, case) if name in OF_MASS and "solids_flux" in data else solids


def _find_mass(data: xr.Dataset, solids: xr.DataArray, case: Mapping[str, Any]) -> xr.DataArray:
    """Flux over velocity; where nothing moves the solids times the density of the case."""
    velocity, flux = (data[name].astype(float).fillna(0.0) for name in ("solids_velocity", "solids_flux"))
    squares = (velocity**2).sum("component")
    along = (velocity * flux).sum("component").transpose(*squares.dims)
    still = (float(case["particles"]["density"]) * solids).transpose(*squares.dims)
    mass = np.divide(along.values, squares.values, out=still.values.copy(), where=squares.values > 0.0)
    return still.copy(data=mass)
