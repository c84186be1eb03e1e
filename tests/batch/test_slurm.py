"""The job scripts in a real SLURM of one node, with the real solvers."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import xarray as xr

from tests.batch.slurm_box import open_slurm
from tests.batch.slurm_jobs import CASE, await_end, call, hand_in, is_complete

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def slurm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    with open_slurm(tmp_path_factory.mktemp("slurm")) as environment:
        yield environment


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
    assert all("a job before ended with exit code 1" in path.read_text() for path in outputs[1:])


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
