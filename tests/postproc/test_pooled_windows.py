"""Pools of replicas whose windows differ: what is of all has the windows of all, what is of the first its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.postproc.averaging import find_inlet_change_in_means
from fbcouple.postproc.figures.history import history
from fbcouple.postproc.measures import centre_fluctuation, cut_to_window, in_window
from fbcouple.postproc.papers.hamidouche2019.claims import UNDECIDED, judge_claims
from fbcouple.postproc.papers.hamidouche2019.paper_runs import AS_PRINTED, list_twins, sort_runs
from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.postproc.statistics import summarise
from fbcouple.results.pools import write_pool
from fbcouple.results.reader import open_results
from tests.postproc.paper_bed import write_bed
from tests.postproc.whole_run import write_whole

STARTS = (2.0, 0.5, 12.0)


def load(path: Path) -> xr.Dataset:
    data = xr.open_dataset(path, decode_times=False).load()
    data.close()
    return data


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Three runs of 20 s with means from 2, 0.5 and 12 s on; the inlet stands until 10 s and flows after it."""
    folder = tmp_path_factory.mktemp("windows")
    made = []
    for seed, start in enumerate(STARTS, start=1):
        run = write_whole(folder / f"from-{start:g}")
        data = load(run / "results.nc")
        data["solids_flux"] = (1.0 + 0.01 * seed) * data["solids_flux"]
        ramp = "inlet_ramp = [[0.0, 0.0], [10.0, 0.0], [10.0, 1.2], [20.0, 1.2]]"
        case = data.attrs["case"].replace("inlet_velocity = 1.2", ramp)
        case = case.replace("[averages]", f"[start]\nseed = {seed}\n[averages]")
        about = {"case": case, "averaging_start": start, "averaging_samples": round(500 * (20.0 - start))}
        data.assign_attrs(about | {"inlet_changed_at": [1.0]}).to_netcdf(run / "results.nc")
        made.append(run)
    return made


def test_the_averaged_time_of_a_pool_is_that_of_its_replicas_together(tmp_path):
    """Three replicas of 3.5 s decide what one of 3.5 s does not, and count before a run of 7 s."""
    beds = [
        write_bed(tmp_path / f"bed-{n}", "c4-0.1", (f"start.seed={n}",), end=4.5, agitation=0.1 + 1e-3 * n)
        for n in (1, 2, 3)
    ]
    write_pool(beds, tmp_path / "three.nc", reduced=True)
    pooled = open_results(tmp_path / "three.nc")
    assert pooled.window == (1.0, 4.5) and pooled.averaged == pytest.approx(10.5)
    (row,) = [row for row in judge_claims([open_results(beds[0])]) if row.name == "bed-height"]
    assert row.verdict == UNDECIDED and "averaged 3.5 s, needed 5 s" in row.why
    assert sort_runs([pooled])[1] == {}
    longer = open_results(write_bed(tmp_path / "longer", "c4-0.1", ("start.seed=4",), end=8.0))
    for order in ([longer, pooled], [pooled, longer]):
        assert sort_runs(order)[0][AS_PRINTED]["c4-0.1"].path == pooled.path
    assert [one.path for _, *pair in list_twins([longer, pooled]) for one in pair] == [pooled.path, longer.path]
    part = open_results(write_bed(tmp_path / "part", "c4-0.1", ("start.seed=3",), end=8.0))
    assert list_twins([part, pooled]) == []  # a seed of the pool


@pytest.mark.parametrize("reduced", [False, True])
def test_histories_of_the_first_are_cut_to_its_own_window(runs, tmp_path, reduced):
    write_pool(runs, tmp_path / "all.nc", reduced)
    pooled, first = open_results(tmp_path / "all.nc"), open_results(runs[0])
    assert pooled.window == (0.5, 20.0) and pooled.first_window == (2.0, 20.0)
    assert pooled.windows == [(start, 20.0) for start in STARTS]
    time, values = cut_to_window(pooled, "solids_centre_z")
    assert time[0] >= 2.0 and values.max() < 0.04  # in its start-up it is 25 mm too high
    if not reduced:
        assert np.array_equal(in_window(pooled, "bed_height"), in_window(first, "bed_height"))
        assert summarise(pooled, "bed_height").deviation == pytest.approx(1.43e-3, rel=0.02)
    mean = pooled.window_mean("solids_centre_z")[0]
    expected = centre_fluctuation(first)
    assert centre_fluctuation(pooled).value * mean == pytest.approx(
        expected.value * float(in_window(first, "solids_centre_z").mean()), rel=0.1 if reduced else 1e-6
    )


def test_the_shaded_window_is_that_of_the_history(runs, tmp_path):
    write_pool(runs, tmp_path / "all.nc")
    picture = history(open_results(tmp_path / "all.nc"))
    (shade,) = picture.axes[0].patches
    assert [shade.get_x(), shade.get_x() + shade.get_width()] == [2.0, 20.0]
    assert "shaded: window of the first; time mean over 0.5–20 s of 3 replicas" in str(
        [text.get_text() for text in picture.texts]
    )


def test_the_inflow_is_that_of_the_windows_of_all(runs, tmp_path):
    write_pool(runs, tmp_path / "all.nc")
    pooled = open_results(tmp_path / "all.nc")
    mean = (10.0 + 10.0 + 8.0) * 1.2 / sum(20.0 - start for start in STARTS)
    assert MONITORS["gas_flux"](pooled).value == pytest.approx(1.2 / mean)


def test_a_change_of_the_inlet_between_the_windows_is_in_none(runs, tmp_path):
    for chosen, marked in ((runs, True), ([runs[0], runs[2]], False)):
        write_pool(chosen, tmp_path / "all.nc")
        assert (find_inlet_change_in_means(open_results(tmp_path / "all.nc")) is not None) is marked
