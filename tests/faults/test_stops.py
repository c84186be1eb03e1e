"""Signals end a run with a checkpoint and exit code 75; a killed or damaged one goes on from what is whole."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from scene import find_differences, prepare

from fbcouple.errors import CaseError
from fbcouple.launch import launch

LONG = ["checkpoint.every=5e-4"]


def start(run: Path, *words: str) -> subprocess.Popen:
    """`fbcouple run` in a process of its own; without what MPI, once started in this process, told the environment."""
    command = [sys.executable, "-c", "from fbcouple.cli import main; main()", "run", str(run), *words]
    return subprocess.Popen(command, env={**os.environ}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def await_checkpoint(run: Path, parent: subprocess.Popen) -> None:
    limit = time.monotonic() + 60
    while not list((run / "checkpoints").glob("step-*")):
        assert parent.poll() is None, parent.communicate()
        assert time.monotonic() < limit, "no checkpoint within a minute"
        time.sleep(0.01)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The uninterrupted run, with checkpoints."""
    run = prepare(tmp_path_factory.mktemp("whole"), LONG)
    launch(run, 1, lambda row: None)
    return run


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGUSR1, signal.SIGINT])
def test_signal_ends_with_a_checkpoint(tmp_path, whole, number):
    run = prepare(tmp_path, LONG)
    parent = start(run)
    await_checkpoint(run, parent)
    parent.send_signal(number)
    _, words = parent.communicate(timeout=60)
    assert parent.returncode == 75, words
    assert "stopped by SIGUSR1" in words and "--resume" in words
    launch(run, 1, lambda row: None, resume=True)
    assert find_differences(whole, run) == []


def test_killed_parent_leaves_a_run_that_goes_on(tmp_path, whole):
    run = prepare(tmp_path, LONG)
    parent = start(run)
    await_checkpoint(run, parent)
    os.kill(parent.pid, signal.SIGKILL)
    parent.communicate()
    limit = time.monotonic() + 30
    while True:
        try:
            launch(run, 1, lambda row: None, resume=True)
            break
        except CaseError as error:  # the job still ends by itself, and holds the folder until then
            assert "another run is under way" in str(error) and time.monotonic() < limit
            time.sleep(0.2)
    assert find_differences(whole, run) == []


def cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[:-1])


def flip(file: Path) -> None:
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)


DAMAGES = {"truncated": cut, "bit-flipped": flip, "missing": Path.unlink}


@pytest.mark.parametrize("name", ["grains.restart", "cells-0000.npz", "state.json", "index.json", "history.jsonl"])
@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_checkpoint_is_refused_by_name_and_the_one_before_is_used(tmp_path, whole, damage, name):
    from fbcouple.case.load import load_case  # noqa: PLC0415
    from fbcouple.checkpoint import choose  # noqa: PLC0415

    run = Path(shutil.copytree(whole, tmp_path / "run"))
    older, newer = sorted((run / "checkpoints").glob("step-*"))
    DAMAGES[damage](newer / name)
    case = load_case(str(run))
    found, refusals = choose(run, case)
    assert found and found.folder == older
    assert len(refusals) == 1 and newer.name in refusals[0] and name in refusals[0]
    DAMAGES[damage](older / name)
    with pytest.raises(CaseError, match="no checkpoint is left to resume from"):
        choose(run, case)


def test_foreign_checkpoint_is_refused(tmp_path, whole):
    other = prepare(tmp_path, [*LONG, "gas.viscosity=1e-5"])
    shutil.copytree(whole / "checkpoints", other / "checkpoints")
    with pytest.raises(CaseError, match="it is of another case"):
        launch(other, 1, lambda row: None, resume=True)
