"""A run that ends where its means are sure enough: the same on any number of ranks, and after a stop."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from small_bed import find_differences, prepare, stop_at_next_moment

from fbcouple.case.load import load_case
from fbcouple.errors import CaseError
from fbcouple.launcher.launch import launch
from fbcouple.launcher.resume import is_complete

GAS_OF_SPHERES = """
title = "an elastic gas of 60 spheres"
end_time = 1.5
[domain]
size = [0.01, 0.006, 0.02]
cells = [3, 2, 4]
[particles]
diameter = 1e-3
density = 2500.0
count = 60
[contact]
restitution = 1.0
wall_restitution = 1.0
friction = 0.0
wall_friction = 0.0
stiffness = 20.0
[start]
[averages]
start = 0.1
every = 2e-3
blocks = 8
until_error = 0.1
error_of = "agitation"
[output]
record_every = 0.02
[checkpoint]
moment_steps = 50
"""


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    run, rows = prepare(tmp_path_factory.mktemp("ended"), text=GAS_OF_SPHERES), []
    launch(run, 1, rows.append)
    return run, rows


def read(run):
    with xr.open_dataset(run / "results.nc") as results:
        return results.load()


def test_it_ends_before_its_limit_and_says_why(ended):
    run, rows = ended
    results = read(run)
    about, end = results.attrs, float(results["time"][-1])
    print(f"ended at {end:g} s with an error of {about['averaging_error']:g}")
    assert about["complete"] == 1 and about["ended_by"] == "until_error" and 0.1 < end < 1.5
    assert about["averaging_error"] <= 0.1 and about["averaging_error_of"] == "agitation"
    assert rows[-1]["averages_error"] == about["averaging_error"] and rows[-1]["expected_end"] <= end
    assert is_complete(run, load_case(str(run / "case.toml")))
    error, mean = results["agitation_stderr"].mean("y"), results["agitation"].mean("y")
    assert np.sqrt((error**2).sum() / (mean**2).sum()) == pytest.approx(about["averaging_error"], rel=1e-4)


def test_it_ends_there_on_two_ranks(ended, tmp_path):
    run = prepare(tmp_path, ["averages.until_error=0.9", "averages.every=1e-4", "averages.start=0.0"], GAS_OF_SPHERES)
    other = prepare(
        tmp_path / "two", ["averages.until_error=0.9", "averages.every=1e-4", "averages.start=0.0"], GAS_OF_SPHERES
    )
    launch(run, 1, lambda row: None)
    launch(other, 2, lambda row: None)
    one, two = read(run), read(other)
    assert one.attrs["ended_by"] == two.attrs["ended_by"] == "until_error"
    assert two["time"].values[-1] == one["time"].values[-1]
    assert two.attrs["averaging_error"] == pytest.approx(one.attrs["averaging_error"], rel=1e-6)


def test_it_ends_at_the_first_look_after_its_earliest_end(tmp_path):
    """Sure enough before, it goes on until then; looks are every 20 ms here."""
    sets = ["averages.until_error=0.3"]
    early = prepare(tmp_path, sets, GAS_OF_SPHERES)
    late, rows = prepare(tmp_path / "late", [*sets, "averages.earliest_end=0.2"], GAS_OF_SPHERES), []
    launch(early, 1, lambda row: None)
    launch(late, 1, rows.append)
    ends = [float(read(run)["time"][-1]) for run in (early, late)]
    assert {read(run).attrs["ended_by"] for run in (early, late)} == {"until_error"}
    assert ends[0] < 0.19 and 0.2 * (1.0 - 1e-6) <= ends[1] < 0.25
    expected = [row["expected_end"] for row in rows if np.isfinite(row["expected_end"])]
    assert expected and min(expected) >= 0.2


def test_an_earliest_end_behind_the_last_leaves_the_run_whole(tmp_path):
    run = prepare(tmp_path, ["end_time=0.6", "averages.earliest_end=1.0", "averages.until_error=0.9"], GAS_OF_SPHERES)
    launch(run, 1, lambda row: None)
    assert read(run).attrs["ended_by"] == "end_time"


def test_a_stop_on_the_way_changes_no_bit(ended, tmp_path):
    run, rows = prepare(tmp_path, text=GAS_OF_SPHERES), []
    stop_at_next_moment(run, 1, rows)
    stop_at_next_moment(run, 1, rows)
    launch(run, 1, rows.append, resume=True)
    assert find_differences(ended[0], run) == []
    assert read(run).attrs["averaging_error"] == read(ended[0]).attrs["averaging_error"]


def test_results_that_were_lost_at_the_end_are_written_anew(ended):
    """The checkpoint of the end knows that it is one."""
    run = ended[0]
    before = read(run)
    (run / "results.nc").unlink()
    launch(run, 1, lambda row: None, resume=True)
    assert read(run)["time"].values[-1] == before["time"].values[-1] and read(run).attrs["ended_by"] == "until_error"


@pytest.mark.parametrize(
    ("sets", "text"),
    [
        (["averages.blocks=4"], "averages.blocks: 4 is given, at least 8 are allowed with averages.until_error"),
        (['averages.error_of="pressure"'], 'averages.error_of: "pressure" is given and the case has no [gas]'),
        (["averages.earliest_end=-1.0"], "averages.earliest_end: -1.0 is given"),
        (["averages.until_error=1.5"], "averages.until_error: 1.5 is given"),
        (['averages.error_of="speed"'], "averages.error_of"),
    ],
)
def test_what_cannot_end_a_run_is_refused(tmp_path, sets, text):
    with pytest.raises(CaseError) as caught:
        prepare(tmp_path, sets, GAS_OF_SPHERES)
    assert text in str(caught.value)


def test_a_map_without_an_error_to_reach_is_refused(tmp_path):
    text = GAS_OF_SPHERES.replace("until_error = 0.1\n", "earliest_end = 1.0\n")
    with pytest.raises(CaseError) as caught:
        prepare(tmp_path, text=text)
    told = str(caught.value)
    assert '"agitation" is given without averages' in told and "earliest_end: 1 s is given without averages" in told


def test_a_history_may_end_the_run(tmp_path):
    """The mean kinetic energy within 2 %, as its rows have it."""
    sets = ['averages.error_of="kinetic_energy"', "averages.until_error=0.02", "contact.steps_per_contact=100"]
    run, rows = prepare(tmp_path, [*sets, "end_time=6", "output.record_every=0.005"], GAS_OF_SPHERES), []
    launch(run, 1, rows.append)
    results = read(run)
    about, end = results.attrs, float(results["time"][-1])
    energy = results["kinetic_energy"].sel(time=slice(0.1, None)).values
    print(f"ended at {end:g} s with an error of {about['averaging_error']:g}, {energy.mean():g} J +- {energy.std():g}")
    assert about["ended_by"] == "until_error" and about["averaging_error_of"] == "kinetic_energy" and 0.1 < end < 6.0
    plain = energy.std() / energy.mean() / np.sqrt(len(energy))
    assert plain < about["averaging_error"] <= 0.02 and rows[-1]["averages_error"] == about["averaging_error"]


def test_a_history_that_the_case_has_not_is_refused(tmp_path):
    for name in ("pressure_drop", "gas_support"):
        with pytest.raises(CaseError, match=f'"{name}" is given and the case has no .gas.; name what it has'):
            prepare(tmp_path, [f'averages.error_of="{name}"'], GAS_OF_SPHERES)
