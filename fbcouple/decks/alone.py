"""LIGGGHTS alone, on one rank and in a process of its own, on the deck of a case without its gas.

One rank, so that what comes out is the same whoever asks for it.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.region import read_mesh
from fbcouple.case.schema.sections import Case
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import find_box, format_particles, render_decks
from fbcouple.errors import SolverError
from fbcouple.geometry.stl import list_walls, write_surface
from fbcouple.machine.environment import mpi_environment
from fbcouple.paths import START, WALLS

_MODULE = "fbcouple.simulation.liggghts_alone"
_DECK, _TASK, _PARTICLES, _RESTART = "DEM/in.liggghts", "task.json", "particles.npz", "particles.restart"
_LOOK = re.compile(r"(\d+) ([\d.e+-]+)")
_SHOWN = 5
"""Last lines of a process that failed."""


@dataclass(frozen=True)
class Particles:
    """Of each particle: centre [m] (n, 3), velocities [m/s] and angular velocities [rad/s] (n, 6), kind from 0 (n,);
    temperature [K] (n,), None where it is not known."""

    positions: np.ndarray
    motion: np.ndarray
    kinds: np.ndarray
    temperatures: np.ndarray | None = None


@dataclass(frozen=True)
class Rest:
    """Until when particles settle: root mean square of their speeds, and a hundredth of the fastest, below `speed`
    [m/s], within `most` DEM steps; looked at after `every`."""

    speed: float
    most: int
    every: int


@dataclass(frozen=True)
class Outcome:
    """Particles in the order of their numbers, DEM steps that were taken, speed [m/s] to be held against `Rest`."""

    particles: Particles
    steps: int
    speed: float


Watch = Callable[[int, float], None]
"""Is given the DEM steps taken so far, and the speed [m/s]."""


def settle(case: Case, folder: Path, start: Particles, rest: Rest, watch: Watch = lambda steps, speed: None) -> Outcome:
    """What becomes of the particles `start` in the region of `case`, whose own files lie in `folder`, without gas.

    Raises: SolverError with the words of LIGGGHTS if it fails, or loses a particle.
    """
    with tempfile.TemporaryDirectory(prefix="fbcouple-settle-") as name:
        directory, dry = Path(name), remove_gas(case)
        _lay_out(dry, folder, directory, start)
        task = {"restart": None, "rest": rest.speed, "most": rest.most, "every": rest.every}
        found = _run(directory, task, watch)
    outcome = Outcome(_pick(found), int(found["steps"]), float(found["speed"]))
    if len(outcome.particles.positions) != len(start.positions):
        lost = len(start.positions) - len(outcome.particles.positions)
        raise SolverError(f"LIGGGHTS lost {lost} particles while they settled; give a stiffer contact or more steps")
    return outcome


def read_restart(case: Case, folder: Path, restart: Path) -> Particles:
    """The particles in `restart`, which LIGGGHTS wrote in a run of `case` and only LIGGGHTS reads: it is not checked.

    Raises: SolverError with the words of LIGGGHTS if it fails.
    """
    with tempfile.TemporaryDirectory(prefix="fbcouple-restart-") as name:
        directory = Path(name)
        _lay_out(_keep_temperatures(case), folder, directory, None)
        shutil.copyfile(restart, directory / _RESTART)
        return _pick(_run(directory, {"restart": _RESTART, "rest": None}, lambda steps, speed: None))


def read_foreign_restart(restart: Path) -> dict[str, np.ndarray]:
    """Columns `positions`, `velocities`, `spins` (n, 3), `types` from 1, `radii`, `densities` (n,) of the particles in
    `restart`, which LIGGGHTS wrote in a run of anybody: it is not checked.

    Raises: SolverError with the words of LIGGGHTS if it fails.
    """
    with tempfile.TemporaryDirectory(prefix="fbcouple-restart-") as name:
        directory = Path(name)
        (directory / "DEM").mkdir()
        (directory / _DECK).write_text(f"read_restart    {_RESTART}\n", encoding="utf-8")
        shutil.copyfile(restart, directory / _RESTART)
        return _run(directory, {"restart": None, "rest": None}, lambda steps, speed: None)


def remove_gas(case: Case) -> Case:
    """The case with its particles alone, and no heat."""
    return case.model_copy(update={"gas": None, "exchange": None, "averages": None, "heat": None})


def _keep_temperatures(case: Case) -> Case:
    """The case with its particles alone, and a place for their temperatures if they have some."""
    held = {"contact_conduction": "none", "conduction_modulus": None, "bed_conduction": "none"}
    heat = case.heat.model_copy(update=held) if case.heat else None
    return remove_gas(case).model_copy(update={"heat": heat})


def _lay_out(dry: Case, folder: Path, directory: Path, start: Particles | None) -> None:
    (directory / "DEM").mkdir()
    (directory / _DECK).write_text(render_decks(dry, folder)[_DECK], encoding="utf-8")
    mesh = None if dry.domain.is_plain_box else read_mesh(dry, folder)
    if mesh and find_needs(dry)["surface_walls"]:
        (directory / WALLS).write_text("".join(write_surface(list_walls(mesh))), encoding="utf-8")
    if start is not None:
        lines = format_particles(dry, start.positions, start.kinds, find_box(dry, mesh), start.motion)
        (directory / START).write_text("".join(lines), encoding="utf-8")


def _pick(found: dict[str, np.ndarray]) -> Particles:
    motion = np.hstack([found["velocities"], found["spins"]])
    return Particles(found["positions"], motion, found["types"].astype(int) - 1, found.get("temperatures"))


def _run(directory: Path, task: dict[str, Any], watch: Watch) -> dict[str, np.ndarray]:
    """Do the task in a process of its own; the arrays that it writes."""
    (directory / _TASK).write_text(json.dumps(task), encoding="utf-8")
    environment = mpi_environment() | {"PWD": str(directory)}
    words = directory / "words.log"
    with words.open("w", encoding="utf-8") as errors:
        command = [sys.executable, "-m", _MODULE, str(directory)]
        options: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": errors}
        with subprocess.Popen(
            command, cwd=directory, env=environment, encoding="utf-8", errors="replace", **options
        ) as child:
            assert child.stdout is not None
            try:
                for line in child.stdout:
                    if told := _LOOK.fullmatch(line.strip()):
                        watch(int(told[1]), float(told[2]))
            except BaseException:
                child.kill()
                raise
    if child.returncode or not (directory / _PARTICLES).is_file():
        lines = _read_lines(directory / "liggghts.log")
        last = [line for line in lines if "ERROR" in line][-1:] or _read_lines(words)[-_SHOWN:]
        raise SolverError(f"LIGGGHTS alone ended with exit code {child.returncode}: {' / '.join(last)[:500]}")
    with np.load(directory / _PARTICLES) as found:
        return dict(found)


def _read_lines(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8", errors="replace").strip().splitlines() if path.is_file() else []
