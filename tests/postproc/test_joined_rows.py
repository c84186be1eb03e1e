"""Rows of reduced files stand for several each: what needs them one by one is refused, and what does not is told."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.postproc.figures.bubbles import find_bubbling
from fbcouple.postproc.figures.history import histories, history
from fbcouple.postproc.figures.spectrum import spectra_of
from fbcouple.postproc.measures import bed_height, centre_fluctuation, in_window
from fbcouple.postproc.statistics import summarise
from fbcouple.results.pools import write_pool
from fbcouple.results.reader import NotDrawableError, open_results
from fbcouple.study.measures.of_motion import compare_fluctuation, compare_frequency
from fbcouple.study.measures.registry import Finished
from fbcouple.validate.comparisons import COMPARISONS, Task
from fbcouple.validate.points import take_value
from fbcouple.validate.schema import Measurement
from tests.postproc.whole_run import write_whole

STROKE = 4.3
REFUSED = "is a reduced file: each row of its histories stands for 20 of the run, too few for"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A run of 40 s with a row each 10 ms whose bed strokes 4.3 times a second, and its reduced file."""
    folder = tmp_path_factory.mktemp("joined")
    run = write_whole(folder / "run")
    data = xr.open_dataset(run / "results.nc", decode_times=False).load()
    data.close()
    time = 0.01 * np.arange(4001)
    stroke = np.sin(2.0 * np.pi * STROKE * time) + 0.1 * np.random.default_rng(0).standard_normal(len(time))
    rows = {"bed_height": 0.07 + 2e-3 * stroke, "solids_centre_z": 0.035 + 1e-3 * stroke}
    rows |= {"pressure_drop": 600.0 + 20.0 * stroke, "max_overlap": 0.02 + 1e-3 * stroke}
    kept = data.drop_dims("time").assign({name: ("time", values) for name, values in rows.items()})
    made = kept.assign_coords(time=("time", time)).assign_attrs(averaging_end=40.0)
    made.to_netcdf(run / "results.nc")
    write_pool([run], folder / "bed.nc", reduced=True)
    return run, folder / "bed.nc"


def test_no_spectrum_is_made_of_joined_rows(files):
    run, reduced = map(open_results, files)
    assert all(found.peak == pytest.approx(STROKE, abs=0.05) for found in spectra_of(run)[:3])
    with pytest.raises(NotDrawableError, match=f"{REFUSED} spectra; take the runs"):
        spectra_of(reduced)
    done = CliRunner().invoke(cli, ["report", str(files[1])])
    assert done.exit_code == 0
    (told,) = json.loads((files[1].with_suffix("") / "report.json").read_text(encoding="utf-8"))["runs"]
    assert told["spectra"] == [] and any(REFUSED in text for text in told["left_out"])


def test_a_short_run_has_a_spectrum_reduced_too(files, tmp_path):
    run = write_whole(tmp_path / "short")
    data = xr.open_dataset(files[0] / "results.nc", decode_times=False).load()
    data.close()
    data.isel(time=slice(0, 200)).assign_attrs(averaging_start=0.5, averaging_end=1.99).to_netcdf(run / "results.nc")
    write_pool([run], tmp_path / "short.nc", reduced=True)
    found = {each.name: each.peak for each in spectra_of(open_results(tmp_path / "short.nc"))}
    assert found["bed_height"] == pytest.approx(STROKE, abs=0.5)


def test_older_files_do_not_say_how_many_rows_are_joined(files, tmp_path):
    data = xr.open_dataset(files[1], decode_times=False).load()
    data.close()
    del data.attrs["joined_rows"]
    data.to_netcdf(tmp_path / "older.nc")
    with pytest.raises(NotDrawableError, match="stands for several of the run"):
        spectra_of(open_results(tmp_path / "older.nc"))


def test_measures_that_need_the_rows_are_refused(files):
    run, reduced = (Finished(open_results(file), None) for file in files)
    with pytest.raises(NotDrawableError, match=f"{REFUSED} a spectrum"):
        compare_frequency(reduced, "bed_height", run)
    with pytest.raises(NotDrawableError, match=r"`pressure_drop` in .* and holds the mean of them; take the runs"):
        compare_fluctuation(reduced, "pressure_drop", run)
    assert compare_fluctuation(reduced, "bed_height", run).error < 0.1


@pytest.mark.parametrize(
    ("compare", "of", "said"),
    [
        ("frequency", "bed_height", f"{REFUSED} a spectrum"),
        ("fluctuation", "pressure_drop", "holds the mean of them"),
        ("mean", "max_overlap", "holds the largest of them"),
        ("mean", "pressure_drop", ""),
        ("fluctuation", "bed_height", ""),
    ],
)
def test_comparisons_that_need_the_rows_are_refused(files, compare, of, said):
    task = Task(Measurement(name="n", compare=compare, of=of, value=1.0, span=(5.0, 35.0)), take_value(1.0, None))
    run, reduced = map(open_results, files)
    if said:
        with pytest.raises(NotDrawableError, match=said):
            COMPARISONS[compare].function(reduced, task)
    else:
        whole = COMPARISONS[compare].function(run, task).values
        assert COMPARISONS[compare].function(reduced, task).values == pytest.approx(whole, rel=0.1)


def test_states_keep_their_spread_and_means_lose_it(files):
    run, reduced = map(open_results, files)
    assert centre_fluctuation(reduced).value == pytest.approx(centre_fluctuation(run).value, rel=0.1)
    assert bed_height(reduced).value == pytest.approx(bed_height(run).value, rel=1e-3)
    assert summarise(reduced, "bed_height").deviation == pytest.approx(summarise(run, "bed_height").deviation, rel=0.1)
    assert math.isnan(summarise(reduced, "pressure_drop").deviation)
    with pytest.raises(NotDrawableError, match=r"`max_overlap` in .* and holds the largest of them; take the runs"):
        in_window(reduced, "max_overlap")


def test_figures_say_it(files):
    reduced = open_results(files[1])
    for picture in (history(reduced), histories([open_results(files[0]), reduced])):
        assert "each row" in " ".join(text.get_text() for text in picture.texts)
    with pytest.raises(NotDrawableError, match="a reduced file keeps none; take the runs"):
        find_bubbling(reduced)
