"""Runs as jobs of a SLURM: a small bed, handed in and waited for."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path

import xarray as xr
from click.testing import CliRunner

from fbcouple.cli.main import cli

GOES_ON = ("running", "75")
QUIET = 10
"""Seconds without a job in the queue after which none will come back: a job that is being requeued is in no list."""

CASE = """
title = "fifty particles"
end_time = 2e-3
[domain]
size = [0.008, 0.008, 0.02]
cells = [2, 2, 5]
[gas]
density = 1.2
viscosity = 2e-5
inlet_velocity = 0.5
[particles]
diameter = 1e-3
density = 2500.0
count = 50
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
"""


def call(*arguments: object) -> None:
    done = CliRunner().invoke(cli, [str(argument) for argument in arguments])
    assert done.exit_code == 0, done.output


def hand_in(place: Path, environment: dict[str, str]) -> None:
    script = [str(place / "batch/submit-slurm.sh")]
    done = subprocess.run(script, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def list_jobs(environment: dict[str, str]) -> list[str]:
    """Number, state and start of each job that is not over."""
    command = ["squeue", "-h", "-o", "%i %T %S"]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.splitlines()


def await_end(environment: dict[str, str], seconds: float, left: Path | None = None) -> int:
    """Wait until no job is left; a requeued job does not wait for its delay. Returns: how often one was requeued.

    left: the file in which a job leaves what became of its run; while it says that the run goes on, a job is on its
    way back into the queue, however long a busy machine takes for it."""
    deadline, delayed, quiet = time.monotonic() + seconds, 0, 0
    while quiet < QUIET:
        jobs = list_jobs(environment)
        comes_back = left is not None and left.exists() and left.read_text().strip() in GOES_ON
        quiet = 0 if jobs or comes_back else quiet + 1
        assert time.monotonic() < deadline, jobs
        for number, state, start in (line.split(maxsplit=2) for line in jobs):
            if state == "PENDING" and start not in ("N/A", "now"):
                change = ["scontrol", "update", f"JobId={number}", "StartTime=now"]
                delayed += subprocess.run(change, env=environment, capture_output=True, check=False).returncode == 0
        time.sleep(1.0)
    return delayed


def is_complete(run: Path) -> bool:
    with xr.open_dataset(run / "results.nc") as results:
        return bool(results.attrs["complete"])
