"""Signals end a run with a checkpoint and exit code 75; a killed or damaged one goes on from what is whole."""

from __future__ import annotations

import os
import shutil
import signal
import time
from pathlib import Path

import pytest
from scene import await_checkpoint, find_differences, find_ranks, prepare, start

from fbcouple.errors import CaseError
from fbcouple.launch import launch

LONG = ["checkpoint.every=5e-4"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The uninterrupted run, with checkpoints."""
    run = prepare(tmp_path_factory.mktemp("whole"), LONG)
    launch(run, 1, lambda row: None)
    return run


@pytest.mark.parametrize(
    ("number", "whom"),
    [
        (signal.SIGTERM, "the parent"),
        (signal.SIGUSR1, "the parent"),
        (signal.SIGINT, "the parent"),
        (signal.SIGTERM, "a rank"),
        pytest.param(signal.SIGUSR1, "a rank", marks=pytest.mark.slow),
        pytest.param(signal.SIGINT, "a rank", marks=pytest.mark.slow),
    ],
)
def test_signal_ends_with_a_checkpoint(tmp_path, whole, number, whom):
    run = prepare(tmp_path, LONG)
    parent = start(run)
    await_checkpoint(run, parent)
    os.kill(parent.pid if whom == "the parent" else find_ranks(run)[0], number)
    _, words = parent.communicate(timeout=60)
    assert parent.returncode == 75, words
    assert f"stopped by {signal.Signals(number).name} at t = " in words and "--resume" in words
    launch(run, 1, lambda row: None, resume=True)
    assert find_differences(whole, run) == []


def test_signal_before_the_first_step_is_not_lost(tmp_path):
    """The mesh is still being made, or the solvers are starting: the job is told when it can listen."""
    run = prepare(tmp_path, ["checkpoint.moment_steps=1", "end_time=10.0"])
    parent = start(run)
    limit = time.monotonic() + 60
    while not (run / "logs/mesh.log").exists():
        assert parent.poll() is None and time.monotonic() < limit
        time.sleep(0.002)
    parent.send_signal(signal.SIGTERM)
    _, words = parent.communicate(timeout=60)
    assert parent.returncode == 75 and "stopped by SIGTERM" in words, words
    assert list((run / "checkpoints").glob("step-*"))


@pytest.mark.slow
def test_wall_limit_ends_with_a_checkpoint(tmp_path):
    """A bed that would take minutes is given seconds: its checkpoint is there before they are over."""
    run = prepare(tmp_path, ["end_time=10.0"])
    began = time.time()
    parent = start(run, "--wall-limit", "12")
    _, words = parent.communicate(timeout=60)
    assert parent.returncode == 75 and "stopped by the wall limit at t = " in words, words
    (newest,) = (run / "checkpoints").glob("step-*")
    started = (run / "logs/mesh.log").stat().st_mtime
    assert began < newest.stat().st_mtime < started + 12.0
    rows: list[dict] = []
    launch(run, 1, rows.append, resume=True, until=1e-4)
    assert rows == [] and list((run / "checkpoints").glob("step-*"))


@pytest.mark.slow
def test_second_signal_ends_at_once(tmp_path):
    """No moment for a checkpoint comes before it; what was written stands."""
    run = prepare(tmp_path, ["checkpoint.moment_steps=100000", "end_time=10.0"])
    parent = start(run)
    limit = time.monotonic() + 60
    while not (run / "logs/pulse").exists():
        assert parent.poll() is None and time.monotonic() < limit
        time.sleep(0.01)
    for _ in range(2):
        parent.send_signal(signal.SIGTERM)
        time.sleep(0.6)
    _, words = parent.communicate(timeout=30)
    assert parent.returncode == 3 and "ended at once by a second signal (SIGTERM was the first)" in words, words
    assert find_ranks(run) == []


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
