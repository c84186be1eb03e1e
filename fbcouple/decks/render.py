"""Render the decks of a case and lay out its run folder, all of it or nothing."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import FileSystemLoader, StrictUndefined
from jinja2.sandbox import ImmutableSandboxedEnvironment

from fbcouple.case.bed.lattice import lattice_kinds, lattice_positions
from fbcouple.case.bed.particle_types import grain_count, list_kinds
from fbcouple.case.bed.region import has_own_mesh, read_mesh
from fbcouple.case.changes import list_values
from fbcouple.case.companions import copy_companions
from fbcouple.case.load import write_case
from fbcouple.case.schema.sections import Case
from fbcouple.decks.context import build_context, find_box
from fbcouple.decks.needs import find_needs, tell_parts
from fbcouple.decks.open_walls import list_openings, name_opening, name_surface
from fbcouple.decks.replace import put_in_place, refuse_foreign
from fbcouple.errors import CaseError
from fbcouple.geometry.stl import list_walls, write_surface
from fbcouple.paths import START, TEMPERATURES, TEMPLATES, WALLS
from fbcouple.run_folder.manifest import hash_file, write_manifest
from fbcouple.solvers.versions import list_own_versions
from fbcouple.version import __version__

_LONGEST_ORIGIN = 2000
# deck file in the run folder -> (template, part of the case that needs it)
DECKS: dict[str, tuple[str, str]] = {
    "CFD/system/controlDict": ("openfoam/system/controlDict", "gas"),
    "CFD/system/fvSchemes": ("openfoam/system/fvSchemes", "gas"),
    "CFD/system/fvSolution": ("openfoam/system/fvSolution", "gas"),
    "CFD/system/blockMeshDict": ("openfoam/system/blockMeshDict", "block_mesh"),
    "CFD/system/topoSetDict": ("openfoam/system/topoSetDict", "closed_nozzle"),
    "CFD/system/createPatchDict": ("openfoam/system/createPatchDict", "closed_nozzle"),
    "CFD/constant/transportProperties": ("openfoam/constant/transportProperties", "gas"),
    "CFD/constant/turbulenceProperties": ("openfoam/constant/turbulenceProperties", "gas"),
    "CFD/case.foam": ("openfoam/case.foam", "gas"),
    "CFD/0/U": ("openfoam/0/U", "gas"),
    "CFD/0/p": ("openfoam/0/p", "gas"),
    "CFD/0/voidage": ("openfoam/0/voidage", "gas"),
    "CFD/0/T": ("openfoam/0/T", "gas_heat"),
    "CFD/0/nut": ("openfoam/0/nut", "turbulence"),
    "CFD/0/k": ("openfoam/0/k", "subgrid_energy"),
    "CFD/0/flm": ("openfoam/0/flm", "lagrangian_averages"),
    "CFD/0/fmm": ("openfoam/0/fmm", "lagrangian_averages"),
    "DEM/in.liggghts": ("liggghts/in.liggghts", "particles"),
}


def format_number(value: float) -> str:
    """Shortest text that reads back as the same number; only numbers can come out of it."""
    return repr(float(value))


def make_environment() -> ImmutableSandboxedEnvironment:
    """Templates see their context only, and an undefined name is an error."""
    environment = ImmutableSandboxedEnvironment(
        loader=FileSystemLoader(TEMPLATES),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["num"] = format_number
    return environment


def render_decks(case: Case, folder: Path = Path()) -> dict[str, str]:
    """Deck file -> text, only the files that the case needs; the case's own files lie in `folder`."""
    needs = find_needs(case)
    context: dict[str, Any] = build_context(case, needs, folder)
    environment = make_environment()
    decks = {
        deck: environment.get_template(template).render(context)
        for deck, (template, part) in DECKS.items()
        if needs[part]
    }
    for number, stage in enumerate(list_openings(case, folder) if needs["open_walls"] else (), start=1):
        paths = {name: name_surface(name, number) for name in stage.surfaces}
        template = environment.get_template("liggghts/open_walls.liggghts")
        decks[name_opening(number)] = template.render(context | {"closed": stage.closed, "surfaces": [*paths.items()]})
        decks |= {paths[name]: "".join(write_surface(found)) for name, found in stage.surfaces.items()}
    return decks


def format_particles(
    case: Case, positions: np.ndarray, kinds: np.ndarray, box: np.ndarray, motion: np.ndarray | None = None
) -> Iterator[str]:
    """Lines of a LIGGGHTS data file: `box` (2, 3) [m], counts, and a particle a line; types are kinds, and one more
    the walls.

    motion: velocities [m/s] and angular velocities [rad/s], (particles, 6); None where all start at rest.
    """
    assert case.particles is not None
    known = list_kinds(case.particles)
    yield f"Particles at the start; the title is in case.toml\n\n{len(positions)} atoms\n{len(known) + 1} atom types\n"
    for axis, low, high in zip("xyz", *box.tolist(), strict=True):
        yield f"{format_number(low)} {format_number(high)} {axis}lo {axis}hi\n"
    yield "\nAtoms\n\n"
    sizes = [f"{n} {format_number(k.diameter)} {format_number(k.density)}" for n, k in enumerate(known, start=1)]
    for number, ((x, y, z), kind) in enumerate(zip(positions.tolist(), kinds.tolist(), strict=True), start=1):
        yield f"{number} {sizes[kind]} {x!r} {y!r} {z!r}\n"
    if motion is not None:
        yield "\nVelocities\n\n"
        for number, row in enumerate(motion.tolist(), start=1):
            yield f"{number} {' '.join(map(repr, row))}\n"


Read = Callable[[Case], np.ndarray]


def set_up(
    case: Case,
    run: Path,
    read_positions: Read = lattice_positions,
    read_kinds: Read = lattice_kinds,
    read_motion: Callable[[Case], np.ndarray | None] = lambda case: None,
    read_temperatures: Callable[[Case], np.ndarray | None] = lambda case: None,
    folder: Path | None = None,
) -> None:
    """Write the run folder `run` of `case`, whose own files lie in `folder` and are copied: effective case, manifest,
    decks. Without a `folder` they are looked for here, and not copied.

    Everything is written beside it first and moved in at the end. Raises CaseError if `run` holds results or
    anything that an earlier set-up did not write and this one would replace.
    """
    run = run.resolve()
    refuse_foreign(run)
    if case.start and case.start.is_made:
        raise CaseError(["start: the particles are poured or taken of a run, which `fbcouple setup` does first."])
    case_folder = folder or Path()
    decks = render_decks(case, case_folder)
    mesh = read_mesh(case, case_folder) if has_own_mesh(case) else None
    lines: list[str] = []
    if case.particles:
        start = read_positions(case), read_kinds(case), find_box(case, mesh), read_motion(case)
        lines = list(format_particles(case, *start))
    fresh = run.with_name(f".{run.name}.setting-up-{os.getpid()}")
    try:
        for name, text in decks.items():
            _write(fresh / name, text)
        if case.particles:
            _write(fresh / START, "".join(lines))
            if (temperatures := read_temperatures(case)) is not None:
                _write(fresh / TEMPERATURES, "".join(f"{value!r}\n" for value in temperatures.tolist()))
        if mesh and find_needs(case)["surface_walls"]:
            _write(fresh / WALLS, "".join(write_surface(list_walls(mesh))))
        write_case(case, fresh / "case.toml")
        if folder is not None:
            copy_companions(case, folder, fresh)
        manifest = _describe(case, fresh)
        (fresh / "logs").mkdir()
        write_manifest(fresh, manifest)
        put_in_place(fresh, run, manifest, folder)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def _describe(case: Case, fresh: Path) -> dict[str, Any]:
    files = sorted(path for path in fresh.rglob("*") if path.is_file())
    return {
        "fbcouple": __version__,
        "title": case.title,
        "start": _find_origin(case, fresh),
        "particles": grain_count(case.particles) if case.particles else 0,
        "set_up_with": list_own_versions(),
        **tell_parts(case),
        "case": list_values(case),
        "files": {path.relative_to(fresh).as_posix(): hash_file(path) for path in files},
    }


def _find_origin(case: Case, fresh: Path) -> str:
    """What the file of start positions says of itself in its first line, if the case has one."""
    name = case.particles.positions if case.particles else None
    if name is None:
        return "[start]" if case.start else ""
    if not (fresh / name).is_file():
        return name
    with (fresh / name).open(encoding="utf-8", errors="replace") as file:
        line = file.readline(_LONGEST_ORIGIN).strip()
    return f"{name}: {line.lstrip('# ')}" if line.startswith("#") else name
