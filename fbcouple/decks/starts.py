"""Starts that have to be made before a run folder can be written: particles of another run or a restart file, a
poured bed.

What is made is a file of start positions, and the case is given it as `particles.positions` in place of [start]: a run
folder holds all that it needs, and does not care how its start was made. The head of the file says that.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from fbcouple.case.bed.particle_types import word_count
from fbcouple.case.bed.region import read_mesh
from fbcouple.case.checks.registry import list_problems
from fbcouple.case.problems import Problem
from fbcouple.case.schema.particles import Start
from fbcouple.case.schema.sections import Case
from fbcouple.decks.alone import Particles, remove_gas
from fbcouple.decks.other_run import Source, describe, find_source, read_particles
from fbcouple.decks.pour import VERSION, find_rest_speed, pour
from fbcouple.decks.render import render_decks
from fbcouple.decks.restart_file import find_restart, read_restart_file
from fbcouple.errors import CaseError
from fbcouple.input_files.liggghts_files import POSITIONS, SPINS, VELOCITIES
from fbcouple.machine.cache import make_folder
from fbcouple.machine.whole_files import write_whole
from fbcouple.paths import cache_folder
from fbcouple.run_folder.manifest import hash_text

CACHE = "starts"
"""Folder of poured beds in the cache."""
_NAMED = 12
"""Letters of a checksum that a file is named by."""

Say = Callable[[str], None]


def make_start(case: Case, folder: Path, scratch: Path, say: Say | None = None, pours: bool = True) -> Case:
    """The case with the file of its start, if that has to be made; other cases as they are.

    folder: where the case's own files lie; scratch: an empty folder for a file that is not kept; say: is told what is
    made, before and after; pours: also where LIGGGHTS has to pour, or to read what is trusted. Poured beds are kept in
    the cache.

    Raises: CaseError if the start cannot be made, or does not fit the case; SolverError if LIGGGHTS fails.
    """
    if case.start is None or not case.start.is_made:
        return case
    say = say or (lambda text: None)
    if not pours and (hint := _find_what_setup_makes(case, folder)):
        say(f"start: {hint}, which checks what comes out")
        return case
    name, table_folder = _MAKERS[_choose(case.start)](case, folder, scratch, say)
    made = put_in(case, name, table_folder)
    if problems := list_problems(made, folder, ()):
        raise CaseError([_name_given(case.start, name, problem) for problem in problems])
    return made


def _name_given(start: Start, name: str, problem: Problem) -> str:
    """A problem of what was made, `name`, in terms of the option that it was made by."""
    if problem.key != "particles.positions":
        return f"start: {problem}"
    made_of = _choose(start)
    key, given = f"start.{made_of}", getattr(start, made_of, None)
    if given is None:
        key, given = "start.method", "the poured bed"
    text = problem.text.replace(name, given)
    return str(Problem(key, text.replace("fix the file", "take another run") if made_of == "run" else text))


def put_in(case: Case, name: str, table_folder: Path) -> Case:
    """The case with the start positions `name`, which lie in `table_folder`, in place of [start]."""
    assert case.particles is not None
    particles = case.particles.model_copy(update={"positions": name})
    made = case.model_copy(update={"particles": particles, "start": None})
    made.remember_bases((*case.base_folders, table_folder))
    made.remember_origin(*case.origin)
    return made


def expect_start(case: Case, folder: Path) -> Case:
    """The case as `make_start` gives it, without the file. Raises: CaseError if the other run is not there."""
    if case.start is None or not case.start.is_made:
        return case
    return put_in(case, _NAMES[_choose(case.start)](case, folder), folder)


def _choose(start: Start) -> str:
    """What the start is made of, a key of `_MAKERS`."""
    return "run" if start.run is not None else "restart" if start.restart is not None else "pour"


def _find_what_setup_makes(case: Case, folder: Path) -> str:
    """Say what `setup` does with the start, where LIGGGHTS has to do it."""
    made_of = _choose(case.start) if case.start else ""
    if made_of == "pour" and not (cache_folder() / CACHE / _name_poured(case, folder)).is_file():
        return "the bed is poured by `setup`"
    return "the restart file is read by `setup --trust`" if made_of == "restart" else ""


def _name_poured(case: Case, folder: Path) -> str:
    """The file of a poured bed, by all that it depends on: deck, region, particles, seed and limits."""
    assert case.start is not None and case.particles is not None
    mesh = None if case.domain.is_plain_box else read_mesh(case, folder)
    told = {
        "version": VERSION,
        "deck": render_decks(remove_gas(case), folder)["DEM/in.liggghts"],
        "size": case.domain.size,
        "mesh": None if mesh is None else [hash_text(repr(part.tolist())) for part in (mesh.points, mesh.faces.values)],
        "particles": case.particles.model_dump(exclude={"positions_seed"}),
        "seed": case.start.seed,
        "rest": find_rest_speed(case, case.start),
    }
    return f"poured-{hash_text(json.dumps(told))[:_NAMED]}.csv"


def _pour(case: Case, folder: Path, scratch: Path, say: Say) -> tuple[str, Path]:
    name, table_folder = _name_poured(case, folder), cache_folder() / CACHE
    if (table_folder / name).is_file():
        say(f"start: poured before, taken from {table_folder / name}")
        return name, table_folder
    say("start: the bed is poured and settles, once (one process; the result is kept)")
    poured = pour(case, folder, say)
    count, height = len(poured.particles.kinds), poured.particles.positions[:, 2].max()
    assert case.particles is not None
    about = f"poured bed of {word_count(case.particles, count, 10)} at rest after {poured.time:.4g} s (speed "
    about += f"{poured.speed:.2g} m/s, {poured.parts} part{'s' if poured.parts > 1 else ''}), highest centre at "
    about += f"{height:.6g} m"
    make_folder(table_folder)
    write_whole(table_folder / name, "".join(_write_table(poured.particles, about)))
    say(f"start: {about}; kept as {table_folder / name}")
    return name, table_folder


def _take_over(case: Case, folder: Path, scratch: Path, say: Say) -> tuple[str, Path]:
    run, other, source, about = _find(case, folder)
    try:
        particles = read_particles(case, run, other, source)
    except CaseError as error:
        raise CaseError([f"start.run: {problem}" for problem in error.problems]) from None
    if case.heat is None:
        particles = replace(particles, temperatures=None)
    return _write(particles, about, _name("run", about), scratch, say)


def _write(particles: Particles, about: str, name: str, scratch: Path, say: Say) -> tuple[str, Path]:
    (scratch / name).write_text("".join(_write_table(particles, about)), encoding="utf-8")
    say(f"start: {about}")
    return name, scratch


def _read_over(case: Case, folder: Path, scratch: Path, say: Say) -> tuple[str, Path]:
    path, about = find_restart(case, folder)
    try:
        particles = read_restart_file(case, path)
    except CaseError as error:
        raise CaseError([f"start.restart: {problem}" for problem in error.problems]) from None
    return _write(particles, about, _name("restart", about), scratch, say)


def _find(case: Case, folder: Path) -> tuple[Path, Case, Source, str]:
    """The run that the particles are taken of, its case, where in it they are, and that in words."""
    assert case.start is not None and case.start.run is not None
    run = (case.find_folder(folder, case.start.run) / case.start.run).resolve()
    try:
        other, source = find_source(run, case.start.time)
    except CaseError as error:
        raise CaseError([f"start.run: {problem}" for problem in error.problems]) from None
    return run, other, source, describe(run, other, source)


def _name(made_of: str, about: str) -> str:
    return f"{made_of}-{hash_text(about)[:_NAMED]}.csv"


_MAKERS: dict[str, Callable[[Case, Path, Path, Say], tuple[str, Path]]] = {
    "run": _take_over,
    "restart": _read_over,
    "pour": _pour,
}
_NAMES: dict[str, Callable[[Case, Path], str]] = {
    "run": lambda case, folder: _name("run", _find(case, folder)[3]),
    "restart": lambda case, folder: _name("restart", find_restart(case, folder)[1]),
    "pour": _name_poured,
}
"""Kind of start -> what makes the file of its positions, and what that is called."""


def _write_table(particles: Particles, about: str) -> Iterator[str]:
    """Lines of a file of start positions; every digit is kept, and what all are without is left out."""
    yield f"# {about if about.isprintable() else ascii(about)}\n"
    columns, parts = [*POSITIONS], [particles.positions]
    if particles.motion.any():
        columns, parts = [*columns, *VELOCITIES, *SPINS], [*parts, particles.motion]
    if particles.temperatures is not None:
        columns, parts = [*columns, "temperature"], [*parts, particles.temperatures[:, None]]
    yield f"{','.join((*columns, 'kind'))}\n"
    for row, kind in zip(np.hstack(parts).tolist(), particles.kinds.tolist(), strict=True):
        yield f"{','.join(map(repr, row))},{kind + 1}\n"
