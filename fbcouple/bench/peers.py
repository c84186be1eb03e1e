"""The same bed through another CFD-DEM program, on the clock beside this one: stock DPMFoam."""

from __future__ import annotations

import math
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed import derived
from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.bed.streams import has_openings
from fbcouple.case.schema.sections import Case
from fbcouple.decks.render import make_environment
from fbcouple.errors import CaseError, SolverError
from fbcouple.machine.environment import mpi_environment
from fbcouple.machine.launchers import mpi_command

_TEMPLATES = "peers/dpmfoam"
_DECKS = (
    "0/U.air",
    "0/p",
    "constant/g",
    "constant/transportProperties",
    "constant/turbulenceProperties.air",
    "constant/kinematicCloudProperties",
    "constant/kinematicCloudPositions",
    "system/controlDict",
    "system/fvSchemes",
    "system/fvSolution",
)
_POISSON = 0.25
_IMPACT = 1.0
"""Impact speed [m/s] at which a Hertz contact of the peer is as long as a spring contact of the case."""
_TAIL = 12
NOT_COMPARABLE = (
    "DPMFoam: Hertz contacts as long as the case's at 1 m/s and rotation; drag of Ergun/Wen-Yu, particles at rest at "
    "the start; no pressure-gradient force, filter or sub-grid model; solids to the cell of the centre."
)


def check_peer(case: Case) -> None:
    """Raise CaseError if DPMFoam's decks cannot say what the case is."""
    fits = case.gas and case.particles and case.contact and case.contact.model == "hooke" and not case.domain.periodic
    plain = case.particles and len(list_kinds(case.particles)) == 1 and case.particles.coarse_graining is None
    if has_openings(case) or not (fits and plain):
        words = "the case needs gas, particles of one kind, no parcels, springs (hooke), walls all around and gas from "
        words += "the whole floor."
        raise CaseError([f"bench peers: {words}"])


def write_dpmfoam(case: Case, cfd: Path, positions: np.ndarray, step: float, steps: int) -> None:
    """Put DPMFoam's decks into the OpenFOAM case `cfd`, whose mesh is there: particles at `positions` (n, 3) [m],
    `steps` fluid steps of `step` [s]."""
    gas, particles, contact = case.gas, case.particles, case.contact
    assert gas and particles and contact
    context = {
        "velocity": derived.fastest_inlet(gas),
        "open_velocity": derived.open_velocity(case),
        "slip": gas.walls == "slip",
        "gravity": case.gravity,
        "density": gas.density,
        "viscosity": gas.viscosity,
        "tolerance": gas.pressure_tolerance,
        "correctors": gas.correctors,
        "diameter": particles.diameter,
        "particle_density": particles.density,
        "modulus": find_modulus(particles.diameter, particles.density, derived.pair_contact_time(contact, particles)),
        "poisson": _POISSON,
        "restitution": contact.wall_restitution,
        "damping": find_damping(contact.restitution),
        "friction": contact.friction,
        "wall_friction": contact.wall_friction,
        "steps_per_contact": derived.steps_per_contact(contact, particles),
        "positions": positions.tolist(),
        "step": step,
        "end": step * (steps + 0.5),
    }
    environment = make_environment()
    for deck in _DECKS:
        path = cfd / deck
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(environment.get_template(f"{_TEMPLATES}/{deck}").render(context), encoding="utf-8")


def find_modulus(diameter: float, density: float, duration: float) -> float:
    """Young's modulus [Pa] with which DPMFoam takes a contact for `duration` [s] long.

    Its estimate is T = 5.43 (d/4) (rho/(E* sqrt(U)))^0.4 with E* = E/(2 (1 - nu^2)) (Hertz: pi^1.4 1.25^0.4 = 5.43).
    """
    effective = density / math.sqrt(_IMPACT) * (5.429675 * diameter / 4.0 / duration) ** 2.5
    return effective * 2.0 * (1.0 - _POISSON**2)


def find_damping(restitution: float) -> float:
    """Damping alpha of a Hertz contact with `restitution` (Antypov and Elliott 2011, EPL 94:50004)."""
    return -math.sqrt(5.0) * math.log(restitution) / math.hypot(math.log(restitution), math.pi)


def time_dpmfoam(cfd: Path, ranks: int, steps: int, skip: int) -> dict[str, Any]:
    """Run DPMFoam in `cfd`; wall seconds of a step, the mean of `skip` + 1 to `steps` - 1, and the particles it had.

    Raises SolverError with its last words.
    """
    parallel = ["-parallel"] if ranks > 1 else []
    command = mpi_command(ranks, ["DPMFoam", "-case", cfd.name, *parallel])
    begins: list[float] = []
    words: list[str] = []
    particles = 0
    with subprocess.Popen(
        command,
        cwd=cfd.parent,
        env=mpi_environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        errors="replace",
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            words.append(line.rstrip())
            if line.startswith("Time = "):
                begins.append(time.perf_counter())
            if "Current number of parcels" in line:
                particles = int(line.split("=")[1])
    ends = begins[1:]
    if process.returncode or len(ends) < steps - 1:
        told = "\n".join(words[-_TAIL:])
        raise SolverError(f"DPMFoam ended with code {process.returncode} after {len(ends)} steps:\n{told}")
    return {"particles": particles, "seconds": (ends[steps - 2] - ends[skip - 1]) / (steps - 1 - skip)}
