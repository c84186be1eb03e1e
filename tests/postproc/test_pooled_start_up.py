"""Pools and reduced files say of each replica whether its means reach into the start-up."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.errors import CaseError
from fbcouple.postproc.averaging import averaging_text, find_start_up_in_means, list_warnings
from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.postproc.report.tables import NOT_REACHED, tabulate_solved, tabulate_statistics
from fbcouple.postproc.statistics import find_steady_time, summarise
from fbcouple.results.pools import write_pool
from fbcouple.results.reader import open_results
from tests.postproc.whole_run import write_whole


def load(path):
    data = xr.open_dataset(path, decode_times=False).load()
    data.close()
    return data


def make(run, seed, start=2.0, rising=False, **attributes):
    """A run of 20 s whose start-up is over at 1 s, or whose bed rises to its end, with means from `start` [s] on."""
    write_whole(run)
    data = load(run / "results.nc")
    if rising:
        data["bed_height"] = data["bed_height"] + 0.01 * data["time"]
    data["solids_flux"] = (1.0 + 0.01 * seed) * data["solids_flux"]
    case = data.attrs["case"].replace("[averages]", f"[start]\nseed = {seed}\n[averages]")
    data.assign_attrs(case=case, averaging_start=start, **attributes).to_netcdf(run / "results.nc")
    return run


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("starts")
    steady = make(folder / "steady", 1)
    return steady, make(folder / "early", 2, start=0.5), make(folder / "rising", 3, rising=True)


def forget(path):
    """The file as versions before wrote it, which told nothing of start-ups."""
    data = load(path)
    told = json.loads(data.attrs["replicas_of"])
    for one in told:
        for name in ("steady_from", "first_row", "particles_lost"):
            del one[name]
    data.assign_attrs(replicas_of=json.dumps(told)).to_netcdf(path)


@pytest.mark.parametrize("reduced", [False, True])
def test_a_pool_is_marked_if_one_replica_is(runs, tmp_path, reduced):
    steady, early, _ = runs
    write_pool([steady], tmp_path / "one.nc", reduced)
    assert find_start_up_in_means(open_results(tmp_path / "one.nc")) is None
    write_pool([steady, early], tmp_path / "two.nc", reduced)
    pooled = open_results(tmp_path / "two.nc")
    brief = "start-up included in 1 of 2 replicas"
    assert averaging_text(pooled) == f"time mean over 0.5–20 s of 2 replicas; {brief}"
    (warning,) = list_warnings([pooled])
    assert "early: " in warning and "is steady from 1." in warning and "they begin at 0.5 s" in warning
    found = summarise(pooled, "bed_height")
    assert 1.0 <= found.start < 2.5 and found.mean == pooled.window_mean("bed_height")[0]
    _, remarks = tabulate_statistics(pooled)
    assert any("s only in early; the time means begin at 0.5 s" in text for text in remarks)
    assert not any("in steady" in text for text in remarks)


def test_no_mean_is_told_while_one_start_up_goes_on(runs, tmp_path):
    steady, _, rising = runs
    write_pool([steady, rising], tmp_path / "two.nc", reduced=True)
    pooled = open_results(tmp_path / "two.nc")
    (warning,) = list_warnings([pooled])
    assert "rising: the start-up is not over at t = 20 s (bed_height" in warning
    assert math.isnan(summarise(pooled, "bed_height").mean) and summarise(pooled, "pressure_drop").mean > 0.0
    rows, _ = tabulate_statistics(pooled)
    assert rows[0]["steady from [s]"] == NOT_REACHED
    assert "start-up not over in 1 of 2 replicas" in str(tabulate_solved(pooled))
    write_pool([rising], tmp_path / "one.nc")
    alone = open_results(tmp_path / "one.nc")
    assert averaging_text(alone) == "time mean over 2–20 s; start-up not over"
    assert MONITORS["pressure_drop"](alone).verdict  # of a history that is steady


def test_spectra_and_snapshots_of_the_first_replica_need_its_start_up_alone(runs, tmp_path):
    steady, _, rising = runs
    write_pool([steady, rising], tmp_path / "two.nc")
    assert find_steady_time(open_results(tmp_path / "two.nc")) == find_steady_time(open_results(steady))


def test_what_the_runs_found_themselves_is_pooled(tmp_path):
    """Whichever is the first."""
    over = make(tmp_path / "over", 1, start_up_over=1, start_up_drift=0.9)
    begun = make(tmp_path / "begun", 2, start=3.0, start_up_over=0, start_up_drift=3.25)
    given = make(tmp_path / "given", 3)
    for order in ([over, begun, given], [given, begun, over]):
        data = write_pool(order, tmp_path / "pool.nc", reduced=True)
        assert data.attrs["start_up_over"] == 0 and data.attrs["start_up_drift"] == 3.25
        pooled = open_results(tmp_path / "pool.nc")
        mark = find_start_up_in_means(pooled)
        assert mark.brief == "start-up not over in 1 of 3 replicas" and "begun: " in mark.sentence
        assert "(drift 3.25, at most 1.05 is wanted)" in mark.sentence
        told = {row["what"]: row["value"] for row in tabulate_solved(pooled)}
        assert sorted(told["start-up, found by the run: over at [s]"].split(", ")) == ["2", NOT_REACHED]
    data = write_pool([over, given], tmp_path / "pool.nc")
    assert data.attrs["start_up_over"] == 1 and find_start_up_in_means(open_results(tmp_path / "pool.nc")) is None


def test_of_an_older_file_the_rows_that_it_has_tell(runs, tmp_path):
    steady, early, _ = runs
    for run, brief in ((steady, ""), (early, "; start-up included")):
        file = tmp_path / f"{run.name}.nc"
        write_pool([run], file, reduced=True)
        forget(file)
        assert averaging_text(open_results(file)).endswith(f" s{brief}")
    assert "by the rows that an older file has" in list_warnings([open_results(tmp_path / "early.nc")])[0]
    write_pool([tmp_path / "steady.nc", tmp_path / "early.nc"], tmp_path / "both.nc")
    assert averaging_text(open_results(tmp_path / "both.nc")).endswith("included in 1 of 2 replicas")
    write_pool([steady, early], tmp_path / "two.nc", reduced=True)
    forget(tmp_path / "two.nc")
    (warning,) = list_warnings([open_results(tmp_path / "two.nc")])
    assert "early: an older file does not tell of its start-up; pool its run again" in warning


def test_post_and_report_warn(runs, tmp_path, caplog):
    write_pool(runs[:2], tmp_path / "two.nc", reduced=True)
    drawn = CliRunner().invoke(cli, ["post", str(tmp_path / "two.nc"), "--only", "solids_fraction"])
    assert drawn.exit_code == 0 and "they begin at 0.5 s" in caplog.text
    assert CliRunner().invoke(cli, ["report", str(tmp_path / "two.nc")]).exit_code == 0
    told = json.loads((tmp_path / "two/report.json").read_text(encoding="utf-8"))
    assert any("they begin at 0.5 s" in text for text in told["warnings"])


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ("{", "is not JSON"),
        ("[]", "does not tell of each replica"),
        ('[{"name": "a", "window": [1, null], "samples": 3, "simulated": 2.0}]', "no proper window"),
        (
            '[{"name": "a", "window": [1, 2], "simulated": 2.0, "steady_from": {"x": ""}}]',
            "no proper samples, steady_from",
        ),
    ],
)
def test_a_file_that_tells_nonsense_is_refused(runs, tmp_path, told, said):
    write_pool(runs[:1], tmp_path / "one.nc", reduced=True)
    data = load(tmp_path / "one.nc")
    data.assign_attrs(replicas_of=told).to_netcdf(tmp_path / "one.nc")
    with pytest.raises(CaseError, match=said):
        open_results(tmp_path / "one.nc")


def test_a_deviation_of_rows_that_are_the_worst_of_all_is_none(runs, tmp_path):
    write_pool([runs[0], make(tmp_path / "other", 4)], tmp_path / "two.nc")
    pooled = open_results(tmp_path / "two.nc")
    assert math.isnan(summarise(pooled, "min_voidage").deviation)
    assert summarise(pooled, "bed_height").deviation == pytest.approx(
        float(np.std(load(runs[0] / "results.nc")["bed_height"].sel(time=slice(2.0 + 1e-9, None)))), rel=1e-6
    )
