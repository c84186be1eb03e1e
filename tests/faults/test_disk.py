"""A full disk ends the run with exit code 3, in words; the newest good checkpoint stands, and the run goes on from it.

Two means: a small file system of its own where one can be mounted, and the limit that a system puts on a file's size.
"""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from small_bed import find_differences, poison, prepare

from fbcouple.errors import SolverError
from fbcouple.launcher.job import Job
from fbcouple.launcher.launch import launch
from fbcouple.launcher.stop_signals import Requests
from fbcouple.run_folder.checkpoint import list_checkpoints
from fbcouple.run_folder.lock import hold

SETS = ["end_time=3e-3", "averages.start=0.0", "output.record_every=1e-4", "output.particles_every=1.0"]
STEP = 12
# What is written -> settings that make it the first to meet the full disk, each kind of it, and what is said.
WRITES = {
    "results": (["output.save_every=1e-3", "checkpoint.every=1.4e-3"], "nearly_full", "no_long_files", "results.nc"),
    "checkpoint": (["checkpoint.every=5e-4"], "nearly_full", "no_long_files", "the checkpoint of step 15"),
    "frames": (["checkpoint.every=1.4e-3", "output.particles_every=1e-4"], "nearly_full", "no_long_files", "frames"),
    "log": (["checkpoint.every=1.4e-3"], "full", "no_longer_log", "logs/run.jsonl"),
}


def mount(folder: Path, size: str) -> bool:
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def unmount(folder: Path) -> None:
    subprocess.run(["umount", "-l", str(folder)], check=True)


def can_mount() -> bool:
    with tempfile.TemporaryDirectory() as place:
        if done := mount(Path(place) / "disk", "1m"):
            unmount(Path(place) / "disk")
        return done


CAN_MOUNT = can_mount()
MEANS = ["file system", pytest.param("limit", marks=pytest.mark.slow)] if CAN_MOUNT else ["limit"]


@pytest.fixture
def disk(tmp_path) -> Iterator[Path]:
    """A file system of 16 MB, or a plain folder where none can be mounted."""
    mounted = mount(tmp_path / "disk", "16m")
    yield tmp_path / "disk"
    if mounted:
        unmount(tmp_path / "disk")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The run with room enough."""
    run = prepare(tmp_path_factory.mktemp("whole"), SETS)
    launch(run, 1, lambda row: None)
    return run


@pytest.mark.parametrize("means", MEANS)
@pytest.mark.parametrize("write", ["results", "checkpoint", "log", pytest.param("frames", marks=pytest.mark.slow)])
def test_full_disk_while_writing(disk, monkeypatch, whole, write, means):
    more, full, limited, words = WRITES[write]
    run = prepare(disk, SETS + more)
    poison(monkeypatch, full if means == "file system" else limited, STEP)
    with pytest.raises(SolverError) as caught:
        launch(run, 1, lambda row: None)
    text = str(caught.value)
    assert text.startswith(f"{words} cannot be written: "), text
    assert "checkpoints/step-000000000010 stands, --resume goes on from it" in text and "Traceback" not in text
    assert list_checkpoints(run)[0].name == "step-000000000010"
    left = [path.name for path in run.rglob("*") if ".part" in path.name or "unfinished" in path.name]
    assert left == []
    (run / "filler").unlink(missing_ok=True)
    monkeypatch.undo()
    launch(run, 1, lambda row: None, resume=True)
    assert find_differences(whole, run) == []


@pytest.mark.parametrize("means", MEANS)
def test_disk_that_is_full_before_the_start(disk, means):
    run = prepare(disk, SETS)
    if means == "file system":
        with (disk / "filler").open("wb", buffering=0) as file, suppress(OSError):
            while file.write(bytes(4096)):
                pass
    limit = ["prlimit", "--fsize=0"] if means == "limit" else []
    command = [*limit, sys.executable, "-m", "fbcouple.cli.main", "run", str(run)]
    done = subprocess.run(command, env={**os.environ}, capture_output=True, text=True, check=False)
    assert done.returncode == 3 and len(done.stderr.splitlines()) == 1, done.stderr
    assert ("No space left on device" if means == "file system" else "File too large") in done.stderr
    assert not (run / "results.nc").exists() and not (run / "checkpoints").exists()


def test_file_system_that_went_read_only_is_told(tmp_path, monkeypatch):
    """No rank could write down why it ended; the parent says where, why, and what the run goes on from."""
    for folder in ("logs", "checkpoints/step-000000000010"):
        (tmp_path / folder).mkdir(parents=True)

    def refuse(run: Path) -> None:
        raise OSError(errno.EROFS, "Read-only file system", str(run / "logs/failure.room"))

    monkeypatch.setattr("fbcouple.launcher.job.give_room_back", refuse)
    words = rf"{tmp_path}: cannot be written any more: .*Read-only file system.*step-000000000010 stands, --resume"
    with hold(tmp_path) as lock, Requests() as requests, pytest.raises(SolverError, match=words):
        Job(["true"], tmp_path, 60.0, lock, requests, print).follow(lambda row: None)
