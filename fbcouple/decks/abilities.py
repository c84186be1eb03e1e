"""What a LIGGGHTS library must be able to do for a case: it is asked, by decks of two particles, whatever it is called.

A library built from source, or a fork, has some models and lacks others, and its name and version do not say which.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.bed.region import read_mesh
from fbcouple.case.schema.sections import Case
from fbcouple.decks.needs import find_needs
from fbcouple.decks.open_walls import list_openings, name_opening
from fbcouple.decks.render import find_box, format_particles, render_decks
from fbcouple.errors import SolverError
from fbcouple.geometry.stl import list_walls, write_surface
from fbcouple.machine.cache import make_folder
from fbcouple.machine.environment import mpi_environment
from fbcouple.machine.programs import run_program
from fbcouple.machine.whole_files import write_whole
from fbcouple.paths import START, TEMPLATES, WALLS, cache_folder
from fbcouple.solvers.site_files import LIGGGHTS

Answers = dict[str, str]
"""Part of a case -> "" where LIGGGHTS can do it, else the command that it does not take, with its words."""
_MODULE = "fbcouple.solvers.liggghts_probe"
_DIAMETER = 1e-3
_WIDTH = 0.01
REFUSAL = "ERROR"
"""In LIGGGHTS' words where it does not take a command."""
_PLACES = np.array([[0.4, 0.5, 0.5], [0.6, 0.5, 0.5]]) * _WIDTH
_BED: dict[str, Any] = {
    "title": "abilities",
    "end_time": 1.0,
    "domain": {"size": [_WIDTH, _WIDTH, _WIDTH], "cells": [4, 4, 4]},
    "particles": {"diameter": _DIAMETER, "density": 2500.0, "count": 2},
    "contact": {
        "restitution": 0.9,
        "wall_restitution": 0.9,
        "friction": 0.0,
        "wall_friction": 0.0,
    },
    "start": {},
}
_GAS = {"density": 1.2, "viscosity": 2e-5, "inlet_velocity": 0.0}
_COUPLED: dict[str, Any] = {"gas": _GAS, "exchange": {"accelerated": False}}
_FRICTION = {"friction": 0.1, "wall_friction": 0.1}
_HERTZ = {"model": "hertz", "youngs_modulus": 1e7, "poisson_ratio": 0.3, "impact_speed": 1.0}
_FEED = {"low": [0.0, 0.0, 0.8 * _WIDTH], "high": [_WIDTH, _WIDTH, 0.9 * _WIDTH], "rate": 10.0}
_HEAT = {"particle_temperature": 300.0, "particle_specific_heat": 800.0}
_CONDUCTION = {"contact_conduction": "liggghts", "particle_conductivity": 1.0, "wall_temperature": 310.0}
_OUTLET = {"face": "floor", "rectangle": [[0.0, 0.0], [0.5 * _WIDTH, _WIDTH]]}
PROBED: dict[str, dict[str, Any]] = {
    "particles": {},
    "coupling": _COUPLED,
    "pair_friction": {"contact": _FRICTION | {"wall_friction": 0.0, "tangential": "no-history"}},
    "wall_friction": {"contact": _FRICTION | {"friction": 0.0, "tangential": "no-history"}},
    "tangential_history": {"contact": _FRICTION | {"tangential": "history"}},
    "hertz": {"contact": _FRICTION | _HERTZ},
    "rolling_friction": {"contact": _FRICTION | {"rolling_friction": 0.1}, "particles": {"rotation": True}},
    "rotation": {"particles": {"rotation": True}},
    "mixture": {"particles": {"sizes": [[_DIAMETER, 2500.0, 1], [0.8 * _DIAMETER, 2500.0, 1]]}},
    "surface_walls": {"domain": {"shape": "cylinder"}},
    "periodic": {"domain": {"periodic": ["x"]}},
    "feeds_and_outlets": {"particles": {"feeds": [_FEED]}},
    "open_walls": {"particles": {"outlets": [_OUTLET]}},
    "empty_start": {"particles": {"feeds": [_FEED], "count": 0}},
    "virtual_mass": _COUPLED | {"exchange": {"virtual_mass": True}},
    "accelerated_drag": _COUPLED | {"exchange": {"accelerated": True}},
    "particle_heat": {"heat": _HEAT},
    "contact_conduction": {"heat": _HEAT | _CONDUCTION},
}
"""Part of a case, as `find_needs` names it -> what a bed of two particles has for it."""
ARRAYS = ("tags", "types", "positions", "velocities", "angular_velocities", "forces", "radii", "densities", "masses")
_ARRAYS_OF = {
    "coupling": ("held_force",),
    "virtual_mass": ("last_velocities",),
    "accelerated_drag": ("drag_only_velocities",),
    "feeds_and_outlets": ("identity",),
    "particle_heat": ("temperatures",),
}
"""Part of a case -> what of the particles it asks for."""


def make_case(part: str) -> Case:
    """The bed of two particles that has `part`."""
    data = {name: dict(section) if isinstance(section, dict) else section for name, section in _BED.items()}
    for name, section in PROBED[part].items():
        data[name] = data.get(name, {}) | section
    return Case.model_validate(data)


def list_lacking(case: Case, answers: Answers) -> Answers:
    """Those of `answers` that `case` needs and that LIGGGHTS itself refuses, in its own words."""
    needs = find_needs(case)
    return {part: words for part, words in answers.items() if REFUSAL in words and needs[part]}


def format_lacking(lacking: Answers) -> str:
    """The parts that are lacking, those with the same words together."""
    alike: dict[str, list[str]] = {}
    for part, words in lacking.items():
        alike.setdefault(words, []).append(part)
    return "; ".join(f"{', '.join(parts)} ({words})" for words, parts in alike.items())


def tell_able(answers: Answers) -> dict[str, Any]:
    """What a manifest says of `answers`: the parts that LIGGGHTS can do, and those that it cannot, each with why."""
    can = [part for part, words in answers.items() if not words]
    return {"can": can, "cannot": {part: words for part, words in answers.items() if words}}


def require_able(case: Case, library: str, say: Callable[[str], None]) -> Answers:
    """What LIGGGHTS can do, if that is all that `case` needs; asked once of each `library`, as `list_versions` has it.

    {} of a case without particles, or where it cannot be asked, of which `say` is told: it is no reason not to run.
    Raises: SolverError naming what it lacks.
    """
    if case.particles is None:
        return {}
    answers = _read_kept(library)
    if answers is None:
        try:
            answers = probe()
        except SolverError as error:
            say(str(error))
            return {}
        _keep(library, answers)
    if lacking := list_lacking(case, answers):
        told = format_lacking(lacking)
        raise SolverError(f"{library} lacks what this case needs: {told}; name another library in {LIGGGHTS}")
    return answers


def probe() -> Answers:
    """Ask the LIGGGHTS library that a rank would load for every part in PROBED.

    Raises: SolverError if there is no library, or it cannot be asked.
    """
    with TemporaryDirectory(prefix="fbcouple-probe-") as name:
        folder = Path(name)
        for part in PROBED:
            _lay_out(part, folder / part)
        done = run_program([sys.executable, "-m", _MODULE, name], mpi_environment(), folder)
    if done.returncode:
        words = (done.stderr.strip().splitlines() or ["no words"])[-1]
        raise SolverError(f"LIGGGHTS cannot be asked what it can do: exit code {done.returncode}: {words[:300]}")
    answers = json.loads(done.stdout.splitlines()[-1])
    return {part: answers[part] for part in PROBED}


def _find_kept(library: str) -> Path:
    templates = [path.read_text(encoding="utf-8") for path in sorted((TEMPLATES / "liggghts").iterdir())]
    asked = "\n".join([library, repr(PROBED), *templates])
    return cache_folder() / f"liggghts-{hashlib.sha256(asked.encode()).hexdigest()[:16]}.json"


def _read_kept(library: str) -> Answers | None:
    """What was found of the same library by the same decks; None if nothing was, or it cannot be read."""
    try:
        answers = json.loads(_find_kept(library).read_text(encoding="utf-8"))
    except (SolverError, OSError, ValueError):
        return None
    whole = isinstance(answers, dict) and set(answers) == set(PROBED)
    return answers if whole and all(isinstance(words, str) for words in answers.values()) else None


def _keep(library: str, answers: Answers) -> None:
    """Keep `answers` for the next run; not where a process ended otherwise than by LIGGGHTS, or nothing can be kept."""
    if any(words and REFUSAL not in words for words in answers.values()):
        return
    with suppress(SolverError, OSError):
        path = _find_kept(library)
        make_folder(path.parent)
        write_whole(path, json.dumps(answers, indent=1) + "\n")


def _lay_out(part: str, folder: Path) -> None:
    case = make_case(part)
    assert case.particles is not None
    needs = find_needs(case)
    for name, text in render_decks(case).items():
        if name.startswith("DEM/"):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8")
    mesh = read_mesh(case, Path()) if needs["surface_walls"] else None
    if mesh:
        (folder / WALLS).write_text("".join(write_surface(list_walls(mesh))), encoding="utf-8")
    if not needs["empty_start"]:
        kinds = np.arange(2) % len(list_kinds(case.particles))
        lines = format_particles(case, _PLACES, kinds, find_box(case, mesh))
        (folder / START).write_text("".join(lines), encoding="utf-8")
    openings = name_opening(1) if needs["open_walls"] and list_openings(case, Path()) else None
    task = {
        "remembers": needs["virtual_mass"],
        "identifies": needs["feeds_and_outlets"],
        "arrays": [*ARRAYS, *(array for one, arrays in _ARRAYS_OF.items() if needs[one] for array in arrays)],
        "openings": openings,
        "place": [0.5 * _WIDTH, 0.5 * _WIDTH, 0.7 * _WIDTH],
        "diameter": _DIAMETER,
        "density": 2500.0,
    }
    (folder / "task.json").write_text(json.dumps(task), encoding="utf-8")
