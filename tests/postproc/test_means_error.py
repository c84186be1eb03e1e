"""The error of the means against run time, of records whose error is known."""

import numpy as np
import pytest
import xarray as xr
from whole_run import write_whole

from fbcouple.postproc import FIGURES
from fbcouple.postproc.figures.means_error import MAPS, follow_error, means_errors
from fbcouple.postproc.figures.registry import COMPARISONS
from fbcouple.results.block_means import BLOCKS
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results, open_results


@pytest.fixture
def run(tmp_path):
    """18 blocks of 1 s, whose flux scatters in each place by a fifth of the map."""
    found = open_results(write_whole(tmp_path / "bed"))
    rng = np.random.default_rng(3)
    flux = found.data["block_solids_flux"]
    values = flux.values.mean(axis=0) * (1.0 + 0.2 * rng.standard_normal(flux.shape))
    return Results(found.path, found.data.assign(block_solids_flux=(flux.dims, values)), found.case, found.label)


def test_it_falls_with_the_root_of_the_window(run):
    line = follow_error(run, MAPS["vertical solids flux"])
    assert line.time == pytest.approx(np.arange(5.0, 21.0)[-len(line.time) :]) and len(line.time) > 12
    blocks = line.time - 2.0
    expected = 0.2 / np.sqrt(blocks)
    assert line.error[5:] == pytest.approx(expected[5:], rel=0.1)
    assert line.error == pytest.approx(expected, rel=0.3)  # the correlation of three blocks is not well known
    spent = run.data["wall_seconds"].sum("stage").sel(time=slice(None, line.time[0] + 1e-6)).sum()
    assert line.core_hours[0] == pytest.approx(2.0 * float(spent) / 3600.0, rel=1e-6)
    assert (np.diff(line.core_hours) > 0.0).all()


def test_figure_and_comparison(run):
    picture = FIGURES["means_error"](run)
    assert picture.axes[0].get_xscale() == picture.axes[0].get_yscale() == "log"
    assert picture.legends[0].get_texts()[0].get_text() == "vertical solids flux"
    other = Results(run.path, run.data, run.case, "other")
    lines = COMPARISONS["means_errors"]([run, other]).legends[0].get_texts()
    assert [text.get_text() for text in lines] == ["bed", "other"]
    with pytest.raises(NotMeantError, match="fewer than two"):
        means_errors([run])


def test_what_has_none_is_left_out(run):
    bare = Results(run.path, run.data.drop_dims("block"), run.case)
    pooled = run.data.assign_attrs(replicas=2)
    for results in (bare, Results(run.path, pooled, run.case)):
        with pytest.raises(NotMeantError, match="no blocks of one run"):
            FIGURES["means_error"](results)


def test_blocks_that_are_all_alike_tell_no_error(run):
    """An error of nothing is no point on a logarithmic axis."""
    fields = {name: xr.full_like(run.data[name], 0.25) for name in BLOCKS}
    with pytest.raises(NotDrawableError, match="to tell an error"):
        FIGURES["means_error"](Results(run.path, run.data.assign(fields), run.case))


def test_a_window_that_turns_round_once_tells_none(run):
    """Every place of every map goes up and down together, once."""
    slow = 1.0 + 0.5 * np.sin(2.0 * np.pi * np.arange(18) / 18.0)
    fields = {
        name: (
            run.data[name].dims,
            run.data[name].values.mean(axis=0) * slow.reshape(18, *[1] * (run.data[name].ndim - 1)),
        )
        for name in BLOCKS
    }
    with pytest.raises(NotDrawableError, match="too short against the correlation"):
        FIGURES["means_error"](Results(run.path, run.data.assign(fields), run.case))
