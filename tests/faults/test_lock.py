"""Two runs never share a folder; a lock that nobody holds any more is taken over."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from scene import prepare

from fbcouple.errors import CaseError, SolverError
from fbcouple.launch import launch
from fbcouple.lock import STALE_AFTER, hold

HOLD = """
import pathlib, sys, time
from fbcouple.lock import hold
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


def test_stopped_rank_ends_the_run(tmp_path):
    """Rank 0 is stopped at the first row; without the watchdog the run would hang for ever."""
    run = prepare(tmp_path, ["end_time=1.0"])
    stopped: list[int] = []

    def stop(row):
        if not stopped and row["time"] > 0:
            pattern = f"^[^ ]*python[^ ]* -m fbcouple.worker {run}"
            found = subprocess.run(["pgrep", "-f", pattern], capture_output=True, text=True, check=True)
            stopped.append(int(found.stdout.split()[0]))
            os.kill(stopped[0], signal.SIGSTOP)

    with pytest.raises(SolverError, match=r"no coupling step for 8 s of wall time") as caught:
        launch(run, 1, stop, patience=8.0)
    assert str(stopped[0]) in str(caught.value)
    time.sleep(0.5)
    state = subprocess.run(["ps", "-o", "stat=", "-p", str(stopped[0])], capture_output=True, text=True, check=False)
    assert state.stdout.strip()[:1] in ("", "Z"), "the stopped rank is left behind"
