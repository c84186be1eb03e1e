"""The small bed that the fault matrix breaks: 250 particles above a gas mesh of 150 cells, 100 coupling steps or so."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import fbcouple.launcher.launch
from fbcouple.case.load import load_case
from fbcouple.decks.render import set_up
from fbcouple.machine.launchers import mpi_command

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
[[output.probes]]
name = "tap"
points = [[0.005, 0.003, 0.001], [0.0, 0.006, 0.003]]
quantities = ["pressure", "solids_velocity"]
every = 1e-4
[[output.probes]]
name = "axis"
line = [[0.005, 0.003, 0.0], [0.005, 0.003, 0.02]]
count = 5
quantities = ["gas_flux"]
every = 7e-4
start = 4e-4
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


def stop_at_next_moment(run: Path, ranks: int, rows: list[dict]) -> None:
    """Start the run, or go on with it, up to the first moment for a checkpoint that comes; `rows` gets its history."""
    steps = [int(place.name.removeprefix("step-")) for place in (run / "checkpoints").glob("step-*")]
    newest = run / f"checkpoints/step-{max(steps, default=0):012d}/state.json"
    time = json.loads(newest.read_text())["clock"]["time"] if steps else 0.0
    fbcouple.launcher.launch.launch(run, ranks, rows.append, resume=True, until=time + 1e-9)


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
        assert program[1:3] == ["-m", "fbcouple.simulation.worker"]
        return mpi_command(ranks, [program[0], place, name, str(step), *program[3:]])

    monkeypatch.setattr(fbcouple.launcher.launch, "mpi_command", start_poisoned)


PATIENCE = 600.0
"""Wall time [s] that a test waits for what must come, on a machine that does much else."""


STARTED: list[subprocess.Popen] = []
"""What the test under way has started."""


def end_started() -> None:
    """Leave nothing behind where a test failed: the job of a killed parent ends by itself."""
    while STARTED:
        job = STARTED.pop()
        if job.poll() is None:
            job.kill()
            job.communicate()


def start(run: Path, *words: str) -> subprocess.Popen:
    """`fbcouple run` in a process of its own; without what MPI, once started in this process, told the environment."""
    return start_program(["-m", "fbcouple.cli.main", "run"], run, *words)


def start_held(run: Path, where: str, number: int, *words: str) -> subprocess.Popen:
    """`fbcouple run` that waits at a step or in a checkpoint until a signal comes; returns when it is there."""
    job = start_to_hold(run, where, number, *words)
    await_true(lambda: list(run.glob("held-*")), job)
    return job


def start_to_hold(run: Path, where: str, number: int, *words: str) -> subprocess.Popen:
    """The same, without waiting until it is there."""
    return start_program([str(Path(__file__).with_name("held_run.py")), where, str(number)], run, *words)


def start_program(program: list[str], run: Path, *words: str) -> subprocess.Popen:
    command = [sys.executable, *program, str(run), *words]
    STARTED.append(
        subprocess.Popen(command, env={**os.environ}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    )
    return STARTED[-1]


def await_true(is_so: Callable[[], object], job: subprocess.Popen | None = None) -> None:
    """Wait until something is so; fail if it is not in time, or if the job is over before."""
    limit = time.monotonic() + PATIENCE
    while not is_so():
        assert job is None or job.poll() is None, job.communicate()
        assert time.monotonic() < limit, "it did not come about in time"
        time.sleep(0.005)


def find_ranks(run: Path) -> list[int]:
    """Process numbers of the ranks of `run`."""
    pattern = f"^[^ ]*python[^ ]* (-m fbcouple.simulation.worker|[^ ]*/held_worker.py [a-z]+ [0-9]+) {run}"
    found = subprocess.run(["pgrep", "-f", pattern], capture_output=True, text=True, check=False)
    return [int(number) for number in found.stdout.split()]
