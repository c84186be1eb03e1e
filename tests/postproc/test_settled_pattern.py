"""What is told of a run beside its figures."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.postproc.report.predicted import tabulate_predicted
from fbcouple.results.reader import NotDrawableError, open_results
from tests.postproc.whole_run import write_whole


@pytest.mark.parametrize("part", [0.05, 0.8])
def test_a_pattern_that_turns_round_is_told_from_one_that_stands(tmp_path, part):
    """Errors that are a part of the map in every cell are that part of it in the root mean square."""
    results = open_results(write_whole(tmp_path / "run"))
    results.data["solids_flux_stderr"] = part * np.abs(results.data["solids_flux"])
    watched = MONITORS["solids_flux_stderr"](results)
    assert watched.value == pytest.approx(part, rel=1e-6) and "0.3" in watched.wanted


def test_no_pattern_without_blocks(tmp_path):
    results = open_results(write_whole(tmp_path / "run"))
    results.data["solids_flux_stderr"][:] = np.nan
    with pytest.raises(NotDrawableError, match="no blocks"):
        MONITORS["solids_flux_stderr"](results)


PREDICTED = {
    "predicted_seconds": 1000.0,
    "predicted_end": 20.0,
    "predicted_factor": 1.2,
    "predicted_error": 0.1,
    "predicted_error_factor": 1.5,
}


def predict_whole(folder, **attributes):
    results = open_results(write_whole(folder))
    results.data.attrs |= PREDICTED | attributes
    return results


def test_what_was_predicted_stands_beside_what_came(tmp_path):
    """Stages that add up to 1100 s where 1000 were told are within 1.2; an error of 0.2 is not within 1.5 of 0.1."""
    results = predict_whole(tmp_path / "run")
    walls = results.data["wall_seconds"]
    steps = walls["time"] > 0.0  # the row of the start is no step
    assert not bool(steps[0])
    results.data["wall_seconds"] = xr.where(steps, walls * (1100.0 / float(walls.where(steps).sum())), 50.0)
    results.data["solids_flux_stderr"] = 0.2 * np.abs(results.data["solids_flux"])
    reached = float(results.data["time"][-1])
    wall, error = tabulate_predicted(results)
    assert wall["predicted"] == pytest.approx(1000.0 * reached / 20.0) and wall["found"] == pytest.approx(1100.0)
    assert wall["found over predicted"] == pytest.approx(1.1 * 20.0 / reached) and wall["as told"] == "yes"
    assert (error["predicted"], error["as told"]) == (0.1, "no") and error["found"] == pytest.approx(0.2, rel=1e-6)


def test_a_run_that_stopped_early_has_no_error_to_be_held_against_and_one_without_prediction_no_table(tmp_path):
    stopped = predict_whole(tmp_path / "stopped", complete=0, predicted_end=1e3)
    assert [row["what"] for row in tabulate_predicted(stopped)] == ["wall time of the steps [s]"]
    odd = predict_whole(tmp_path / "odd", predicted_seconds=0.0, predicted_factor=0.0, predicted_error=float("nan"))
    assert [row["as told"] for row in tabulate_predicted(odd)] == [""]
    assert tabulate_predicted(open_results(write_whole(tmp_path / "plain"))) == []
