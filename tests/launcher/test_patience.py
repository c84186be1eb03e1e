"""How long a job that takes no step is waited for."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

import fbcouple.launcher.job
from fbcouple.errors import SolverError
from fbcouple.launcher.job import Job
from fbcouple.launcher.stop_signals import Requests
from fbcouple.run_folder.lock import hold

PATIENCE = 4.0
STARTING = 'for i in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16; do sleep 0.5; echo {i} >> "$0"; done; exec sleep 600'


def test_a_file_that_goes_away_meanwhile_ends_no_run(tmp_path, monkeypatch):
    """One that is listed and gone before it is looked at, here of a compiled loop; the job itself ends well."""
    run = tmp_path / "run"
    (run / "logs").mkdir(parents=True)
    (run / "logs/liggghts.log").touch()
    monkeypatch.setattr(Path, "iterdir", lambda folder: iter([folder / "gone.log", folder / "liggghts.log"]))
    monkeypatch.setattr(fbcouple.launcher.job, "list_compiled", lambda: [tmp_path / "gone.1.nbc"])
    written = STARTING.replace("exec sleep 600", f"touch {run / 'results.nc'}")
    command = ["sh", "-c", written, str(run / "logs/liggghts.log")]
    with hold(run) as lock, Requests() as requests:
        Job(command, run, PATIENCE, lock, requests, print).follow(lambda row: None)


@pytest.mark.parametrize("sign", ["run/logs/liggghts.log", "compiled/loop.1.nbc"])
def test_a_start_that_writes_logs_or_compiles_is_waited_for_and_one_that_hangs_is_not(tmp_path, monkeypatch, sign):
    run = tmp_path / "run"
    for folder in (run / "logs", tmp_path / "compiled"):
        folder.mkdir(parents=True)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "compiled"))
    command = ["sh", "-c", STARTING, str(Path(tmp_path, sign))]
    begin = time.monotonic()
    with hold(run) as lock, Requests() as requests, pytest.raises(SolverError, match="no coupling step for 4 s"):
        Job(command, run, PATIENCE, lock, requests, print).follow(lambda row: None)
    assert time.monotonic() - begin > 8.0, "it writes for 8 s, twice its patience, and then no more"
