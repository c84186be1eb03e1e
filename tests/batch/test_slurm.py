"""The job scripts in a real SLURM, with the real solvers."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import xarray as xr
from click.testing import CliRunner

from fbcouple.cli.main import cli
from tests.batch.slurm_box import open_slurm

pytestmark = pytest.mark.slow

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


@pytest.fixture(scope="module")
def slurm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    with open_slurm(tmp_path_factory.mktemp("slurm")) as environment:
        yield environment


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


def test_array_job_does_every_run(slurm, tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    for name in ("a", "b"):
        call("setup", tmp_path / "case.toml", "-o", tmp_path / "set" / name)
    call("batch", tmp_path / "set", "--scheduler", "slurm", "--time", "00:10:00", "--memory", 900)
    hand_in(tmp_path / "set", slurm)
    await_end(slurm, 240.0)
    for name in ("a", "b"):
        words = [path.read_text() for path in (tmp_path / "set/batch").glob("slurm-*.out")]
        assert (tmp_path / "set" / name / "batch/state").read_text() == "0\n", words
        assert is_complete(tmp_path / "set" / name)


def test_failed_run_ends_its_chain(slurm, tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    call("setup", tmp_path / "case.toml", "-o", tmp_path / "run")
    deck = tmp_path / "run/DEM/in.liggghts"
    deck.write_text(deck.read_text() + "nonsense\n")
    call("batch", tmp_path / "run", "--scheduler", "slurm", "--time", "00:10:00", "--memory", 900, "--chain", 3)
    hand_in(tmp_path / "run", slurm)
    await_end(slurm, 120.0)
    assert (tmp_path / "run/batch/state").read_text() == "1\n"
    outputs = sorted((tmp_path / "run/batch").glob("slurm-*.out"))
    assert len(outputs) == 3 and "in.liggghts" in outputs[0].read_text()
    assert [path.read_text() for path in outputs[1:]] == ["", ""]


def test_run_longer_than_its_limit_is_requeued_until_it_is_done(slurm, tmp_path):
    """A minute is SLURM's least limit; half of it before the notice is not enough for this run."""
    (tmp_path / "case.toml").write_text(CASE.replace("end_time = 2e-3", "end_time = 25.0"))
    call("setup", tmp_path / "case.toml", "-o", tmp_path / "run")
    wanted = ("--scheduler", "slurm", "--time", "00:01:00", "--notice", 30, "--memory", 900)
    call("batch", tmp_path / "run", *wanted)
    hand_in(tmp_path / "run", slurm)
    requeued = await_end(slurm, 3600.0, tmp_path / "run/batch/state")
    words = "".join(path.read_text() for path in (tmp_path / "run/batch").glob("slurm-*.out"))
    assert (tmp_path / "run/batch/state").read_text() == "0\n", words
    assert requeued >= 1 and is_complete(tmp_path / "run"), words
    with xr.open_dataset(tmp_path / "run/results.nc") as results:
        times = results["time"].values
        assert (times[1:] > times[:-1]).all() and times[-1] >= 25.0 * (1 - 1e-9)
        assert (results["particles"] == 50).all()
