"""Runs whose start was made or read, of every kind: the same on 1, 2 and 4 ranks, and bit for bit over a kill."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from small_bed import BED, PATIENCE, await_true, compare_frames, find_differences, find_ranks, start_held

from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.bed.positions import start_kinds, start_motion, start_positions
from fbcouple.case.load import load_case
from fbcouple.decks import starts
from fbcouple.decks.set_up import lay_out
from fbcouple.launcher.launch import launch
from fbcouple.run_folder.checkpoint import list_checkpoints

FIELDS = ("solids_fraction", "solids_flux", "voidage", "gas_velocity", "gas_flux", "pressure")
SETS = (
    "particles.mixture=[[0.7e-3, 4000.0, 0.3]]",
    "particles.rotation=true",
    "contact.tangential=history",
    "gas.pressure_tolerance=1e-13",
    "gas.max_step=5e-5",
    "end_time=1.2e-3",
    "averages.start=0.0",
    "averages.every=1e-5",
    "output.particles_every=2e-4",
    "output.record_every=5e-5",
    "checkpoint.moment_steps=1",
    "checkpoint.every=2e-4",
)
RANKS = (1, 2, 4)
COLUMNS = "x y z vx vy vz omegax omegay omegaz"


def lay_out_bed(folder: Path, name: str, *sets: str, start: str = "[start]") -> Path:
    """A run folder of the bed with its start, beside the case."""
    (folder / "case.toml").write_text(BED.replace("[start]\n", f"{start}\n"))
    (run,) = lay_out(str(folder), folder / name, (*SETS, *sets), True, True)
    return run


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """A run to its end, of a bed whose particles move, spin and touch then."""
    run = lay_out_bed(tmp_path_factory.mktemp("source"), "run", "end_time=4e-3", "gas.inlet_velocity=2.0")
    launch(run, 1, lambda row: None)
    return run


def list_rows(source: Path) -> list[list[str]]:
    """Kind, radius, density, place and motion of each particle at the end of that run, with every digit."""
    run = lay_out_bed(source.parent, "taken", f"start.run={source}")
    case = load_case(str(run))
    kinds = start_kinds(case, run)
    known = [
        (str(n), repr(kind.diameter / 2), repr(kind.density)) for n, kind in enumerate(list_kinds(case.particles), 1)
    ]
    motion = start_motion(case, run)
    assert motion is not None and np.abs(motion).max(axis=0).min() > 1e-3
    places = np.hstack([start_positions(case, run), motion]).tolist()
    return [[*known[kind], *map(repr, row)] for kind, row in zip(kinds, places, strict=True)]


def write_table(source: Path, folder: Path) -> str:
    rows = "".join(f"{','.join(row)}\n" for row in list_rows(source))
    (folder / "bed.csv").write_text(f"kind,radius,density,{COLUMNS.replace(' ', ',')}\n{rows}")
    return "particles.positions=bed.csv"


def write_dump(source: Path, folder: Path) -> str:
    """As several ranks write it: in another order than that of the ids."""
    rows = [f"{n} {' '.join(row)}\n" for n, row in enumerate(list_rows(source), 1)]
    head = f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{len(rows)}\nITEM: BOX BOUNDS ff ff ff\n0 .01\n0 .006\n0 .02\n"
    text = f"{head}ITEM: ATOMS id type radius density {COLUMNS}\n{''.join(rows[1::2] + rows[::2])}"
    (folder / "bed.dump").write_text(text)
    return "particles.positions=bed.dump"


def write_data(source: Path, folder: Path) -> str:
    rows = list_rows(source)
    atoms = "".join(
        f"{n} {row[0]} {2 * float(row[1])!r} {' '.join([row[2], *row[3:6]])}\n" for n, row in enumerate(rows, 1)
    )
    moved = "".join(f"{n} {' '.join(row[6:])}\n" for n, row in enumerate(rows, 1))
    text = f"by hand\n\n{len(rows)} atoms\n\n0 .01 xlo xhi\n0 .006 ylo yhi\n0 .02 zlo zhi\n\nAtoms\n\n{atoms}"
    (folder / "bed.data").write_text(f"{text}\nVelocities\n\n{moved}")
    return "particles.positions=bed.data"


def copy_restart(source: Path, folder: Path) -> str:
    """LIGGGHTS' own restart file, of the run's newest checkpoint, as if it were anybody's."""
    newest = list_checkpoints(source)[0]
    shutil.copyfile(newest / "liggghts.restart", folder / "bed.restart")
    return "start.restart=bed.restart"


STARTS: dict[str, Callable[[Path, Path], str]] = {
    "table": write_table,
    "dump": write_dump,
    "data": write_data,
    "checkpoint": lambda source, folder: f"start.run={source}",
    "frame": lambda source, folder: f"start.run={source}\nstart.time=2e-3",
    "restart": copy_restart,
    "pour": lambda source, folder: "start.method=pour",
}
FAST = ("dump",)


@pytest.fixture(
    scope="module", params=[name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in STARTS]
)
def beds(request, source, tmp_path_factory):
    """Set a run up from that start, by name; those that ran to their end on so many ranks."""
    folder = tmp_path_factory.mktemp(request.param)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(starts, "cache_folder", lambda: folder / "cache")
        sets = STARTS[request.param](source, folder).split("\n")

        def prepare(name: str) -> Path:
            return lay_out_bed(folder, name, *sets, start="" if "positions" in sets[0] else "[start]")

        runs = {ranks: prepare(f"n{ranks}") for ranks in RANKS}
        rows: list[dict] = []
        for ranks, run in runs.items():
            launch(run, ranks, rows.append)
        assert rows[-1]["steps"] >= 20
        yield prepare, runs


@pytest.mark.parametrize("ranks", RANKS[1:])
def test_ranks_do_not_change_what_becomes_of_a_start(beds, ranks):
    _, runs = beds
    with xr.open_dataset(runs[1] / "results.nc") as one, xr.open_dataset(runs[ranks] / "results.nc") as many:
        for name in FIELDS:
            apart, scale = np.abs(one[name] - many[name]).max(), np.abs(one[name]).max()
            assert scale > 0 and apart < 1e-9 * scale, name


def test_killed_and_resumed_run_is_the_uninterrupted_one(beds):
    """All ranks are killed while a checkpoint is written; the run goes on from the one before."""
    prepare, runs = beds
    run = prepare("killed")
    job = start_held(run, "finish", 3, "-n", "2")
    for rank in find_ranks(run):
        os.kill(rank, signal.SIGKILL)
    job.communicate(timeout=PATIENCE)
    await_true(lambda: not find_ranks(run))
    assert job.returncode == 3 and not (run / "results.nc").exists()
    launch(run, 2, lambda row: None, resume=True)
    assert find_differences(runs[2], run) == [] and compare_frames(runs[2], run) == []
