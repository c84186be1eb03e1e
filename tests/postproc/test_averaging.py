"""Time means that hold the start-up say so, in every note, table and warning."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.postproc.averaging import (
    averaging_text,
    find_inlet_change_in_means,
    find_start_up_in_means,
    format_window,
    list_warnings,
    mark_runs,
)
from fbcouple.postproc.experiment import gather_references
from fbcouple.postproc.figures.maps import solids_fraction, solids_fractions
from fbcouple.postproc.figures.measured_lines import draw_measured_lines
from fbcouple.postproc.report import report
from fbcouple.results.reader import open_results
from tests.postproc.whole_run import write_whole

LINE = "x,value\n0.02,-0.3\n0.04,0.0\n0.06,0.3\n"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A run whose start-up is over at 1 s and whose means begin at 2 s, with a measured line."""
    run = write_whole(tmp_path_factory.mktemp("whole") / "run", references=("solids_velocity@0.025=line.csv",))
    (run / "line.csv").write_text(LINE)
    return open_results(run)


def begin(results, start, end=20.0, label="early"):
    """The same run with means from `start` to `end` [s]."""
    data = results.data.copy()
    data.attrs = data.attrs | {"averaging_start": start, "averaging_end": end}
    return replace(results, data=data, label=label)


def cut(results, rows):
    """The same run with so many rows of its history."""
    return replace(results, data=results.data.isel(time=slice(rows)), label="cut")


def test_means_after_the_start_up_have_no_mark(results):
    assert find_start_up_in_means(results) is None
    assert averaging_text(results) == "time mean over 2–20 s"
    assert mark_runs([results]) == "" and list_warnings([results]) == []


def test_means_from_within_the_start_up_are_marked(results):
    early = begin(results, 0.5)
    found = find_start_up_in_means(early)
    assert found.brief == "start-up included"
    assert "over 0.5–20 s begin in the start-up" in found.sentence and "set averages.start" in found.sentence
    assert averaging_text(early) == "time mean over 0.5–20 s; start-up included"
    assert mark_runs([results, early]) == "; start-up included: early"


@pytest.mark.parametrize("drift", [3.21, float("nan")])
def test_a_run_that_looked_for_its_start_up_itself_has_told(results, drift):
    """It knows its maps, too: its word counts, and not what the histories alone say."""
    early = begin(results, 0.5)
    early.data.attrs |= {"start_up_over": 1, "start_up_drift": 0.9}
    assert find_start_up_in_means(early) is None and averaging_text(early) == "time mean over 0.5–20 s"
    early.data.attrs |= {"start_up_over": 0, "start_up_drift": drift}
    found = find_start_up_in_means(early)
    assert found.brief == "start-up not over" and averaging_text(early) == "time mean over 0.5–20 s; start-up not over"
    seen = "drift 3.21, at most 1.05 is wanted" if drift > 0.0 else "the record is too short to tell"
    assert f"has not seen its start-up end ({seen}): the time means over 0.5–20 s begin" in found.sentence


@pytest.mark.parametrize(("rows", "brief"), [(20, "start-up not seen to be over"), (120, "start-up not over")])
def test_a_start_up_that_is_not_seen_to_be_over_is_marked(results, rows, brief):
    early = cut(begin(results, 0.05, 0.01 * (rows - 1)), rows)
    assert find_start_up_in_means(early).brief == brief
    assert averaging_text(early).endswith(f"; {brief}")


def test_means_of_two_inlets_are_marked(results):
    changed = begin(results, 2.0)
    changed.data.attrs["inlet_changed_at"] = [1.0, 7.25]
    assert find_inlet_change_in_means(changed).brief == "inlet changed at 7.25 s"
    assert averaging_text(changed) == "time mean over 2–20 s; inlet changed at 7.25 s"
    assert mark_runs([results, changed]) == "; inlet changed at 7.25 s: early"
    (warning,) = list_warnings([changed])
    assert warning.startswith("early: the inlet was changed at 7.25 s, within the time means over 2–20 s")
    changed.data.attrs["inlet_changed_at"] = 1.0  # as NetCDF reads a single one
    assert find_inlet_change_in_means(changed) is None and changed.inlet_changes == [1.0]


def test_the_mark_stands_on_maps_and_on_measured_lines(results):
    early = begin(results, 0.5)
    assert "start-up included" in solids_fraction(early).texts[1].get_text().replace("\n", " ")
    titles = [axes.get_title().replace("\n", " ") for axes in solids_fractions([results, early]).axes[:2]]
    assert titles == ["run 2–20 s", "early 0.5–20 s start-up included"]
    (line,) = gather_references([results], [])
    both = replace(line, runs=frozenset({"run", "early"}))
    picture = draw_measured_lines([results, early], [both])
    labels = [text.get_text().replace("\n", " ") for text in picture.legends[0].get_texts()]
    assert "run" in labels and "early (start-up included)" in labels
    assert "start-up included: early" in picture.texts[1].get_text()


def test_the_report_has_the_mark_in_its_tables_and_first_of_all(results, monkeypatch):
    for name in ("FIGURES", "COMPARISONS"):
        monkeypatch.setattr(report, name, {})
    early = replace(begin(results, 0.5), label="run")
    content = report.describe([early], gather_references([early], []))
    (row,) = content["references"]
    assert row["time mean of the run"] == "time mean over 0.5–20 s; start-up included"
    solved = {row["what"]: row["value"] for row in content["runs"][0]["solved"]}
    assert solved["time means over"] == "0.5–20 s; start-up included"
    assert content["warnings"][0].startswith("run: the time means over 0.5–20 s begin in the start-up")


def test_post_and_report_say_it_on_the_terminal(tmp_path, caplog):
    run = write_whole(tmp_path / "run")
    early = begin(open_results(run), 0.5)
    early.data.attrs["case"] = early.data.attrs["case"].replace("start = 2.0", "start = 0.5")
    (run / "results.nc").unlink()
    early.data.to_netcdf(run / "results.nc")
    for command in (["post", str(run), "--only", "solids_fraction"], ["report", str(run)]):
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(report, "FIGURES", {})
            done = CliRunner().invoke(cli, command)
        assert done.exit_code == 0, done.output
        assert "begin in the start-up" in caplog.text
        caplog.clear()
    assert json.loads((run / "report.json").read_text())["warnings"]


@pytest.mark.parametrize(
    ("window", "text"),
    [((0.02, 0.05000436), "0.02–0.05 s"), ((1.0, 10.00049), "1–10 s"), ((0.5, 2.0001), "0.5–2 s")],
)
def test_the_window_has_the_digits_that_its_length_makes_sense_of(results, window, text):
    assert format_window(begin(results, *window)) == text


def test_a_window_without_means_is_none(results):
    names = [name for name, field in results.data.items() if {"x", "y", "z"} <= set(field.dims)]
    lean = replace(begin(results, 0.5), data=begin(results, 0.5).data.drop_vars(names))
    assert find_start_up_in_means(lean) is None
    assert np.isfinite(lean.data["time"]).all()
