"""results.nc and the CF conventions, by what a checker of them looks at; read with netCDF4, which adds nothing."""

from __future__ import annotations

import re
from datetime import UTC, datetime

import numpy as np
import pytest
import xarray as xr
from netCDF4 import Dataset

import fbcouple
from fbcouple.geometry.grid import Grid
from fbcouple.results.conventions import follow_conventions
from fbcouple.results.variables import HISTORIES, MEANS, STAGES
from fbcouple.results.writer import Extras, write_results

UNITS = {"1", "s", "m", "m3", "J", "Pa", "m s-1", "m2 s-2", "kg m-2 s-1", "kg", "kg m s-1", "K", "W"}
METHODS = {"time: mean", "time: maximum", "time: sum"}
VECTORS = ("solids_flux", "solids_velocity", "gas_velocity", "gas_flux")


@pytest.fixture
def stored(tmp_path):
    grid = Grid((4, 2, 3), (0.04, 0.02, 0.06))
    means = {}
    for name in MEANS:
        shape = (3, 3, 2, 4) if name in VECTORS else (3, 2, 4)
        means |= {name: np.ones(shape), f"{name}_stderr": np.full(shape, np.nan)}
    same = {"wall": dict.fromkeys(STAGES, 0.5), "tracked": {"1": [0.0] * 6}} | dict.fromkeys(HISTORIES, 1.0)
    rows = [same | {"time": 0.1 * n} for n in range(3)]
    snapshots = [(0.1, np.ones((3, 4))), (0.2, np.ones((3, 4)))]
    about = {"title": "a bed", "source": "fbcouple 0.1.0"}
    write_results(tmp_path / "results.nc", grid, means, rows, about, Extras(snapshots))
    with Dataset(tmp_path / "results.nc") as data:
        yield data


def test_global_attributes(stored):
    for name in ("Conventions", "title", "history", "source"):
        assert isinstance(stored.getncattr(name), str) and stored.getncattr(name).strip(), name
    assert stored.Conventions == "CF-1.10"
    moment, _, words = stored.history.partition(" ")
    assert abs((datetime.now(UTC) - datetime.fromisoformat(moment)).total_seconds()) < 600
    assert words == f"written by fbcouple {fbcouple.__version__}"


def test_coordinates_have_no_missing_data(stored):
    coordinates = [name for name in stored.variables if name in stored.dimensions]
    assert {"x", "y", "z", "time", "snapshot_time", "stage", "component", "tracked"} == set(coordinates)
    for name in coordinates:
        assert not {"_FillValue", "missing_value"} & set(stored[name].ncattrs()), name
        values = stored[name][:]
        assert stored[name].dtype == "S1" or np.all(np.diff(values) > 0.0), name


def test_labels_are_rows_of_letters_and_read_as_texts(stored):
    """The conventions know no coordinate of strings; two checkers of them end in an error at one."""
    assert stored["stage"].dimensions == ("stage", "stage_letters")
    with xr.open_dataset(stored.filepath()) as data:
        assert data["stage"].values.tolist() == list(STAGES)
        assert data["wall_seconds"].sel(stage="cfd").values.tolist() == [0.5] * 3
        assert data["solids_flux"].sel(component="z").shape == (3, 2, 4)


def test_names_and_attributes_are_those_that_cf_allows(stored):
    for name, variable in stored.variables.items():
        for word in (name, *variable.ncattrs()):
            assert re.fullmatch(r"_?[A-Za-z]\w*", word), word
        assert "long_name" in variable.ncattrs(), name
        if variable.dtype != "S1" and name != "tracked":
            assert variable.units in UNITS, name
        assert "axis" not in variable.ncattrs() and "standard_name" not in variable.ncattrs()


def test_means_name_their_method_and_their_error(stored):
    for name, (_, text) in MEANS.items():
        method = getattr(stored[name], "cell_methods", None)
        assert method == ("time: mean" if text.startswith("time-mean") else None), name
        assert stored[name].ancillary_variables == f"{name}_stderr"
        error = stored[f"{name}_stderr"]
        assert error.units == stored[name].units and error.dimensions == stored[name].dimensions
        assert "cell_methods" not in error.ncattrs()


def test_histories_name_what_happened_since_the_row_before(stored):
    methods = {name: getattr(stored[name], "cell_methods", None) for name in HISTORIES}
    assert methods["pressure_drop"] == methods["gas_support"] == "time: mean"
    assert methods["momentum_error"] == methods["max_courant"] == methods["gas_flux_error"] == "time: maximum"
    assert methods["bed_height"] is None and methods["kinetic_energy"] is None
    assert stored["wall_seconds"].cell_methods == "time: sum"
    assert set(methods.values()) <= METHODS | {None}


def test_what_a_file_says_itself_stays():
    data = xr.Dataset(attrs={"history": "mine", "Conventions": "CF-1.8"})
    assert follow_conventions(data).attrs == {"history": "mine", "Conventions": "CF-1.8"}
    moment = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
    assert follow_conventions(xr.Dataset(), moment).attrs["history"].startswith("2026-01-02T03:04:05Z written by")
