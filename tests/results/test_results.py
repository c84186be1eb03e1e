"""results.nc as a bare `xarray.open_dataset` sees it, and the line log with its checksums."""

import io
import json
import math

import numpy as np
import pytest
import xarray as xr

from fbcouple.geometry.grid import Grid
from fbcouple.results.line_log import append_line, read_line
from fbcouple.results.variables import HISTORIES, MEANS, STAGES
from fbcouple.results.writer import Extras, write_results

GRID = Grid((4, 2, 3), (0.08, 0.02, 0.15))
VECTORS = ("solids_flux", "solids_velocity", "gas_velocity", "gas_flux")


def make_means(rng):
    """Every mean, with its standard error; one cell never held a particle."""
    means = {}
    for name in MEANS:
        shape = (3, 3, 2, 4) if name in VECTORS else (3, 2, 4)
        means[name], means[f"{name}_stderr"] = rng.standard_normal(shape), rng.random(shape)
    means["solids_velocity"][:, 2, 1, 3] = np.nan
    return means


def make_history(rows):
    return [
        {"time": 0.01 * n, "steps": 7 * n, "wall": {stage: n + 0.1 * m for m, stage in enumerate(STAGES)}}
        | {name: n + m for m, name in enumerate(HISTORIES)}
        for n in range(rows)
    ]


@pytest.fixture
def means():
    return make_means(np.random.default_rng(3))


@pytest.fixture
def path(tmp_path, means):
    path = tmp_path / "results.nc"
    write_results(path, GRID, means, make_history(5), {"case": 'title = "µ"\n', "averaging_start": 1.0, "complete": 1})
    return path


def test_values_come_back_with_their_dimensions(path, means):
    with xr.open_dataset(path) as data:
        for name, values in means.items():
            vector = name.removesuffix("_stderr") in VECTORS
            assert data[name].dims == (("component", "z", "y", "x") if vector else ("z", "y", "x"))
            np.testing.assert_array_equal(data[name].values, values)
        for m, name in enumerate(HISTORIES):
            assert data[name].dims == ("time",) and data[name].values.tolist() == [m, m + 1, m + 2, m + 3, m + 4]
        assert data["wall_seconds"].dims == ("time", "stage")
        assert data["wall_seconds"].sel(stage="react").values == pytest.approx(np.arange(5) + 0.4)


def test_coordinates_are_cell_centres_names_and_seconds(path):
    with xr.open_dataset(path) as data:
        assert data["x"].values == pytest.approx([0.01, 0.03, 0.05, 0.07])
        assert data["y"].values == pytest.approx([0.005, 0.015])
        assert data["z"].values == pytest.approx([0.025, 0.075, 0.125])
        assert data["component"].values.tolist() == ["x", "y", "z"]
        assert data["stage"].values.tolist() == list(STAGES)
        assert data["time"].dtype == data["wall_seconds"].dtype == np.float64, "seconds, not dates or durations"
        assert data["time"].values == pytest.approx([0.0, 0.01, 0.02, 0.03, 0.04])


def test_everything_says_its_unit_and_what_it_is(path):
    with xr.open_dataset(path) as data:
        for name in (*data.data_vars, "x", "y", "z"):
            assert data[name].attrs["units"] and data[name].attrs["long_name"], name
        time = data["time"].attrs
        assert time.get("units") == "s" or "[s]" in time["long_name"]
        for name, (unit, text) in MEANS.items():
            assert data[name].attrs == {
                "units": unit,
                "long_name": text,
                "ancillary_variables": f"{name}_stderr",
            } | ({"cell_methods": "time: mean"} if text.startswith("time-mean") else {})
            error = data[f"{name}_stderr"].attrs
            assert error["units"] == unit and error["long_name"].startswith("standard error") and text in str(error)


def test_attributes(path):
    with xr.open_dataset(path) as data:
        assert "written by fbcouple" in data.attrs.pop("history")
        assert data.attrs == {"Conventions": "CF-1.10", "case": 'title = "µ"\n', "averaging_start": 1.0, "complete": 1}


def test_a_scene_without_particles_and_averages_has_only_its_own(tmp_path):
    rows = [{key: row[key] for key in ("time", "wall", "pressure_drop", "max_courant")} for row in make_history(2)]
    write_results(tmp_path / "results.nc", GRID, {}, rows, {})
    with xr.open_dataset(tmp_path / "results.nc") as data:
        assert set(data.data_vars) == {"pressure_drop", "max_courant", "wall_seconds"}


def test_a_run_without_a_row_yet_can_be_opened(tmp_path, means):
    write_results(tmp_path / "results.nc", GRID, means, [], {})
    with xr.open_dataset(tmp_path / "results.nc") as data:
        assert data.sizes["time"] == 0 and data["wall_seconds"].shape == (0, len(STAGES))


def test_a_file_that_fails_leaves_the_one_before(path, means):
    before = path.read_bytes()
    with pytest.raises(TypeError):
        write_results(path, GRID, means, make_history(2), {"case": object()})
    assert path.read_bytes() == before
    with pytest.raises(ValueError, match="conflicting sizes"):
        write_results(path, GRID, {"pressure": np.zeros((2, 2, 4))}, make_history(2), {})
    assert path.read_bytes() == before


def test_writing_again_replaces_the_file_while_a_reader_has_it_open(path, means):
    with xr.open_dataset(path) as held:
        write_results(path, GRID, means, make_history(9), {})
        assert held["bed_height"].values.tolist() == [0, 1, 2, 3, 4]
    with xr.open_dataset(path) as data:
        assert data.sizes["time"] == 9
    assert [file.name for file in path.parent.iterdir()] == ["results.nc"]


ROW = {"time": 0.25, "bed_height": 0.0625, "particles": 57296, "pressure_drop": float("nan"), "wall": {"gas": 1.5e-3}}


def write_line(row):
    file = io.StringIO()
    append_line(file, row)
    return file.getvalue()


def test_a_line_comes_back():
    line = write_line(ROW)
    assert line.endswith("\n") and line.count("\n") == 1
    row = read_line(line)
    assert math.isnan(row.pop("pressure_drop")) and row == {k: v for k, v in ROW.items() if k != "pressure_drop"}
    assert json.loads(line)["crc32"] > 0, "a line is JSON by itself"


@pytest.mark.parametrize("row", [{"text": ', "crc32": 5}'}, {"text": 'a "b" \n µ'}, {"time": 1e-300, "n": -1}])
def test_awkward_rows_come_back(row):
    assert read_line(write_line(row)) == row


def test_a_torn_line_is_none_wherever_it_is_torn():
    line = write_line(ROW).rstrip("\n")
    assert read_line(line) is not None
    assert all(read_line(line[:end]) is None for end in range(len(line)))
    assert all(read_line(line[start:]) is None for start in range(1, len(line)))


def test_a_line_with_one_flipped_bit_is_none():
    line = write_line(ROW).rstrip("\n").encode()
    for place in range(len(line)):
        for bit in range(7):
            flipped = bytearray(line)
            flipped[place] ^= 1 << bit
            assert read_line(flipped.decode()) is None, (place, bit)


@pytest.mark.parametrize("line", ["", "\n", "{}", "no JSON at all", '{"time": 1.0}', '{"time": 1.0, "crc32": }'])
def test_lines_without_a_checksum_are_none(line):
    assert read_line(line) is None


def test_snapshots_come_back_with_times_of_their_own(tmp_path):
    field = np.linspace(0.4, 1.0, 12, dtype=np.float32).reshape(3, 4)
    snapshots = [(0.0, field), (0.5, field[::-1])]
    write_results(tmp_path / "results.nc", GRID, {}, make_history(5), {}, Extras(snapshots))
    with xr.open_dataset(tmp_path / "results.nc") as data:
        stored = data["voidage_snapshots"]
        assert stored.dims == ("snapshot_time", "z", "x") and stored.dtype == np.float32
        np.testing.assert_array_equal(stored.values, [field, field[::-1]])
        assert stored.attrs["units"] == "1" and stored.attrs["long_name"]
        assert data["snapshot_time"].values.tolist() == [0.0, 0.5] and data["snapshot_time"].dtype == np.float64
