"""Whatever is killed, whenever: words where a parent lives, no file half written, and the run goes on bit for bit."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from small_bed import PATIENCE, await_true, find_differences, find_ranks, prepare, start_held, start_to_hold

from fbcouple.case.load import load_case
from fbcouple.errors import CaseError
from fbcouple.launcher.launch import launch
from fbcouple.results.line_log import read_line
from fbcouple.run_folder.checkpoint import list_checkpoints, read

SETS = ["checkpoint.every=2e-4", "checkpoint.moment_steps=1", "output.save_every=1e-3"]
"""A checkpoint and results at every step, so that kills meet unfinished ones."""
VICTIMS = ("one rank", "all ranks", "the parent", "a rank that writes a checkpoint", "a parent while one is written")
PARTS = ("checkpoint", "finish")
"""Where a checkpoint that is being written is held: files written, and all of them on the disk but without an index."""
FAST = (3, 2)
SEEDS = [seed if seed in FAST else pytest.param(seed, marks=pytest.mark.slow) for seed in range(20)]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The uninterrupted run, and the steps of its history."""
    run = prepare(tmp_path_factory.mktemp("whole"), SETS)
    rows: list[dict] = []
    launch(run, 2, rows.append)
    return run, [row["steps"] for row in rows]


def start_for(run: Path, victim: str, dice: random.Random, steps: list[int]) -> subprocess.Popen:
    """Start the run and wait for a random moment of it: in a checkpoint, where it is held, or a bit behind some row; it
    is held then before its last row, however late the kill comes."""
    if "checkpoint" in victim or "written" in victim:
        return start_held(run, dice.choice(PARTS), dice.randrange(1, 20), "-n", "2")
    job, log = start_to_hold(run, "step", steps[-2], "-n", "2"), run / "logs/run.jsonl"
    row = dice.randrange(1, len(steps) - 1)
    await_true(lambda: log.exists() and log.read_bytes().count(b"\n") >= row, job)
    time.sleep(dice.uniform(0.0, 0.1))
    return job


def kill(run: Path, job: subprocess.Popen, victim: str, dice: random.Random) -> None:
    ranks = find_ranks(run)
    which = [job.pid] if "parent" in victim else ranks if victim == "all ranks" else [dice.choice(ranks)]
    for number in which:
        with suppress(ProcessLookupError):
            os.kill(number, signal.SIGKILL)


def require_whole_files(run: Path) -> None:
    """Every file that has its name is whole: checkpoints, results, and the lines of the log but for a torn last one."""
    case = load_case(str(run))
    for folder in list_checkpoints(run):
        read(folder, case)
    if (run / "results.nc").exists():
        with xr.open_dataset(run / "results.nc") as results:
            assert np.isfinite(results["kinetic_energy"].values).all()
    lines = (run / "logs/run.jsonl").read_text().splitlines(keepends=True)
    assert all(read_line(line) for line in lines[:-1])


@pytest.mark.parametrize("seed", SEEDS)
def test_kill(tmp_path, whole, seed):
    dice, victim = random.Random(seed), VICTIMS[seed % len(VICTIMS)]
    run = prepare(tmp_path, SETS)
    job = start_for(run, victim, dice, whole[1])
    kill(run, job, victim, dice)
    _, words = job.communicate(timeout=PATIENCE)
    if "parent" in victim:
        assert job.returncode == -signal.SIGKILL
    else:
        assert job.returncode == 3 and "signal 9 (Killed)" in words and "Traceback" not in words, words
    resume(run)
    require_whole_files(run)
    assert find_differences(whole[0], run) == []


def resume(run: Path) -> None:
    """Go on; a job whose parent was killed ends by itself, and holds the folder and its checkpoints until then."""
    limit = time.monotonic() + PATIENCE
    await_true(lambda: not find_ranks(run))
    require_whole_files(run)
    while True:
        try:
            launch(run, 2, lambda row: None, resume=True)
            return
        except CaseError as error:
            assert "another run is under way" in str(error) and time.monotonic() < limit
            time.sleep(0.2)
