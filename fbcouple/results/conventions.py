"""What the CF conventions (1.10) ask of a netCDF file, put on a dataset before it is written."""

from __future__ import annotations

import re
from collections.abc import Hashable
from datetime import UTC, datetime
from typing import Any

import xarray as xr

from fbcouple.version import __version__

CONVENTIONS = "CF-1.10"
STANDARD_ERROR = "_stderr"
"""End of the names of standard errors, each beside what it is the error of."""
_METHODS = (
    (r"^time-mean|mean since the last row|mean over each block", "time: mean"),
    (r"largest .*since the last row|farthest off", "time: maximum"),
    (r"wall time of .* since the last row", "time: sum"),
)
"""What a long name says -> the cell method."""


def follow_conventions(dataset: xr.Dataset, now: datetime | None = None) -> xr.Dataset:
    """Return `dataset` with the global attributes `Conventions` and `history`, the cell methods of its means, and at
    each mean the name of its standard error.

    Means over time have no time axis of their own: their cell methods name time by its standard name. The
    coordinates get no standard names and axes: time is in s since the start of the run and not since a date, and x and
    y are no longitude and latitude.

    now: time of writing, for `history`; None: this moment.
    """
    moment = (now or datetime.now(UTC)).strftime("%Y-%m-%dT%H:%M:%SZ")
    attributes = {"Conventions": CONVENTIONS, "history": f"{moment} written by fbcouple {__version__}"}
    marked = dataset.assign_attrs(attributes | dataset.attrs)
    for name in marked.variables:
        marked[name].attrs |= _describe(name, marked)
    return marked


def _describe(name: Hashable, dataset: xr.Dataset) -> dict[str, Any]:
    """The attributes that the variable `name` gets."""
    attributes: dict[str, Any] = {}
    words = str(dataset[name].attrs.get("long_name", ""))
    for pattern, method in _METHODS:
        if re.search(pattern, words):
            attributes["cell_methods"] = method
            break
    if f"{name}{STANDARD_ERROR}" in dataset:
        attributes["ancillary_variables"] = f"{name}{STANDARD_ERROR}"
    return attributes


def encode_coordinates(dataset: xr.Dataset, encoding: dict[str, Any]) -> dict[str, Any]:
    """Return `encoding` with no fill value for coordinates, which have no missing data, and with labels as rows of
    letters, as a coordinate variable of the conventions is a number. xarray reads them as texts again."""
    found = dict(encoding)
    for name in map(str, dataset.coords):
        is_label = dataset[name].dtype.kind in "UO"
        letters = {"dtype": "S1", "char_dim_name": f"{name}_letters"} if is_label else {"_FillValue": None}
        found[name] = found.get(name, {}) | letters
    return found
