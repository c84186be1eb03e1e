"""Maps of the mean temperatures of gas and particles."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from fbcouple.postproc.averaging import averaging_text
from fbcouple.postproc.figures.layout import Panel, draw_panels
from fbcouple.postproc.figures.maps import HARDLY_ANY
from fbcouple.postproc.figures.registry import figure
from fbcouple.results.depth_means import depth_average, mass_average
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results

_LEAST = 1e-3
"""Range of the scale [K] where all is at one temperature."""


@figure
def temperature(results: Results) -> Figure:
    """Maps of the time-mean temperatures of gas, weighted by voidage, and particles, by mass; grey where there are
    hardly any particles."""
    fields = {name: find(results) for name, find in _FIELDS.items() if f"{name}_temperature" in results.data}
    if not fields:
        raise NotMeantError([f"{results.path} has no mean temperatures."])
    values = np.concatenate([field.values.ravel() for field in fields.values()])
    if not np.isfinite(values).any():
        raise NotDrawableError([f"{results.path} has mean temperatures nowhere: no particles were there."])
    panels = [Panel(results, field, _TITLES[name], None) for name, field in fields.items()]
    least, largest = float(np.nanmin(values)), float(np.nanmax(values))
    empty = f"hardly any particles, solids fraction below {HARDLY_ANY:g}"
    limits = least, max(largest, least + _LEAST)
    return draw_panels(
        panels, results.title, averaging_text(results), "Temperature [K]", limits, cmap="plasma", empty=empty
    )


def _average_gas(results: Results) -> xr.DataArray:
    values = results.mean("gas_temperature")
    if "voidage" not in results.data:
        return depth_average(values)
    voidage = results.mean("voidage")
    return depth_average(voidage * values) / depth_average(voidage)


def _average_solids(results: Results) -> xr.DataArray:
    solids = depth_average(results.mean("solids_fraction"))
    return mass_average(results, "solids_temperature").where(solids >= HARDLY_ANY)


_FIELDS = {"gas": _average_gas, "solids": _average_solids}
_TITLES = {"gas": "Gas", "solids": "Particles"}
