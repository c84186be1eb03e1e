"""A run that was stopped and resumed is the uninterrupted one: bit for bit on as many ranks, to rounding on others."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from small_bed import compare_frames, find_differences, prepare, stop_at_next_moment

from fbcouple.launcher.launch import launch
from fbcouple.run_folder.plain_files import require_plain


def run_through(run: Path, ranks: int = 1) -> list[dict]:
    rows: list[dict] = []
    launch(run, ranks, rows.append)
    return rows


def run_with_stops(run: Path, *ranks: int) -> list[dict]:
    """Stop at the first moment on each of `ranks` but the last, on which the run ends."""
    rows: list[dict] = []
    for number in ranks[:-1]:
        stop_at_next_moment(run, number, rows)
    launch(run, ranks[-1], rows.append, resume=True)
    return rows


@pytest.mark.parametrize("ranks", [1, 2])
def test_resumed_run_is_the_uninterrupted_one(tmp_path, ranks):
    one, other = prepare(tmp_path / "one"), prepare(tmp_path / "other")
    rows = run_through(one, ranks)
    resumed = run_with_stops(other, ranks, ranks, ranks)
    assert find_differences(one, other) == [] and compare_frames(one, other) == []
    assert len(list((other / "frames").iterdir())) == 6
    assert [{**row, "wall": 0} for row in rows] == [{**row, "wall": 0} for row in resumed]
    assert len((other / "logs/run.jsonl").read_text().splitlines()) == len(rows)
    with xr.open_dataset(other / "results.nc") as results:
        assert results.attrs["complete"] == 1 and len(results["snapshot_time"]) > 5
        assert results["tracked"].values.tolist() == [7, 250] and np.ptp(results["tracked_position"].values[:, 1, 2])


@pytest.mark.parametrize("sets", [(), ("averages.until_error=1e-9", "averages.blocks=8")])
def test_blocks_of_the_solids_make_the_means(tmp_path, sets):
    """Also of a run that was stopped; the last block need not be full."""
    run = prepare(tmp_path / "run", sets)
    run_with_stops(run, 1, 2)
    with xr.open_dataset(run / "results.nc") as results:
        samples = results["block_samples"].astype(float)
        assert samples.sum() == results.attrs["averaging_samples"] and len(samples) > 1
        starts = results["block_start"].values
        assert (np.diff(starts) > 0.0).all() and starts[0] >= results.attrs["averaging_start"]
        for name in ("solids_fraction", "solids_flux"):
            blocks, mean = results[f"block_{name}"], results[name].mean("y")
            apart = (blocks * samples).sum("block") / samples.sum() - mean
            assert float(np.abs(apart).max()) < 1e-6 * float(np.abs(mean).max())


def test_frames_that_came_after_the_checkpoint_are_taken_again(tmp_path):
    """A run that went on without a checkpoint has frames that its history does not know any more."""
    run, other = prepare(tmp_path / "run"), prepare(tmp_path / "other")
    run_through(other)
    stop_at_next_moment(run, 1, [])
    late = run / "frames/frame-000099.nc"
    late.write_bytes(b"of a moment after the checkpoint")
    (run / "frames/frame-000099.nc.part").write_bytes(b"half of one")
    launch(run, 1, lambda row: None, resume=True)
    assert not late.exists() and compare_frames(run, other) == []


@pytest.mark.parametrize("phase", ["gas", "particles"])
def test_one_phase(tmp_path, phase):
    """Without gas OpenFOAM, without particles LIGGGHTS has no part in a checkpoint."""
    left = {"gas": ("[gas]", "[domain]", "[output]"), "particles": ("[particles]", "[contact]", "[start]", "[domain]")}
    text = "".join(keep_sections((*left[phase], "[averages]", "[output]", "[checkpoint]", "title")))
    one, other = prepare(tmp_path / "one", text=text), prepare(tmp_path / "other", text=text)
    run_through(one)
    run_with_stops(other, 1, 1)
    assert find_differences(one, other) == []
    newest = max((other / "checkpoints").iterdir())
    assert (newest / "CFD").exists() == (phase == "gas")
    assert (newest / "liggghts.restart").exists() == (phase == "particles")


def keep_sections(names: tuple[str, ...]):
    from small_bed import BED  # noqa: PLC0415

    both = "snapshots_every = 1e-3\n", "particles_every = 2e-3\n", "tracked = [7, 250]\n"
    text = BED
    for line in both:
        text = text.replace(line, "")
    for part in text.replace("\n[", "\n\0[").split("\0"):
        if part.strip().startswith(names):
            yield part


def test_other_ranks_give_the_same_to_rounding(tmp_path):
    exact = ["gas.pressure_tolerance=1e-13", "end_time=5e-3"]
    one, other = prepare(tmp_path / "one", exact), prepare(tmp_path / "other", exact)
    run_through(one)
    run_with_stops(other, 2, 1, 2)
    require_plain(other)  # decomposePar makes links unless it is told not to
    with xr.open_dataset(one / "results.nc") as a, xr.open_dataset(other / "results.nc") as b:
        assert b.attrs["ranks"] == 2
        for name in ("solids_fraction", "solids_flux", "gas_flux", "pressure", "solids_centre_z", "pressure_drop"):
            scale = float(np.nanmax(np.abs(a[name])))
            difference = float(np.nanmax(np.abs(a[name] - b[name])))
            print(f"{name}: {difference / scale:.1e}")
            assert difference < 1e-9 * scale, name


def test_stopped_by_until_and_resumed_is_the_uninterrupted_one(tmp_path):
    """It stops where an uninterrupted run has a moment for a checkpoint, and no step is cut short."""
    one, other = prepare(tmp_path / "one"), prepare(tmp_path / "other")
    whole = run_through(one)
    rows: list[dict] = []
    launch(other, 1, rows.append, until=4e-3)
    with xr.open_dataset(other / "results.nc") as results:
        assert results.attrs["complete"] == 0
    (newest,) = (other / "checkpoints").iterdir()
    step = int(newest.name.removeprefix("step-"))
    assert step % 5 == 0 and json.loads((newest / "state.json").read_text())["clock"]["time"] >= 4e-3 * (1 - 1e-9)
    assert all(row["time"] < 4e-3 for row in whole if row["steps"] < step - 5)
    launch(other, 1, rows.append, resume=True, until=3e-3)  # there already
    launch(other, 1, rows.append, resume=True)
    assert [row["time"] for row in rows] == [row["time"] for row in whole]
    assert find_differences(one, other) == []


def test_other_moments_may_follow_a_checkpoint(tmp_path):
    """The next moment's flux is measured from what the checkpoint has of the gas, not from a gas without particles."""
    sets = ["checkpoint.moment_steps=7", "checkpoint.every=1e-4", "output.record_every=2e-3", "end_time=6e-3"]
    run = prepare(tmp_path, sets)
    launch(run, 1, lambda row: None, until=3e-3)
    case = run / "case.toml"
    case.write_text(case.read_text().replace("moment_steps = 7", "moment_steps = 11"))
    launch(run, 1, lambda row: None, resume=True)
    with xr.open_dataset(run / "results.nc") as results:
        assert results.attrs["complete"] == 1 and np.nanmax(results["gas_flux_error"]) < 1e-3


def test_a_run_that_is_done_is_not_run_again(tmp_path):
    run = prepare(tmp_path, ["end_time=2e-3", "checkpoint.every=5e-4", "averages.start=0.0"])
    run_through(run)
    assert len(list((run / "checkpoints").iterdir())) == 2
    before = (run / "results.nc").stat().st_mtime_ns
    said: list[str] = []
    launch(run, 1, lambda row: None, resume=True, say=said.append)
    assert (run / "results.nc").stat().st_mtime_ns == before and "is complete" in said[-1]


def test_a_run_that_is_done_goes_on_to_a_later_end(tmp_path):
    """A later end in the case of the run: the rows, samples and checks go on; nothing is taken again."""
    run = prepare(tmp_path, ["end_time=6e-3"])
    rows = run_through(run)
    with xr.open_dataset(run / "results.nc") as results:
        short = results.load()
    case = run / "case.toml"
    case.write_text(case.read_text().replace("end_time = 0.006", "end_time = 0.01"))
    launch(run, 1, rows.append, resume=True)
    times = [row["time"] for row in rows]
    assert times == sorted(set(times)) and times[-1] == pytest.approx(0.01, abs=1e-4)
    with xr.open_dataset(run / "results.nc") as long:
        assert long.attrs["complete"] == 1 and long.attrs["averaging_end"] == times[-1]
        assert (long["time"].values == times).all()
        before = len(short["time"])
        assert (long["solids_centre_z"].values[:before] == short["solids_centre_z"].values).all()
        assert float(long["momentum_error"].max()) < 1e-10
        assert long["solids_volume"].values == pytest.approx(long.attrs["solids_volume"], rel=1e-12)
        scale = float(np.nanmax(np.abs(long["solids_flux"])))
        assert np.nanmax(np.abs(long["solids_flux"] - short["solids_flux"])) > 0.1 * scale, "the means went on"


def test_other_moments_are_told_and_noted(tmp_path):
    """LIGGGHTS is then set up anew at other steps, and a chaotic bed is another to rounding."""
    run = prepare(tmp_path / "run", ["end_time=4e-3", "output.record_every=4e-4"])
    stop_at_next_moment(run, 1, [])
    said: list[str] = []
    launch(run, 1, lambda row: None, resume=True, until=2e-3, say=said.append)
    assert not any("moment_steps" in line for line in said)
    launch(run, 1, lambda row: None, resume=True, sets=["checkpoint.moment_steps=7"], say=said.append)
    words = "s on: checkpoint.moment_steps was 5 and is 7 now, equal to an uninterrupted run up to rounding"
    assert sum(line.startswith(f"{run}: warning: from t = ") and words in line for line in said) == 1
    with xr.open_dataset(run / "results.nc") as results:
        assert words in results.attrs["updates"]
