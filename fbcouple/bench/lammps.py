"""The particles of a bed, without their gas, through LAMMPS beside LIGGGHTS: the same contacts, lists and DEM steps."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.derived import tangential_law
from fbcouple.case.bed.particle_types import largest_diameter
from fbcouple.case.schema.sections import Case
from fbcouple.decks.context import build_context
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import make_environment
from fbcouple.errors import SolverError
from fbcouple.machine.environment import mpi_environment
from fbcouple.machine.launchers import mpi_command
from fbcouple.machine.programs import run_program

PROGRAM = "lmp"
SETTLE = 20
"""DEM steps before those on the clock, in which either program makes its lists."""
_CONTACT = ("stiffnesses", "tangential_springs", "dampings", "tangential_dampings", "frictions")
"""LIGGGHTS' tables, the pair first and then the wall, in the order of gran/hooke."""
_DAMPED = 1
_TAIL = 12


def explain_absence(case: Case) -> str:
    """Why LAMMPS does not take part; empty if it does."""
    contact = case.contact
    assert contact is not None
    rotates = case.particles and case.particles.rotation
    if tangential_law(contact) != "no-history" or contact.rolling_friction or rotates:
        return "LAMMPS: its gran/hooke is for contacts without history, rolling friction and rotation: left out."
    if shutil.which(PROGRAM) is None:
        return "LAMMPS: lmp is not on the PATH: left out; fix: sudo apt-get install lammps"
    return ""


def write_lammps(case: Case, folder: Path, bed: np.ndarray, steps: int) -> None:
    """Put input and data into `folder`: `bed` (n, 6) is position [m] and velocity [m/s], `steps` what is timed."""
    particles = case.particles
    assert particles is not None
    context = build_context(case, find_needs(case), folder)
    pair, wall = ([*(context[name][k] for name in _CONTACT), _DAMPED] for k in (0, 1))
    context |= {"pair": pair, "wall": wall, "settle": SETTLE, "steps": steps}
    folder.mkdir()
    (folder / "in.bed").write_text(
        make_environment().get_template("peers/lammps/in.bed").render(context), encoding="utf-8"
    )
    box = "".join(f"0.0 {size!r} {axis}lo {axis}hi\n" for axis, size in zip("xyz", case.domain.size, strict=True))
    lines = [f"a bed\n\n{len(bed)} atoms\n1 atom types\n{box}\nAtoms # sphere\n\n"]
    kind = f"1 {largest_diameter(particles)!r} {particles.density!r}"
    lines += [f"{n} {kind} {x!r} {y!r} {z!r}\n" for n, (x, y, z) in enumerate(bed[:, :3].tolist(), 1)]
    lines += ["\nVelocities\n\n"]
    lines += [f"{n} {u!r} {v!r} {w!r} 0 0 0\n" for n, (u, v, w) in enumerate(bed[:, 3:].tolist(), 1)]
    (folder / "bed.data").write_text("".join(lines), encoding="utf-8")


def time_lammps(folder: Path, ranks: int) -> dict[str, Any]:
    """Run LAMMPS in `folder`; its particles and the wall seconds of the steps on the clock, as it tells them itself.

    Raises SolverError with its last words.
    """
    command = mpi_command(ranks, [PROGRAM, "-in", "in.bed", "-screen", "none", "-log", "log"])
    done = run_program(command, mpi_environment(), folder)
    log = (folder / "log").read_text(encoding="utf-8", errors="replace") if (folder / "log").exists() else ""
    loops = re.findall(r"Loop time of (\S+) on \d+ procs for (\d+) steps with (\d+) atoms", log)
    if done.returncode or len(loops) != 2:
        told = "\n".join((done.stdout + done.stderr + log).strip().splitlines()[-_TAIL:])
        raise SolverError(f"LAMMPS ended with code {done.returncode}:\n{told}")
    seconds, steps, particles = loops[1]
    version = log.partition("(")[2].partition(")")[0]
    return {
        "program": f"LAMMPS {version}", "steps": int(steps), "particles": int(particles), "seconds": float(seconds)
    }  # fmt: skip
