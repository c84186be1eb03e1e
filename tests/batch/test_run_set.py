"""`fbcouple run` on a folder of runs, and `fbcouple status`: real runs of a few beads without gas."""

from __future__ import annotations

import json
import math
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click.testing import CliRunner

from fbcouple.batch.folders import find_runs, predict_wall
from fbcouple.batch.side_by_side import CONSOLE, TO_STOP
from fbcouple.batch.state import look_at
from fbcouple.case.cost.coefficients import SHIPPED
from fbcouple.case.cost.prediction import predict
from fbcouple.case.load import load_case, write_case
from fbcouple.cli.main import cli
from fbcouple.decks.render import set_up
from fbcouple.errors import CaseError
from fbcouple.results.line_log import read_log
from fbcouple.run_folder.checkpoint import list_checkpoints

BED = """
title = "beads that fall"
end_time = 0.01
[domain]
size = [0.01, 0.006, 0.02]
cells = [5, 3, 10]
[particles]
diameter = 1e-3
density = 2500.0
count = 60
[contact]
stiffness = 100.0
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[output]
record_every = 1e-3
"""
LEFT_OUT = "mine: is a case, and no run folder: left out; make a run of it with: fbcouple setup "
LONGEST = 120.0
"""Wall time [s] that a test waits for what has to come, on a machine that does much else."""


@pytest.fixture
def many(tmp_path):
    """A folder of three runs, of which the last is the longest."""
    (tmp_path / "case.toml").write_text(BED, encoding="utf-8")
    for seed, end in ((1, 0.01), (2, 0.01), (3, 0.02)):
        case = load_case(str(tmp_path / "case.toml"), [f"start.seed={seed}", f"end_time={end}"])
        set_up(case, tmp_path / f"set/seed-{seed}")
    return tmp_path / "set"


def call(*arguments):
    return CliRunner().invoke(cli, list(map(str, arguments)), catch_exceptions=False)


def leave_a_case(folder):
    """Leave a case that was never set up beside the runs in `folder`."""
    (folder / "mine").mkdir()
    (folder / "mine/case.toml").write_text(BED, encoding="utf-8")


def test_a_case_beside_the_runs_is_told_and_left_out(many):
    leave_a_case(many)
    said: list[str] = []
    assert [run.name for run in find_runs(many, said.append)] == ["seed-1", "seed-2", "seed-3"]
    assert len(said) == 1 and LEFT_OUT in said[0]
    done = call("status", many, "--json")
    assert done.exit_code == 0 and [row["state"] for row in json.loads(done.stdout)] == ["set up"] * 3
    assert done.stderr.count(LEFT_OUT) == 1
    job = call("batch", many, "--scheduler", "slurm", "--time", "1:00:00", "-n", 1)
    assert job.exit_code == 0 and f"warning: {many.resolve()}" in job.output and LEFT_OUT in job.output
    script = (many / "batch/slurm.sh").read_text(encoding="utf-8")
    assert "seed-3" in script and "mine" not in script


def test_a_folder_that_holds_a_case_alone_names_it(tmp_path):
    leave_a_case(tmp_path)
    with pytest.raises(CaseError, match="mine in it is a case that was not set up; write one with `fbcouple setup"):
        find_runs(tmp_path)
    assert call("run", tmp_path).exit_code == 1


def test_a_look_at_a_run_reads_its_history_once(many, monkeypatch):
    reads: list[Path] = []
    call("run", many / "seed-1")
    monkeypatch.setattr("fbcouple.api.read_log", lambda log: reads.append(log) or read_log(log))
    state = look_at(many / "seed-1")
    assert state.state == "complete" and state.time == pytest.approx(0.01, rel=1e-2) and state.wall > 0.0
    assert reads == [many / "seed-1/logs/run.jsonl"]


def test_a_damaged_run_hides_none_of_the_others(many):
    (many / "seed-2/manifest.json").write_text('{"x":', encoding="utf-8")
    told = json.loads(call("status", many, "--json").output)
    assert [state["state"] for state in told] == ["set up", "damaged", "set up"]
    assert "seed-2/manifest.json: was not written by this version" in told[1]["message"]
    table = call("status", many)
    assert table.exit_code == 0 and "damaged" in table.output and "nan" not in table.output
    assert call("status", many / "seed-2").exit_code == 1


def test_damaged_results_are_told_and_written_anew(many):
    run = many / "seed-1"
    assert call("run", run).exit_code == 0
    (run / "results.nc").write_bytes((run / "results.nc").read_bytes()[:1000])
    (told,) = json.loads(call("status", run, "--json").output)
    assert told["state"] == "damaged" and told["message"].startswith("results.nc: cannot be read (")
    assert told["message"].endswith("where it is resumed") and told["time"] == pytest.approx(0.01, rel=1e-2)
    assert [row["state"] for row in json.loads(call("status", many, "--json").output)] == ["damaged", *["set up"] * 2]
    assert "results.nc: cannot be read" in call("status", many).output
    assert call("run", run, "--resume").exit_code == 0 and look_at(run).state == "complete"


def test_more_ranks_than_cores_are_told_once(many, monkeypatch):
    """Of a set for all runs at a time, and in the words of each run whose own ranks are too many."""
    monkeypatch.setattr("os.sched_getaffinity", lambda process: {0})
    monkeypatch.delenv("OMPI_MCA_rmaps_base_oversubscribe", raising=False)
    done = call("run", many / "seed-1", "-n", 2)
    assert done.exit_code == 0, done.output
    assert done.output.count("warning: 2 ranks are asked for, on 1 core: ") == 1
    done = call("run", many, "-j", 2)
    assert done.exit_code == 0 and done.output.count("warning: 2 runs of 1 rank at a time") == 1
    assert "warning" not in call("run", many / "seed-1", "-n", 2, "--resume").output, "there is nothing to do"


def test_the_longest_run_goes_first(many):
    walls = [predict_wall(run) for run in find_runs(many)]
    assert walls[0] == walls[1] < walls[2]
    case = load_case(str(many / "seed-3"))
    assert walls[2] == predict(case, 1, SHIPPED, many / "seed-3").wall


def test_a_run_whose_time_cannot_be_told_goes_first(many):
    """One that was set up by force with a drag law that never carries its particles."""
    gas = "[gas]\ndensity = 1.2\nviscosity = 1.8e-5\ninlet_velocity = 0.8\n"
    drag = '[exchange]\ndrag = "tang"\nfilter_passes = 1\n'
    large = BED.replace("[0.01, 0.006, 0.02]", "[1.0, 0.6, 2.0]").replace("1e-3\ndensity", "0.05\ndensity")
    (many.parent / "case.toml").write_text(large + gas + drag, encoding="utf-8")
    set_up(load_case(str(many.parent / "case.toml")), many / "seed-4")
    assert [math.isinf(predict_wall(run)) for run in find_runs(many)] == [False, False, False, True]


def test_what_fails_does_not_stop_the_others_and_is_told(many):
    deck = many / "seed-1/DEM/in.liggghts"
    deck.write_text(deck.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
    done = call("run", many, "-j", 2)
    assert done.exit_code == 1
    assert done.output.count("done; draw its figures") == 2 and "seed-1: " in done.output
    assert [look_at(run).state for run in find_runs(many)] == ["set up", "complete", "complete"]
    assert "in.liggghts" in (many / "seed-1" / CONSOLE).read_text(encoding="utf-8")
    leave_a_case(many)
    again = call("run", many, "-j", 2, "--trust")
    assert again.exit_code == 0 and "all 3 runs are complete" in again.output and LEFT_OUT in again.stderr
    rows = json.loads(call("status", many, "--json").stdout)
    assert [row["state"] for row in rows] == ["complete"] * 3
    assert rows[2]["time"] == pytest.approx(0.02, rel=1e-2) and rows[2]["left"] is None and rows[2]["ranks"] == 1


def test_a_signal_stops_all_with_checkpoints_and_the_same_command_goes_on(many):
    for run in find_runs(many):
        set_up(load_case(str(run), ["end_time=100.0", "checkpoint.moment_steps=1"]), run)
    command = [sys.executable, "-P", "-m", "fbcouple", "run", str(many), "-j", "2"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        runs = find_runs(many)
        wait_for(lambda: sum(look_at(run).time > 0.0 for run in runs) == 2)
        states = [look_at(run) for run in runs]
        assert sorted(state.state for state in states) == ["running", "running", "set up"]
        assert all("process" in state.where for state in states if state.state == "running")
        process.send_signal(signal.SIGTERM)
        said, _ = process.communicate(timeout=LONGEST)
    assert process.returncode == 75, said
    assert "0 of 3 runs are complete; go on with `fbcouple run" in said and said.count("stopped by SIGTERM at") == 2
    assert sorted(look_at(run).state for run in runs) == ["set up", "stopped", "stopped"]
    assert sum(bool(list_checkpoints(run)) for run in runs) == 2
    for run in runs:  # far enough for the signal to come before it, and now near
        write_case(load_case(str(run), [f"end_time={look_at(run).time + 0.01}"]), run / "case.toml")
    again = call("run", many, "-j", 3)
    assert again.exit_code == 0 and "all 3 runs are complete" in again.output
    said = "".join((run / CONSOLE).read_text(encoding="utf-8") for run in runs)
    assert said.count("resumes at t = ") == 2 and said.count("has no checkpoint yet") == 1


def test_the_wall_limit_is_of_all_together(many):
    for run in find_runs(many):
        set_up(load_case(str(run), ["end_time=100.0"]), run)
    begin = time.monotonic()
    done = call("run", many, "-j", 2, "--wall-limit", TO_STOP + 1.0)
    assert done.exit_code == 75 and "0 of 3 runs are complete" in done.output
    assert time.monotonic() - begin < TO_STOP + 1.0


def test_runs_stop_with_checkpoints_where_their_runner_is_killed(many):
    for run in find_runs(many):
        set_up(load_case(str(run), ["end_time=100.0", "checkpoint.moment_steps=1"]), run)
    command = [sys.executable, "-P", "-m", "fbcouple", "run", str(many), "-j", "2"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        runs = find_runs(many)
        wait_for(lambda: sum(look_at(run).time > 0.0 for run in runs) == 2)
        process.kill()
    assert process.returncode == -signal.SIGKILL
    wait_for(lambda: sorted(look_at(run).state for run in runs) == ["set up", "stopped", "stopped"])
    assert sum(bool(list_checkpoints(run)) for run in runs) == 2


def wait_for(condition):
    """Raises: AssertionError if it has not come within `LONGEST`."""
    begin = time.monotonic()
    while not condition():
        assert time.monotonic() - begin < LONGEST
        time.sleep(0.1)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["{set}/seed-1", "-j", "2"], "this is one run; leave it out"),
        (["{set}", "--until", "0.1"], "--until is of one run"),
        (["{set}", "--resume", "--set", "end_time=1"], "--set is of one run"),
    ],
)
def test_options_of_one_run_and_of_several(many, arguments, words):
    done = call("run", *(text.format(set=many) for text in arguments))
    assert done.exit_code == 2 and words in done.output


def test_a_folder_without_runs_is_told(tmp_path: Path):
    with pytest.raises(CaseError, match="is neither a run folder nor a folder of runs"):
        find_runs(tmp_path)
    assert call("status", tmp_path).exit_code == 1


def test_a_case_and_a_file_are_told_from_runs(tmp_path: Path):
    case = tmp_path / "bed" / "case.toml"
    case.parent.mkdir()
    case.write_text("")
    told = call("status", case.parent)
    assert told.exit_code == 1 and f"fbcouple setup {case.parent} -o RUN" in told.stderr.replace("\n", "")
    told = call("status", case)
    assert told.exit_code == 1 and "is a file and no run folder; give the folder of a run" in told.stderr
