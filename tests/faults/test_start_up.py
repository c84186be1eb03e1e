"""A run that finds the end of its start-up itself: what it says, the same on any number of ranks, and after a stop."""

from __future__ import annotations

import math

import pytest
import xarray as xr
from small_bed import find_differences, prepare, stop_at_next_moment
from test_until_sure import GAS_OF_SPHERES

from fbcouple.batch.state import look_at
from fbcouple.errors import CaseError
from fbcouple.launcher.launch import launch
from fbcouple.postproc.averaging import list_marks
from fbcouple.postproc.report.tables import tabulate_solved
from fbcouple.results.reader import open_results

AUTO = ['averages.start="auto"']
STEADY = [*AUTO, "contact.steps_per_contact=100", "end_time=8", "averages.until_error=0.2"]
"""Short DEM steps keep the energy of the elastic spheres, and so a bed that is steady."""
OF_GAS = """
title = "gas that starts in a box"
end_time = 0.4
[domain]
size = [0.01, 0.006, 0.02]
cells = [5, 3, 10]
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 0.5
[averages]
start = "auto"
every = 2e-3
blocks = 8
[output]
record_every = 2e-3
"""


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    run, rows = prepare(tmp_path_factory.mktemp("ended"), STEADY, GAS_OF_SPHERES), []
    launch(run, 1, rows.append)
    return run, rows


def read(run):
    with xr.open_dataset(run / "results.nc") as results:
        return results.load()


def test_it_finds_the_end_of_its_start_up_and_ends_by_its_error(ended):
    run, rows = ended
    about = read(run).attrs
    begin, end = about["averaging_start"], about["averaging_end"]
    print(f"start-up over at {begin:g} s, ended at {end:g} s, error {about['averaging_error']:g}")
    assert about["ended_by"] == "until_error" and about["start_up_over"] == 1 and about["start_up_drift"] <= 1.05
    assert 0.0 < begin <= 0.4 * end < 0.4 * 8.0 and rows[-1]["averages_start"] == begin
    assert math.isnan(rows[0]["averages_start"]) and math.isnan(rows[0]["averages_error"])
    results = open_results(run)
    told = {row["what"]: row["value"] for row in tabulate_solved(results)}
    assert told["start-up, found by the run: over at [s]"] == begin
    assert results.window == (begin, end) and list_marks(results) == []


def test_a_stop_on_the_way_changes_no_bit(ended, tmp_path):
    run, rows = prepare(tmp_path, STEADY, GAS_OF_SPHERES), []
    stop_at_next_moment(run, 1, rows)
    launch(run, 1, rows.append, resume=True, until=2.0)
    launch(run, 1, rows.append, resume=True)
    assert find_differences(ended[0], run) == []
    assert read(run).attrs["averaging_start"] == read(ended[0]).attrs["averaging_start"]


def test_the_same_start_on_two_ranks(tmp_path):
    """Gas alone, whose way is no other on two ranks."""
    runs = [prepare(tmp_path / str(ranks), text=OF_GAS) for ranks in (1, 2)]
    for ranks, run in enumerate(runs, 1):
        launch(run, ranks, lambda row: None)
    one, two = (read(run).attrs for run in runs)
    print(one["averaging_start"], one["start_up_over"], one["start_up_drift"], two["start_up_drift"])
    assert one["start_up_over"] == two["start_up_over"] == 1
    assert 0.0 < two["averaging_start"] == pytest.approx(one["averaging_start"], rel=1e-6)
    assert two["start_up_drift"] == pytest.approx(one["start_up_drift"], rel=1e-3)


def test_a_run_that_is_too_short_says_so_everywhere(tmp_path):
    """The means begin at the best guess, and results, status and report say that it is one."""
    run, rows = prepare(tmp_path, [*AUTO, "end_time=0.3"], GAS_OF_SPHERES), []
    launch(run, 1, rows.append)
    results = open_results(run)
    assert results.data.attrs["start_up_over"] == 0 and math.isnan(rows[-1]["averages_start"])
    assert results.data.attrs["ended_by"] == "end_time" and math.isnan(results.data.attrs["averaging_error"])
    assert 0.0 < results.window[0] < 0.15 and results.mean("solids_fraction").sum() > 0.0
    (mark,) = list_marks(results)
    assert mark.brief == "start-up not over" and "the run has not seen its start-up end" in mark.sentence
    told = {row["what"]: row["value"] for row in tabulate_solved(results)}
    assert told["start-up, found by the run: over at [s]"] == "not reached"
    assert look_at(run).message == "start-up not over"


@pytest.mark.parametrize(
    ("sets", "text"),
    [
        (['averages.start="soon"'], 'averages.start: "soon" is given, a number at least 0 or "auto" (in s) is allowed'),
        (["averages.start=-1"], 'averages.start: -1 is given, a number at least 0 or "auto" (in s) is allowed'),
        ([*AUTO, "averages.every=0.1"], "(16 blocks from the start of the run to end_time, a sample in each)"),
    ],
)
def test_what_finds_no_start_is_refused(tmp_path, sets, text):
    with pytest.raises(CaseError) as caught:
        prepare(tmp_path, sets, GAS_OF_SPHERES)
    assert text in str(caught.value)


def test_few_blocks_find_no_start(tmp_path):
    text = GAS_OF_SPHERES.replace('until_error = 0.1\nerror_of = "agitation"\n', "")
    with pytest.raises(CaseError, match=r'at least 8 are allowed with averages\.start = "auto"'):
        prepare(tmp_path, [*AUTO, "averages.blocks=5"], text)
