"""The small bed that the fault matrix breaks: 250 particles above a gas mesh of 150 cells, 100 coupling steps or so."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import fbcouple.launch
from fbcouple.case.load import load_case
from fbcouple.decks.render import set_up
from fbcouple.environment import mpi_command

BED = """
title = "250 particles"
end_time = 0.01
[domain]
size = [0.01, 0.006, 0.02]
cells = [5, 3, 10]
[particles]
diameter = 1e-3
density = 2500.0
count = 250
[contact]
restitution = 0.97
wall_restitution = 0.97
friction = 0.1
wall_friction = 0.1
stiffness = 100.0
[start]
[averages]
start = 2e-3
every = 1e-4
blocks = 2
[output]
record_every = 2e-4
snapshots_every = 1e-3
particles_every = 2e-3
tracked = [7, 250]
[checkpoint]
moment_steps = 5
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 1.2
[exchange]
filter_passes = 1
"""


def prepare(folder: Path, sets: list[str] | None = None, text: str = BED) -> Path:
    """Set a run up in `folder` and return its folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "case.toml").write_text(text)
    set_up(load_case(str(folder / "case.toml"), sets or []), folder / "run")
    return folder / "run"


def find_differences(one: Path, other: Path) -> list[str]:
    """Variables of two results.nc that are not the same bit for bit, wall times excepted."""
    with xr.open_dataset(one / "results.nc") as a, xr.open_dataset(other / "results.nc") as b:
        return compare(a, b, ("wall_seconds", "stage", "component"))


def compare(one: xr.Dataset, other: xr.Dataset, but: tuple[str, ...]) -> list[str]:
    """Variables of two datasets, but those named, that are not the same bit for bit."""
    assert set(one.variables) == set(other.variables)
    names = [str(name) for name in one.variables if name not in but]
    return [name for name in names if not np.array_equal(one[name].values, other[name].values, equal_nan=True)]


def compare_frames(one: Path, other: Path) -> list[str]:
    """Names of the frames of two runs that are not the same bit for bit; they must be as many."""
    frames = sorted((one / "frames").iterdir())
    assert [frame.name for frame in frames] == sorted(frame.name for frame in (other / "frames").iterdir())
    different = []
    for frame in frames:
        with xr.open_dataset(frame) as a, xr.open_dataset(other / "frames" / frame.name) as b:
            different += [frame.name for _ in compare(a, b, ("component",))]
    return different


def poison(monkeypatch: pytest.MonkeyPatch, name: str, step: int) -> None:
    """Have the job started with the poisoned worker."""
    place = str(Path(__file__).with_name("poisoned_worker.py"))

    def start_poisoned(ranks: int, program: list[str]) -> list[str]:
        assert program[1:3] == ["-m", "fbcouple.worker"]
        return mpi_command(ranks, [program[0], place, name, str(step), *program[3:]])

    monkeypatch.setattr(fbcouple.launch, "mpi_command", start_poisoned)


def start(run: Path, *words: str) -> subprocess.Popen:
    """`fbcouple run` in a process of its own; without what MPI, once started in this process, told the environment."""
    command = [sys.executable, "-m", "fbcouple.cli", "run", str(run), *words]
    return subprocess.Popen(command, env={**os.environ}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def await_checkpoint(run: Path, parent: subprocess.Popen) -> None:
    limit = time.monotonic() + 60
    while not list((run / "checkpoints").glob("step-*")):
        assert parent.poll() is None, parent.communicate()
        assert time.monotonic() < limit, "no checkpoint within a minute"
        time.sleep(0.01)


def find_ranks(run: Path) -> list[int]:
    """Process numbers of the ranks of `run`."""
    pattern = f"^[^ ]*python[^ ]* -m fbcouple.worker {run}"
    found = subprocess.run(["pgrep", "-f", pattern], capture_output=True, text=True, check=False)
    return [int(number) for number in found.stdout.split()]
