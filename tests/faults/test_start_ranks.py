"""Runs whose start was made or read, of every kind: the same on 1, 2 and 4 ranks, and bit for bit over a kill."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from small_bed import BED, PATIENCE, await_true, compare_frames, find_differences, find_ranks, start_held

from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.bed.positions import start_kinds, start_positions
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
COLUMNS = "x y z vx vy vz omegax omegay omegaz"


def lay_out_bed(folder: Path, name: str, *sets: str, start: str = "[start]") -> Path:
    """A run folder of the bed with its start, beside the case."""
    (folder / "case.toml").write_text(BED.replace("[start]\n", f"{start}\n"))
    (run,) = lay_out(str(folder), folder / name, (*SETS, *sets), True, True)
    return run


def list_rows(folder: Path) -> list[list[str]]:
    """Kind, radius, density, place and motion of each particle of the bed on its lattice, thrown about at random: they
    meet within the first steps."""
    (folder / "case.toml").write_text(BED)
    case = load_case(str(folder), SETS)
    known = [
        (str(n), repr(kind.diameter / 2), repr(kind.density)) for n, kind in enumerate(list_kinds(case.particles), 1)
    ]
    places = start_positions(case, folder)
    motion = np.random.default_rng(1).normal(size=(len(places), 6)) * ([0.2] * 3 + [50.0] * 3)
    rows = np.hstack([places, motion]).tolist()
    return [[*known[kind], *map(repr, row)] for kind, row in zip(start_kinds(case, folder), rows, strict=True)]


def write_table(folder: Path) -> str:
    rows = "".join(f"{','.join(row)}\n" for row in list_rows(folder))
    (folder / "bed.csv").write_text(f"kind,radius,density,{COLUMNS.replace(' ', ',')}\n{rows}")
    return "particles.positions=bed.csv"


def write_dump(folder: Path) -> str:
    """As several ranks write it: in another order than that of the ids."""
    rows = [f"{n} {' '.join(row)}\n" for n, row in enumerate(list_rows(folder), 1)]
    head = f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{len(rows)}\nITEM: BOX BOUNDS ff ff ff\n0 .01\n0 .006\n0 .02\n"
    text = f"{head}ITEM: ATOMS id type radius density {COLUMNS}\n{''.join(rows[1::2] + rows[::2])}"
    (folder / "bed.dump").write_text(text)
    return "particles.positions=bed.dump"


def write_data(folder: Path) -> str:
    rows = list_rows(folder)
    atoms = [f"{n} {row[0]} {2 * float(row[1])!r} {' '.join([row[2], *row[3:6]])}\n" for n, row in enumerate(rows, 1)]
    moved = "".join(f"{n} {' '.join(row[6:])}\n" for n, row in enumerate(rows, 1))
    text = f"by hand\n\n{len(rows)} atoms\n\n0 .01 xlo xhi\n0 .006 ylo yhi\n0 .02 zlo zhi\n\nAtoms\n\n{''.join(atoms)}"
    (folder / "bed.data").write_text(f"{text}\nVelocities\n\n{moved}")
    return "particles.positions=bed.data"


@cache
def run_source(folder: Path) -> Path:
    """A run to its end, of a bed whose particles move, spin and touch then."""
    run = lay_out_bed(folder, "run", "end_time=4e-3", "gas.inlet_velocity=2.0")
    launch(run, 1, lambda row: None)
    return run


def copy_restart(folder: Path) -> str:
    """LIGGGHTS' own restart file, of the run's newest checkpoint, as if it were anybody's."""
    newest = list_checkpoints(run_source(folder.parent))[0]
    shutil.copyfile(newest / "liggghts.restart", folder / "bed.restart")
    return "start.restart=bed.restart"


STARTS: dict[str, Callable[[Path], str]] = {
    "table": write_table,
    "dump": write_dump,
    "data": write_data,
    "checkpoint": lambda folder: f"start.run={run_source(folder.parent)}",
    "frame": lambda folder: f"start.run={run_source(folder.parent)}\nstart.time=2e-3",
    "restart": copy_restart,
    "pour": lambda folder: "start.method=pour",
}
FAST = ("dump",)


class Beds:
    """Runs from one kind of start, in `folder`."""

    def __init__(self, folder: Path, name: str) -> None:
        folder.mkdir()
        self._folder, self._sets = folder, STARTS[name](folder).split("\n")

    def prepare(self, name: str) -> Path:
        start = "" if "positions" in self._sets[0] else "[start]"
        return lay_out_bed(self._folder, name, *self._sets, start=start)

    @cache  # noqa: B019  (as long as the module's tests)
    def run(self, ranks: int) -> Path:
        """The run to its end on so many ranks."""
        run, rows = self.prepare(f"n{ranks}"), list[dict]()
        launch(run, ranks, rows.append)
        assert rows[-1]["steps"] >= 20
        return run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where all runs lie; poured beds are kept there, too."""
    folder = tmp_path_factory.mktemp("starts")
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(starts, "cache_folder", lambda: folder / "cache")
        yield folder


@pytest.fixture(
    scope="module", params=[name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in STARTS]
)
def beds(request, folder):
    return Beds(folder / request.param, request.param)


@pytest.mark.parametrize("ranks", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_ranks_do_not_change_what_becomes_of_a_start(beds, ranks):
    with (
        xr.open_dataset(beds.run(1) / "results.nc") as one,
        xr.open_dataset(beds.run(ranks) / "results.nc") as many,
    ):
        for name in FIELDS:
            apart, scale = np.abs(one[name] - many[name]).max(), np.abs(one[name]).max()
            assert scale > 0 and apart < 1e-9 * scale, name


def test_killed_and_resumed_run_is_the_uninterrupted_one(beds):
    """All ranks are killed while a checkpoint is written; the run goes on from the one before."""
    run = beds.prepare("killed")
    job = start_held(run, "finish", 3, "-n", "2")
    for rank in find_ranks(run):
        os.kill(rank, signal.SIGKILL)
    job.communicate(timeout=PATIENCE)
    await_true(lambda: not find_ranks(run))
    assert job.returncode == 3 and not (run / "results.nc").exists()
    launch(run, 2, lambda row: None, resume=True)
    assert find_differences(beds.run(2), run) == [] and compare_frames(beds.run(2), run) == []
