"""Tables of a run for a spreadsheet: history, probes and radial profiles as CSV, with units in their heads."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path

import numpy as np
import xarray as xr

from fbcouple.paths import find_home
from fbcouple.postproc.files import write_whole
from fbcouple.postproc.radial import QUANTITIES, list_radial_heights, list_radial_profiles
from fbcouple.results.probes import PROBED, VECTORS, list_tables, name_variable
from fbcouple.results.reader import NotDrawableError, Results, open_results

FOLDER = "tables"
_ROWS = 4096
"""Samples that are read at a time."""

Table = tuple[list[str], Iterable[Sequence[float]]]


def export_tables(run: Path, folder: Path | None = None) -> list[Path]:
    """Write `folder`, by default RUN/tables: history.csv, probe_NAME.csv of each set of probes, radial_profiles.csv of
    a column. Columns are in SI units, which their heads name; what is not known is left empty.

    Returns: the files. Raises: CaseError if there are no results, or a file cannot be written.
    """
    results = open_results(run)
    folder = folder or find_home(Path(run)) / FOLDER
    files = []
    for name, (heads, rows) in _list_tables(results):
        path = folder / f"{name}.csv"
        files.append(write_whole(path, _writer(heads, rows)))
    return files


def _list_tables(results: Results) -> Iterator[tuple[str, Table]]:
    if results.data.sizes.get("time"):
        yield "history", _tabulate_history(results.data)
    for table in list_tables(results.case):
        name = table["name"]
        if results.data.sizes.get(name_variable(name, "time")):
            yield f"probe_{name}", _tabulate_probes(results.data, name, table["quantities"])
    try:
        heights = list_radial_heights(results)
        yield "radial_profiles", _tabulate_radial(results, heights)
    except NotDrawableError:
        return  # it is no column, or has no means yet


def _writer(heads: list[str], rows: Iterable[Sequence[float]]) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        with path.open("w", encoding="utf-8", newline="") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(heads)
            table.writerows([_show(value) for value in row] for row in rows)

    return write


def _show(value: float) -> str:
    """A number with the digits that it has, and nothing where there is none."""
    return repr(float(value)) if np.isfinite(value) else ""


def _head(name: str, unit: str) -> str:
    return f"{name} [{unit if unit != '1' else '-'}]"


def _tabulate_history(data: xr.Dataset) -> Table:
    """Every history that is one number a row."""
    names = [
        str(name) for name, field in data.data_vars.items() if field.dims == ("time",) and field.dtype.kind in "iuf"
    ]
    heads = ["time [s]", *(_head(name, str(data[name].attrs.get("units", "1"))) for name in names)]
    return heads, np.column_stack([data["time"].values, *(data[name].values for name in names)])


def _tabulate_probes(data: xr.Dataset, name: str, quantities: Sequence[str]) -> Table:
    """A row a sample; the columns of a quantity are its points, of a vector x, y and z of each point."""
    points = np.column_stack([data[name_variable(name, axis)].values for axis in "xyz"])
    places = [f"x={x:.6g} y={y:.6g} z={z:.6g} m" for x, y, z in points.tolist()]
    heads = ["time [s]"]
    for quantity in quantities:
        parts = [f"{quantity}_{axis}" for axis in "xyz"] if quantity in VECTORS else [quantity]
        heads += [_head(f"{part} at {place}", PROBED[quantity][0]) for place in places for part in parts]
    time = name_variable(name, "time")

    def read() -> Iterator[np.ndarray]:
        for start in range(0, data.sizes[time], _ROWS):
            some = data.isel({time: slice(start, start + _ROWS)})
            columns = [some[name_variable(name, quantity)].values for quantity in quantities]
            count = some.sizes[time]
            yield np.column_stack([some[time].values, *(values.reshape(count, -1) for values in columns)])

    return heads, chain.from_iterable(read())


def _tabulate_radial(results: Results, heights: Sequence[float]) -> Table:
    """A row a ring and height, a column a quantity and one its standard error."""
    found = list_radial_profiles(results, heights)
    heads, columns = ["height [m]", "radius [m]"], []
    first = next(iter(found.values()))
    columns.append(np.concatenate([np.full(len(one.radius), one.height) for one in first]))
    columns.append(np.concatenate([one.radius for one in first]))
    for quantity, profiles in found.items():
        heads.append(_head(quantity, QUANTITIES[quantity]))
        columns.append(np.concatenate([one.value for one in profiles]))
        if any(one.stderr is not None for one in profiles):
            heads.append(_head(f"{quantity} standard error", QUANTITIES[quantity]))
            unknown = [np.full(len(one.radius), np.nan) if one.stderr is None else one.stderr for one in profiles]
            columns.append(np.concatenate(unknown))
    return heads, np.column_stack(columns)
