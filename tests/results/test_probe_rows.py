"""Rows of probes on the disk, and their way into results.nc."""

import tracemalloc

import numpy as np
import pytest
import xarray as xr

from fbcouple.geometry.grid import Grid
from fbcouple.results.probes import COPIED, ProbeSet, Rows, count_columns, read_probes
from fbcouple.results.writer import Extras, write_results

GRID = Grid((1, 1, 1), (1.0, 1.0, 1.0))
POINTS = np.array([[0.01, 0.0, 0.02], [0.01, 0.0, 0.05]])
QUANTITIES = ("pressure", "gas_velocity")
CASE = {"output": {"probes": [{"name": "tap", "points": POINTS.tolist(), "quantities": list(QUANTITIES)}]}}


def open_rows(folder):
    return Rows(folder / "probes/tap.rows", len(POINTS) * count_columns(QUANTITIES))


def make_values(number):
    """Pressure of both points, then the velocities of both."""
    return np.array([100.0, 200.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]) + number


def write(path, rows):
    write_results(
        path,
        GRID,
        {},
        [],
        {},
        extras=Extras(probes=[ProbeSet("tap", POINTS, QUANTITIES, rows)]),
    )
    with xr.open_dataset(path) as data:
        return data.load()


def test_rows_come_back_with_their_dimensions_units_and_places(tmp_path):
    rows = open_rows(tmp_path)
    for number in range(5):
        rows.append(0.1 * number, make_values(number))
    data = write(tmp_path / "results.nc", rows)
    pressure, velocity = data["probe_tap_pressure"], data["probe_tap_gas_velocity"]
    assert pressure.dims == ("probe_tap_time", "probe_tap_point")
    assert velocity.dims == (*pressure.dims, "component")
    assert pressure.values[3].tolist() == [103.0, 203.0] and velocity.values[3].tolist() == [[4, 5, 6], [7, 8, 9]]
    assert data["probe_tap_time"].values.tolist() == [0.1 * number for number in range(5)]
    assert pressure["probe_tap_z"].values.tolist() == [0.02, 0.05], "places are coordinates"
    assert {data[name].attrs["units"] for name in ("probe_tap_time", "probe_tap_pressure")} == {"s", "Pa"}
    assert all(field.attrs["long_name"] for name, field in data.variables.items() if name.startswith("probe_"))
    (found,) = read_probes(data, CASE)
    assert (found.points == POINTS).all() and not found.is_line and list(found.values) == list(QUANTITIES)


def test_a_set_without_a_sample_yet_can_be_opened(tmp_path):
    data = write(tmp_path / "results.nc", open_rows(tmp_path))
    assert data["probe_tap_gas_velocity"].shape == (0, 2, 3)
    assert read_probes(data, CASE)[0].times.size == 0


def test_a_run_that_goes_on_removes_what_came_after_its_checkpoint(tmp_path):
    rows = open_rows(tmp_path)
    for number in range(9):
        rows.append(0.1 * number, make_values(number))
        if number == 4:
            count, checksum = rows.count, rows.checksum
    with rows.path.open("ab") as file:
        file.write(b"half of a row")
    other = open_rows(tmp_path)
    other.count, other.checksum = count, checksum
    assert other.is_whole()
    other.append(7.0, make_values(7))
    found = np.concatenate(list(other.read()))
    assert found[:, 0] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4, 7.0]) and other.is_whole()
    assert rows.path.stat().st_size == 6 * 9 * 8


def test_a_run_from_the_start_removes_what_an_earlier_one_left(tmp_path):
    first = open_rows(tmp_path)
    first.append(0.0, make_values(0))
    other = open_rows(tmp_path)
    other.append(0.5, make_values(1))
    assert np.concatenate(list(other.read()))[:, 0].tolist() == [0.5]


@pytest.mark.parametrize("damage", ["cut", "other", "gone"])
def test_rows_that_are_not_those_of_the_checkpoint_are_seen(tmp_path, damage):
    rows = open_rows(tmp_path)
    for number in range(3):
        rows.append(0.1 * number, make_values(number))
    data = rows.path.read_bytes()
    rows.path.write_bytes({"cut": data[:-8], "other": data[:-1] + b"\x00", "gone": data}[damage])
    if damage == "gone":
        rows.path.unlink()
    assert not rows.is_whole()


def test_memory_does_not_grow_with_the_samples(tmp_path):
    """16 MB of rows: neither writing them nor copying them into results.nc holds more than some blocks."""
    columns = 1023
    rows = Rows(tmp_path / "probes/tap.rows", columns)
    values = np.linspace(0.0, 1.0, columns)
    tracemalloc.start()
    for number in range(2000):
        rows.append(float(number), values)
    appended = tracemalloc.get_traced_memory()[1]
    tracemalloc.reset_peak()
    points = np.zeros((columns, 3))
    probes = [ProbeSet("tap", points, ("pressure",), rows)]
    write_results(tmp_path / "results.nc", GRID, {}, [], {}, Extras(probes=probes))
    copied = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    size = rows.path.stat().st_size
    print(f"{size / 1e6:.1f} MB of rows: {appended / 1e6:.2f} MB while written, {copied / 1e6:.2f} MB while copied")
    assert size > 15 * COPIED and appended < 0.2 * COPIED and copied < 4 * COPIED
