"""Rules of histories: every one has its own, and no pool or reduced file hides what a monitor would tell of a run."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.results.histories import RULES, STATE, Join, count_lost, find_rule, find_worst, join_rows
from fbcouple.results.pools import write_pool
from fbcouple.results.reader import open_results
from fbcouple.results.variables import HISTORIES, HISTORIES_OF_OUTLETS, HISTORIES_OF_SPECIES, HISTORY_VECTORS

sys.path.append(str(Path(__file__).parents[1] / "postproc"))
from whole_run import write_whole

ROW = 777
"""A row in the midst of those that a reduced file joins."""
SPOILT = {
    "ledger_error": 0.25,
    "momentum_error": 0.5,
    "gas_mass_error": 0.5,
    "gas_inflow_error": 0.5,
    "displaced_gas_error": 0.75,
    "gas_flux_error": 0.125,
    "gas_backflow": 0.5,
    "particles_at_outlet": 7.0,
    "max_courant": 3.0,
    "min_voidage": 0.125,
    "cells_over_packed": 9.0,
    "max_overlap": 0.25,
    "heat_error": 0.5,
    "solids_volume": 3e-5 * (1.0 + 1e-9),
}
"""Values of one row that are beyond what is wanted."""


def test_every_history_that_a_run_writes_has_a_rule():
    written = {*HISTORIES, *HISTORY_VECTORS, *HISTORIES_OF_SPECIES, *HISTORIES_OF_OUTLETS, "wall_seconds"}
    assert set(RULES) == written
    watched = {name for name in MONITORS if name in RULES and RULES[name].replicas is None}
    assert watched == {"particles", "pressure_drop"}  # counted of each replica, and the mean over their windows


def test_joined_rows():
    rows, begins = np.array([5.0, 1.0, np.nan, 9.0, 4.0]), np.array([0, 1, 4])
    expected = {"last": [5, 9, 4], "largest": [5, 9, 4], "least": [5, 1, 4], "farthest": [5, 1, 4]}
    for how, values in expected.items():
        assert join_rows(Join(how), rows, begins, np.array(5.5)).tolist() == values
    flows = np.arange(10.0).reshape(5, 2)
    assert join_rows(Join.SUM, flows, begins, flows[0]).tolist() == [[0, 1], [12, 15], [8, 9]]
    assert join_rows(Join.MEAN, flows, begins, flows[0]).tolist() == [[0, 1], [4, 5], [8, 9]]


def test_volume_of_particles_that_come_and_go_is_a_state():
    assert find_rule("solids_volume", xr.Dataset({"particles_fed": ("time", [0.0])})) is STATE


def test_lost_particles_are_not_told_of_a_count_with_a_hole():
    count = np.array([60.0, 59.0, 58.0])
    data = xr.Dataset({"particles": ("time", count), "particles_fed": ("time", 0.0 * count)}, {"time": [0.0, 1.0, 2.0]})
    assert count_lost(data) == 2.0
    assert count_lost(data.assign(particles_removed=("time", [0.0, 1.0, 2.0]))) == 0.0
    assert count_lost(data.assign(particles=("time", [60.0, 59.0, np.nan]))) is None
    assert count_lost(data.isel(time=slice(0, 0))) is None


def lay_out(times, **histories):
    return xr.Dataset({name: ("time", np.array(rows)) for name, rows in histories.items()}, {"time": times})


def test_the_worst_of_replicas_with_other_rows():
    """The second one ends earlier, and has what the first does not watch."""
    first = lay_out([0.0, 1.0, 2.0, 3.0], max_overlap=[0.0, 0.2, 0.1, 0.1], particles_owed=[0.0, 5.0, 0.0, 0.0])
    other = lay_out(
        [0.0, 0.5, 0.9, 2.5],
        max_overlap=[0.0, 0.1, 0.3, 0.2],
        particles_owed=[0.0, 9.0, 1.0, 3.0],
        gas_backflow=[0.0, 0.1, 0.0, 0.2],
    )
    found = {name: values.tolist() for name, (_, values, _) in find_worst([first, other]).items()}
    assert found["max_overlap"] == [0.0, 0.3, 0.1, 0.2]
    assert found["particles_owed"] == [0.0, 5.0, 1.0, 3.0]
    assert found["gas_backflow"] == pytest.approx([0.0, 0.1, np.nan, 0.2], nan_ok=True)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A run as it should be, and one with a row that is wrong in all that is watched, and particles lost."""
    folder = tmp_path_factory.mktemp("watched")
    made = []
    for seed, name in enumerate(("good", "bad"), start=1):
        run = write_whole(folder / name)
        data = xr.open_dataset(run / "results.nc", decode_times=False).load()
        data.close()
        rows = data.sizes["time"]
        values = {key: data[key].values.astype(float) if key in data else np.zeros(rows) for key in SPOILT}
        parts, lost = np.zeros((rows, 2)), np.full(rows, 57296.0)
        if name == "bad":
            for key, value in SPOILT.items():
                values[key][ROW] = value
            parts[ROW], lost[ROW:] = [0.25, 0.5], 57290.0
        data = data.assign({key: ("time", rows) for key, rows in values.items()})
        data = data.assign(outlet_backflow=(("time", "outlet"), parts), particles=("time", lost))
        case = data.attrs["case"].replace(
            "[averages]", f"[start]\nseed = {seed}\n[monitors]\ngas_flux = 0.1\n[averages]"
        )
        means = data.assign(solids_flux=(1.0 + 1e-3 * seed) * data["solids_flux"])
        means.assign_attrs(case=case).assign_coords(outlet=[1, 2]).to_netcdf(run / "results.nc")
        made.append(run)
    return made


def watch(path):
    """Name in words -> value and verdict of what is watched over time."""
    results = open_results(path)
    names = [name for name in MONITORS if name in RULES and name in results.data and name != "pressure_drop"]
    found = [MONITORS[name](results) for name in names]
    return {each.monitor: (each.value, each.verdict) for each in found}


@pytest.mark.parametrize("reduced", [False, True])
def test_pools_show_what_went_wrong_in_one_replica(runs, tmp_path, reduced):
    good, bad = map(watch, runs)
    wrong = [words for words in bad if bad[words] != good.get(words)]
    assert len(wrong) == len(SPOILT) + 2  # beside them outlets and lost particles
    write_pool(runs, tmp_path / "pool.nc", reduced)
    found = watch(tmp_path / "pool.nc")
    for words in wrong:
        assert found[words] == (pytest.approx(bad[words][0], rel=1e-6), bad[words][1]), words


def test_reduced_files_keep_what_went_wrong_once_and_twice(runs, tmp_path):
    bad = watch(runs[1])
    write_pool(runs[1:], tmp_path / "bad.nc", reduced=True)
    write_pool([runs[0], tmp_path / "bad.nc"], tmp_path / "both.nc")
    for file in ("bad.nc", "both.nc"):
        found = watch(tmp_path / file)
        for words, (value, verdict) in bad.items():
            assert found[words] == (pytest.approx(value, rel=1e-3, abs=1e-9), verdict), (file, words)
    assert float(open_results(tmp_path / "bad.nc").data["heat_error"].max()) == 0.5
