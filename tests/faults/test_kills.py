"""A rank that is killed ends the run with exit code 3; what was written stands, and the run goes on from it."""

from __future__ import annotations

import random
import subprocess

import pytest
from scene import find_differences, prepare

from fbcouple.errors import SolverError
from fbcouple.launch import launch

SETS = ["checkpoint.every=2e-4", "checkpoint.moment_steps=1"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The uninterrupted run; it writes a checkpoint every few steps, so that kills meet unfinished ones."""
    run = prepare(tmp_path_factory.mktemp("whole"), SETS)
    rows: list[dict] = []
    launch(run, 2, rows.append)
    return run, len(rows)


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)])
def test_killed_rank(tmp_path, whole, seed):
    run = prepare(tmp_path, SETS)
    moment, rank = random.Random(seed).randrange(2, whole[1] - 8), seed % 2
    seen: list[dict] = []

    def kill(row):
        seen.append(row)
        if len(seen) == moment:
            pattern = f"^[^ ]*python[^ ]* -m fbcouple.worker {run}"
            found = subprocess.run(["pgrep", "-f", pattern], capture_output=True, text=True, check=True)
            subprocess.run(["kill", "-KILL", found.stdout.split()[rank]], check=True)

    with pytest.raises(SolverError, match=r"(?s)signal 9"):
        launch(run, 2, kill)
    launch(run, 2, lambda row: None, resume=True)
    assert find_differences(whole[0], run) == []
