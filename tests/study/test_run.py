"""A whole study with real runs: what is done is left alone, the exact solution is met at the known order."""

from __future__ import annotations

import csv
import json

import pytest
import xarray as xr
from click.testing import CliRunner

from fbcouple.api import Run
from fbcouple.case.bed.drag_balance import terminal_velocity
from fbcouple.case.load import load_case
from fbcouple.cli.main import cli
from fbcouple.study.measures.against_theory import _solve_path
from fbcouple.study.runs import ENDING, run_case

SHORT = (("[set]\n", "[set]\nend_time = 0.04\noutput.record_every = 2e-3\n"), ('"exponential"]', '"semi-implicit"]'))


def call(*arguments: object):
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


def test_study_runs_once_and_says_what_it_found(write, tmp_path):
    path, out = write(*SHORT), tmp_path / "out"
    part = call("study", "error-vs-time", path, "-o", out, "--only", "max_step-0.001_scheme-explicit")
    assert part.exit_code == 0, part.output
    assert len(list(out.glob("members/*"))) == 1 and part.output.count("not run") == 3
    first = call("study", "error-vs-time", path, "-o", out, "-j", 2)
    assert first.exit_code == 0, first.output
    order = [line.split()[1].rstrip(":") for line in first.output.splitlines() if line[:2] in ("1/", "2/", "3/", "4/")]
    assert [name.partition("_scheme")[0] for name in order] == ["max_step-0.002"] * 2 + ["max_step-0.001"] * 2
    table = json.loads((out / "study.json").read_text())
    rows = {row["member"]: row for row in table["members"]}
    assert len(rows) == 4 and all(row["how"] == "complete" for row in rows.values())
    coarse, fine = (rows[f"max_step-{step}_scheme-explicit"]["error"] for step in ("0.002", "0.001"))
    assert coarse / fine == pytest.approx(2.0, rel=0.2), "first order in the fluid step"
    assert any(row["pareto"] for row in rows.values())
    assert table["machine"] and (out / "study.png").stat().st_size > 10_000
    with (out / "members.csv").open() as file:
        assert [float(row["error"]) for row in csv.DictReader(file)] == [row["error"] for row in table["members"]]
    assert "data:image/png;base64" in (out / "study.html").read_text()

    results = sorted(out.glob("members/*/results.nc"))
    times = [result.stat().st_mtime_ns for result in results]
    results[0].write_bytes(results[0].read_bytes()[:1000])
    again = call("study", "error-vs-time", path, "-o", out)
    assert again.exit_code == 0
    renewed = [result.stat().st_mtime_ns != time for result, time in zip(results, times, strict=True)]
    assert renewed == [True, False, False, False], "only the member with damaged results is run again"
    assert results[0].stat().st_size > 1000


def test_a_member_that_is_not_there_is_told(write, tmp_path):
    done = call(
        "study", "error-vs-time", write(*SHORT), "-o", tmp_path / "out", "--only", "max_step-0.002_scheme-explicity"
    )
    assert done.exit_code == 1 and "did you mean `max_step-0.002_scheme-explicit`" in done.stderr
    assert not (tmp_path / "out").exists()


def test_mistakes_end_with_one_line_each_and_nothing_written(write, tmp_path):
    path = write(("gas.max_step =", "gas.max_stp ="), ('["path"]', '["pat"]'))
    done = call("study", "error-vs-time", path, "-o", tmp_path / "out")
    assert done.exit_code == 1 and len(done.stderr.splitlines()) == 2
    assert not (tmp_path / "out").exists()


def test_path_ends_at_the_terminal_velocity(write):
    case = load_case(str(write().parent / "case.toml"))
    way = _solve_path(case, [0.0, 1.0, 1.1])
    assert case.gas.inlet_velocity - (way[2] - way[1]) / 0.1 == pytest.approx(terminal_velocity(case), rel=1e-6)


def test_member_that_is_out_of_time_goes_on_from_its_checkpoint(write, tmp_path):
    base, run = str(write().parent / "case.toml"), tmp_path / "run"
    settings = {"end_time": 0.1, "gas.max_step": 1e-4, "gas.max_courant": 10.0, "gas.inlet_velocity": 0.52}
    first = run_case(base, settings, run, 1, 0.01)
    assert first.how == "out of time" and not first.is_final
    again = run_case(base, settings, run, 1, 1200.0)
    assert again.how == "complete" and again.seconds > first.seconds
    with xr.open_dataset(run / "results.nc") as results:
        assert results.attrs["complete"] == 1 and float(results["time"][0]) == 0.0
    begun = [line for line in (run / "logs/run.jsonl").read_text().splitlines() if '"time": 0.0,' in line]
    assert len(begun) == 1, "the history goes on, and was not begun again"
    assert run_case(base, settings, run, 1, 1200.0) == again


def test_a_member_that_was_brought_to_its_end_by_hand_stays(write, tmp_path):
    """Stopped within a study, or begun without one, and ended by `fbcouple run`: nothing of it is run again."""
    base, run = str(write().parent / "case.toml"), tmp_path / "run"
    settings = {"end_time": 0.05, "gas.max_step": 1e-4, "gas.max_courant": 10.0, "gas.inlet_velocity": 0.52}
    assert run_case(base, settings, run, 1, 0.01).how == "out of time"
    assert Run(run).resume(1, progress=False).state == "complete"
    kept = (run / "results.nc").stat().st_mtime_ns
    found = run_case(base, settings, run, 1, 1200.0)
    assert found.how == "complete" and found.seconds > 0.0 and (run / "results.nc").stat().st_mtime_ns == kept
    (run / ENDING).unlink()
    assert run_case(base, settings, run, 1, 1200.0).how == "complete"
    assert (run / "results.nc").stat().st_mtime_ns == kept
