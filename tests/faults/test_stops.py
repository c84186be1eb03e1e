"""Signals end a run with a checkpoint and exit code 75; a killed or damaged one goes on from what is whole."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest
import xarray as xr
from small_bed import PATIENCE, await_true, find_differences, find_ranks, prepare, start, start_held

from fbcouple.errors import CaseError
from fbcouple.launcher.launch import launch
from fbcouple.machine.stop_signals import LONGEST_WAIT
from fbcouple.results.line_log import read_line

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
    parent = start_held(run, "step", 23)
    os.kill(parent.pid if whom == "the parent" else find_ranks(run)[0], number)
    _, words = parent.communicate(timeout=PATIENCE)
    assert parent.returncode == 75, words
    assert f"stopped by {signal.Signals(number).name} at t = " in words and "--resume" in words
    launch(run, 1, lambda row: None, resume=True)
    assert find_differences(whole, run) == []


def test_signal_before_the_first_step_is_not_lost(tmp_path):
    """The solvers are starting: the job is told when it can listen."""
    run = prepare(tmp_path, ["checkpoint.moment_steps=1", "end_time=10.0"])
    parent = start(run)
    await_true((run / "logs/launcher.log").exists, parent)
    parent.send_signal(signal.SIGTERM)
    _, words = parent.communicate(timeout=PATIENCE)
    assert parent.returncode == 75 and "stopped by SIGTERM at t = " in words, words
    assert list((run / "checkpoints").glob("step-*"))


def test_signal_after_the_last_moment_is_told(tmp_path, whole):
    """It can stop nothing any more: the run comes to its end, is complete, and says that the signal came too late."""
    run = prepare(tmp_path, LONG)
    parent = start_held(run, "step", find_last_step(whole))
    parent.send_signal(signal.SIGUSR1)
    said, words = parent.communicate(timeout=PATIENCE)
    assert parent.returncode == 0 and "SIGUSR1 came too late to stop the run" in said, said + words
    assert "SIGUSR1 came after the last moment to stop" in (run / "logs/launcher.log").read_text()
    assert find_differences(whole, run) == []


def find_last_step(run: Path) -> int:
    return int(read_line((run / "logs/run.jsonl").read_text().splitlines()[-1])["steps"])


@pytest.fixture
def slow_tool(tmp_path, monkeypatch) -> Path:
    """A blockMesh that does not come to an end; returns the file in which it says its number."""
    (tmp_path / "bin").mkdir()
    tool, place = tmp_path / "bin/blockMesh", tmp_path / "number"
    tool.write_text(f"#!/bin/sh\necho $$ > {place}.part && mv {place}.part {place}\nexec sleep {2 * PATIENCE:g}\n")
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", str(tool.parent), prepend=os.pathsep)
    return place


def is_running(number: int) -> bool:
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_ends_a_mesh_tool_and_the_run(tmp_path, slow_tool, number):
    run = prepare(tmp_path)
    parent = start(run)
    await_true(slow_tool.exists, parent)
    parent.send_signal(number)
    _, words = parent.communicate(timeout=PATIENCE)
    name = signal.Signals(number).name
    assert parent.returncode == 75 and f"stopped by {name} before the first step, while blockMesh was at work" in words
    assert "--resume" in words and not is_running(int(slow_tool.read_text()))
    assert not (run / "results.nc").exists() and not (run / "logs/failure.room").exists()


def test_mesh_tool_ends_with_a_killed_parent(tmp_path, slow_tool):
    """Left behind it would go on writing into a folder that the next run takes."""
    run = prepare(tmp_path)
    parent = start(run)
    await_true(slow_tool.exists, parent)
    parent.kill()
    parent.communicate()
    await_true(lambda: not is_running(int(slow_tool.read_text())))


@pytest.mark.slow
def test_wall_limit_ends_with_a_checkpoint(tmp_path):
    """A bed that would take many minutes is given one: its checkpoint is there before it is over."""
    run = prepare(tmp_path, ["end_time=10.0"])
    began = time.time()
    parent = start(run, "--wall-limit", "60")
    _, words = parent.communicate(timeout=PATIENCE)
    assert parent.returncode == 75 and "stopped by the wall limit at t = " in words, words
    (newest,) = (run / "checkpoints").glob("step-*")
    started = (run / "logs/mesh.log").stat().st_mtime
    assert began < newest.stat().st_mtime < started + 60.0
    rows: list[dict] = []
    launch(run, 1, rows.append, resume=True, until=1e-4)
    assert rows == [] and list((run / "checkpoints").glob("step-*"))


CLOCK = """
#include <dlfcn.h>
#include <stdlib.h>
#include <time.h>
extern "C" int clock_gettime(clockid_t clock, timespec* now) {
    static auto ask = (int (*)(clockid_t, timespec*)) dlsym(RTLD_NEXT, "clock_gettime");
    int code = ask(clock, now);
    if (clock == CLOCK_REALTIME && getenv("OMPI_COMM_WORLD_RANK")) now->tv_sec -= 3600;
    return code;
}
"""


def test_wall_limit_does_not_follow_a_clock_that_is_set_back(tmp_path, monkeypatch):
    """The machine's clock loses an hour after the start: by it, the limit would be an hour away."""
    run, shim = prepare(tmp_path, ["end_time=10.0"]), tmp_path / "clock.so"
    compiler = ["g++", "-shared", "-fPIC", "-x", "c++", "-", "-o", str(shim), "-ldl"]
    subprocess.run(compiler, input=CLOCK, text=True, check=True)
    monkeypatch.setenv("LD_PRELOAD", str(shim))
    parent = start(run, "--wall-limit", "0.01")
    _, words = parent.communicate(timeout=PATIENCE)
    assert parent.returncode == 75 and "stopped by the wall limit at t = " in words, words


SELDOM = ["checkpoint.moment_steps=100000"]
"""No moment for a checkpoint comes before the end of the run."""
AVERAGED_FROM = 2e-3
"""Start of the bed's averages [s]; on a busy machine the limit may come before it."""


def test_wall_limit_does_not_wait_for_a_moment_that_is_far(tmp_path):
    run = prepare(tmp_path, [*SELDOM, "end_time=0.5"])
    parent = start(run, "--wall-limit", "10")
    _, words = parent.communicate(timeout=PATIENCE)
    assert parent.returncode == 75 and "stopped by the wall limit at t = " in words, words
    (newest,) = (run / "checkpoints").glob("step-*")
    step = int(newest.name.removeprefix("step-"))
    reached = json.loads((newest / "state.json").read_text())["clock"]["time"]
    case = run / "case.toml"
    case.write_text(case.read_text().replace("end_time = 0.5", f"end_time = {max(reached, AVERAGED_FROM) + 2e-3!r}"))
    rows: list[dict] = []
    launch(run, 1, rows.append, resume=True)
    assert rows[-1]["steps"] > step
    with xr.open_dataset(run / "results.nc") as results:
        assert results.attrs["complete"] == 1 and "stopped between two moments" in results.attrs["updates"]


@pytest.mark.slow
def test_signal_is_told_and_does_not_wait_for_a_moment_that_is_far(tmp_path):
    run = prepare(tmp_path, [*SELDOM, "end_time=10.0"])
    parent = start(run)
    await_true((run / "logs/heartbeat").exists, parent)
    began = time.monotonic()
    parent.send_signal(signal.SIGTERM)
    said, words = parent.communicate(timeout=PATIENCE)
    assert parent.returncode == 75 and LONGEST_WAIT < time.monotonic() - began < 3 * LONGEST_WAIT
    assert "SIGTERM: stops at its next checkpoint, at most 20 s and a step from now; a second signal ends" in said
    assert "stopped by SIGTERM at t = " in words and list((run / "checkpoints").glob("step-*"))


@pytest.mark.slow
def test_second_signal_ends_at_once(tmp_path):
    """No moment for a checkpoint comes before it; what was written stands."""
    run = prepare(tmp_path, [*SELDOM, "end_time=10.0"])
    parent = start(run)
    await_true((run / "logs/heartbeat").exists, parent)
    for _ in range(2):
        parent.send_signal(signal.SIGTERM)
        time.sleep(0.6)
    _, words = parent.communicate(timeout=PATIENCE)
    assert parent.returncode == 3 and "ended at once by a second signal (SIGTERM was the first)" in words, words
    assert find_ranks(run) == []


def test_killed_parent_leaves_a_run_that_goes_on(tmp_path, whole):
    run = prepare(tmp_path, LONG)
    parent = start_held(run, "step", 23)
    os.kill(parent.pid, signal.SIGKILL)
    parent.communicate()
    limit = time.monotonic() + PATIENCE
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


@pytest.mark.parametrize("name", ["liggghts.restart", "cells-0000.npz", "state.json", "index.json", "history.jsonl"])
@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_checkpoint_is_refused_by_name_and_the_one_before_is_used(tmp_path, whole, damage, name):
    from fbcouple.case.load import load_case  # noqa: PLC0415
    from fbcouple.run_folder.checkpoint import choose  # noqa: PLC0415

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
