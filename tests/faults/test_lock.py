"""Two runs never share a folder; a lock that nobody holds any more is taken over."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import signal
import subprocess
import sys
import time

import pytest
from small_bed import PATIENCE, await_true, find_ranks, prepare, start, start_program

import fbcouple.launcher.launch
from fbcouple.errors import CaseError, SolverError, StoppedError
from fbcouple.launcher.job import Job
from fbcouple.launcher.launch import launch
from fbcouple.run_folder.lock import STALE_AFTER, hold

HOLD = """
import pathlib, sys, time
from fbcouple.run_folder.lock import hold
with hold(pathlib.Path(sys.argv[1])):
    print(flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    process = subprocess.Popen([sys.executable, "-c", HOLD, tmp_path], stdout=-1)
    process.stdout.readline()
    yield process
    process.kill()
    process.wait()


def test_second_run_is_refused_and_names_the_first(tmp_path, holder):
    with pytest.raises(CaseError, match=f"another run is under way in it .process {holder.pid} on "), hold(tmp_path):
        pytest.fail("two hold it")


def test_lock_of_a_killed_process_is_taken_over(tmp_path, holder):
    holder.kill()
    holder.wait()
    with hold(tmp_path):
        assert json.loads((tmp_path / "lock").read_text())["pid"] == os.getpid()


@pytest.mark.parametrize(("age", "is_free"), [(STALE_AFTER / 2, False), (STALE_AFTER * 2, True)])
def test_lock_of_another_host_is_judged_by_its_heartbeat(tmp_path, age, is_free):
    lock = tmp_path / "lock"
    lock.write_text(json.dumps({"host": "another", "pid": 1}))
    os.utime(lock, (time.time() - age,) * 2)
    if is_free:
        with hold(tmp_path):
            pass
    else:
        with pytest.raises(CaseError, match="process 1 on another"), hold(tmp_path):
            pytest.fail("taken from a live run")


def test_future_heartbeat_is_told(tmp_path):
    """A clock that was set back leaves a heartbeat that does not get old; whoever knows better has a way out."""
    lock = tmp_path / "lock"
    lock.write_text(json.dumps({"host": "another", "pid": 1}))
    os.utime(lock, (time.time() + 3600,) * 2)
    with pytest.raises(CaseError, match=r"in the future, so a clock was set back; if it is over, remove lock"):
        hold(tmp_path).__enter__()


def test_ranks_of_another_host_keep_a_run_alive_whose_parent_is_stopped(tmp_path):
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs/heartbeat").touch()
    (tmp_path / "lock").write_text(json.dumps({"host": "another", "pid": 1}))
    os.utime(tmp_path / "lock", (time.time() - 2 * STALE_AFTER,) * 2)
    with pytest.raises(CaseError, match="process 1 on another"), hold(tmp_path):
        pytest.fail("taken from a live run")


@pytest.mark.parametrize("text", ["", "nonsense", "[1]", '{"host": 1, "pid": 2}', '{"pid": 2}', '{"host": "a"}'])
def test_lock_that_names_nobody_is_free(tmp_path, text):
    (tmp_path / "lock").write_text(text)
    with hold(tmp_path) as lock:
        assert lock.is_ours


@pytest.fixture
def no_locks(monkeypatch):
    """A file system without locks, as NFS without its lock daemon answers."""

    def refuse(file, operation):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", refuse)
    monkeypatch.setattr("fbcouple.run_folder.lock._SETTLE", 0.01)


@pytest.mark.usefixtures("no_locks")
def test_without_locks_the_heartbeat_keeps_others_out(tmp_path):
    said: list[str] = []
    with hold(tmp_path, said.append):
        assert "no file locks here (No locks available)" in said[0]
        with pytest.raises(CaseError, match=f"process {os.getpid()} on "), hold(tmp_path):
            pytest.fail("two hold it")
        os.utime(tmp_path / "lock", (time.time() - 2 * STALE_AFTER,) * 2)
        with hold(tmp_path):
            pass
    with hold(tmp_path):
        pass


@pytest.mark.usefixtures("no_locks")
def test_of_two_claims_at_once_one_is_given_up(tmp_path, monkeypatch):
    """Another one writes its claim over ours before we look again."""
    other = json.dumps({"host": "another", "pid": 1, "token": "x"})
    monkeypatch.setattr(time, "sleep", lambda seconds: (tmp_path / "lock").write_text(other))
    with pytest.raises(CaseError, match="process 1 on another"), hold(tmp_path):
        pytest.fail("two hold it")
    assert (tmp_path / "lock").read_text() == other


LOSSES = {
    "taken by another": (
        lambda run: (run / "lock").write_text('{"host": "another", "pid": 1}'),
        "was taken .process 1",
    ),
    "made again": (lambda run: ((run / "lock").unlink(), (run / "lock").touch()), "was removed or replaced"),
    "removed": (lambda run: (run / "lock").unlink(), "was removed or replaced"),
    "folder moved": (
        lambda run: run.rename(run.with_name("elsewhere")),
        "was moved or removed while a run was under way",
    ),
}


@pytest.mark.parametrize("loss", LOSSES)
def test_lost_lock_is_noticed_at_the_next_heartbeat(tmp_path, loss):
    (tmp_path / "run/logs").mkdir(parents=True)
    lose, words = LOSSES[loss]
    with hold(tmp_path / "run") as lock:
        lock.beat()
        lose(tmp_path / "run")
        with pytest.raises(SolverError, match=words):
            lock.beat()
    assert loss != "taken by another" or "another" in (tmp_path / "run/lock").read_text()


def test_run_folder_that_is_moved_ends_the_run_and_goes_on_from_where_it_is(tmp_path):
    run, moved = prepare(tmp_path, ["end_time=10.0", "checkpoint.every=1e-4"]), tmp_path / "moved"
    job = start(run)
    await_true(lambda: list(run.glob("checkpoints/step-*")), job)
    run.rename(moved)
    _, words = job.communicate(timeout=PATIENCE)
    assert (
        job.returncode == 3
        and f"{run}: was moved or removed while a run was under way" in words
        and "Traceback" not in words
    )
    await_true(lambda: not find_ranks(run))
    said: list[str] = []
    with pytest.raises(StoppedError, match="the wall limit"):
        launch(moved, 1, lambda row: None, resume=True, wall_limit=0.01, say=said.append)
    assert "resumes at t = " in said[0]


@pytest.fixture
def job(monkeypatch) -> list[Job]:
    """The job that `launch` follows."""
    jobs: list[Job] = []

    def keep(*arguments):
        jobs.append(Job(*arguments))
        return jobs[0]

    monkeypatch.setattr(fbcouple.launcher.launch, "Job", keep)
    return jobs


def test_stopped_rank_ends_the_run(tmp_path, job):
    """Rank 0 is stopped at the first row; without the watchdog the run would hang for ever."""
    run = prepare(tmp_path, ["end_time=10.0"])
    stopped: list[int] = []

    def stop(row):
        if not stopped and row["time"] > 0:
            stopped.append(find_ranks(run)[0])
            os.kill(stopped[0], signal.SIGSTOP)
            job[0]._patience = 3.0

    with pytest.raises(SolverError, match=r"no coupling step for 3 s of wall time") as caught:
        launch(run, 1, stop, patience=PATIENCE)
    assert str(stopped[0]) in str(caught.value)
    await_true(lambda: not find_ranks(run))


def list_processes(parent: int) -> list[int]:
    """A parent, its launcher and the ranks."""
    found = [parent]
    for number in found:
        children = subprocess.run(["pgrep", "-P", str(number)], capture_output=True, text=True, check=False)
        found += map(int, children.stdout.split())
    return found


# Its patience is short from the first coupling step on: a busy machine may take its time to start.
IMPATIENT = """
from fbcouple.cli.main import main
from fbcouple.launcher.job import Job
from fbcouple.paths import HEARTBEAT
require_progress = Job._require_progress
def require(self, job):
    self._patience = 8.0 if (self._run / HEARTBEAT).exists() else 600.0
    require_progress(self, job)
Job._require_progress = require
main()
"""


@pytest.mark.parametrize("whom", ["everything", pytest.param("the job without its parent", marks=pytest.mark.slow)])
def test_suspended_run_goes_on(tmp_path, whom):
    """As a batch system, a container or a virtual machine stops it: longer than its patience, which is not spent."""
    run = prepare(tmp_path, ["end_time=10.0", "checkpoint.moment_steps=5"])
    parent = start_program(["-c", IMPATIENT, "run"], run)
    await_true(lambda: (run / "logs/run.jsonl").exists() and len(find_ranks(run)) == 1, parent)
    group = list_processes(parent.pid)[0 if whom == "everything" else 1 :]
    for number in group:
        os.kill(number, signal.SIGSTOP)
    time.sleep(10.0)
    before = (run / "logs/run.jsonl").stat().st_size
    for number in group:  # the parent first, as the shell's `fg` and a batch system may have it
        os.kill(number, signal.SIGCONT)
        time.sleep(0.5)
    await_true(lambda: (run / "logs/run.jsonl").stat().st_size > before, parent)
    parent.send_signal(signal.SIGTERM)
    _, words = parent.communicate(timeout=PATIENCE)
    assert parent.returncode == 75, words
