"""The data behind the figures of the page: maps as a Dataset, lines as rows of a table, a name of its run at each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from fbcouple.postproc.figures.depth import cut_moment, depth_lines
from fbcouple.postproc.figures.profiles import vertical_flux
from fbcouple.postproc.figures.snapshots import choose_snapshots
from fbcouple.postproc.scales import flux_scale, velocity_scale
from fbcouple.results.depth_means import depth_average, mass_average
from fbcouple.results.reader import Results
from fbcouple.results.view import View

Rows = list[dict[str, Any]]
Data = xr.Dataset | Rows
MOST_DIGITS = 5
"""Significant digits of maps, far below their errors."""


def _put_together(runs: Sequence[Results], collect: Callable[[Results], dict[str, xr.DataArray]]) -> xr.Dataset:
    """A variable QUANTITY_RUN each, float32 on (z, x) of the cells of its own mesh, dimensionless axes z/H and x/L."""
    found = {}
    for run in runs:
        names = {axis: f"{axis}{run.data.sizes[axis]}" for axis in "zx"}
        for name, values in collect(run).items():
            plain = values.transpose("z", "x").values
            place = {
                names[axis]: (names[axis], run.share(axis), {"long_name": f"{axis} over its length"}) for axis in "zx"
            }
            about = {"run": run.label, "units": str(values.attrs.get("units", "1"))}
            field = xr.DataArray(_round(plain), dims=tuple(names.values()), coords=place, attrs=about)
            found[_name(f"{name}_{run.label}")] = field
    return xr.Dataset(found)


def _round(values: np.ndarray) -> np.ndarray:
    """The same to `MOST_DIGITS` of the largest, which packs well."""
    top = float(np.nanmax(np.abs(values))) if np.isfinite(values).any() else 0.0
    decimals = MOST_DIGITS - int(np.floor(np.log10(top))) - 1 if top > 0.0 else 0
    return np.round(values, decimals).astype(np.float32)


def _name(text: str) -> str:
    """A name of a variable: letters, digits and lines below."""
    return "".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in text).strip("_")


def collect_fractions(runs: Sequence[Results]) -> Data:
    """Depth-averaged time-mean solids fraction and its standard error."""

    def collect(run: Results) -> dict[str, xr.DataArray]:
        names = ("solids_fraction", "solids_fraction_stderr")
        return {name: depth_average(run.error(name) if "stderr" in name else run.mean(name)) for name in names}

    return _put_together(runs, collect)


def collect_fluxes(runs: Sequence[Results]) -> Data:
    """Depth-averaged time-mean solids flux over rho U_f, along x and z, and its standard errors."""

    def collect(run: Results) -> dict[str, xr.DataArray]:
        fields = {"solids_flux": run.mean("solids_flux"), "solids_flux_stderr": run.error("solids_flux_stderr")}
        scale = flux_scale(run)[0]
        return {
            f"{name}_{axis}": depth_average(values.sel(component=axis, drop=True)) / scale
            for name, values in fields.items()
            for axis in "xz"
        }

    return _put_together(runs, collect)


def collect_agitations(runs: Sequence[Results]) -> Data:
    """Time-mean agitation over U_f^2, mass weighted over the depth."""
    return _put_together(runs, lambda run: {"agitation": mass_average(run, "agitation") / velocity_scale(run)[0] ** 2})


def collect_snapshots(runs: Sequence[Results]) -> Data:
    """Depth-averaged voidage at the moments shown."""
    return _put_together(
        runs,
        lambda run: {
            f"voidage_at_{1e3 * float(each['snapshot_time']):.0f}_ms": each.drop_vars("snapshot_time")
            for each in choose_snapshots(run)
        },
    )


def collect_slices(runs: Sequence[Results]) -> Data:
    """Solids fraction on slices along the depth at one moment."""
    time, cuts = cut_moment(runs[0])
    return _put_together(runs[:1], lambda run: {f"{name} at {1e3 * time:.0f} ms": cut for name, cut in cuts})


def collect_profiles(runs: Sequence[Results], height: float) -> Data:
    """Vertical solids flux over rho U_f across the bed `height` [m] above the floor."""
    rows = []
    for run in runs:
        found = vertical_flux(run, height)
        errors = np.full_like(found.value, np.nan) if found.stderr is None else found.stderr
        for place, value, error in zip(found.position, found.value, errors, strict=True):
            rows.append({"run": run.label, "x/L": place, "flux over rho U_f": value, "standard error": error})
    return rows


def collect_depth(runs: Sequence[Results], height: float) -> Data:
    """Mean vertical velocity of the solids over U_f along the depth, at places across the bed."""
    rows = []
    for run in runs:
        share = run.share("y")
        for place, line in depth_lines(replace(run, view=View((height,)))).items():
            for y, value in zip(share, line, strict=True):
                rows.append({"run": run.label, "x/L": place, "y/D": y, "velocity over U_f": value})
    return rows
