"""The files that a case brings beside its case file: start positions, code of its own, a mesh, ramps of inlets,
measured lines."""

from __future__ import annotations

import shutil
from pathlib import Path

from fbcouple.case.problems import show
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import list_code
from fbcouple.errors import CaseError
from fbcouple.geometry.foam_text import list_parts
from fbcouple.input_files.companion_files import find_companion, is_bare
from fbcouple.input_files.measured_lines import parse_reference

_TAKEN = ("CFD", "DEM", "logs", "checkpoints", "frames", "figures", "vtk", "batch")
"""Folders of a run folder, beside which the case's own files come to lie."""


def find_mesh(folder: Path, name: str) -> Path:
    """The mesh `name` beside the case, which lies in `folder`: a gmsh file, or a folder with OpenFOAM's five files.

    Raises: CaseError (one text, without the key) as `find_companion`.
    """
    if name.endswith(".msh") or not (folder / name).is_dir():
        return find_companion(folder, name, ".msh")
    if not is_bare(name) or (folder / name).resolve().parent != folder.resolve():
        raise CaseError([f"{show(name)} is given, the bare name of a folder beside the case file is allowed."])
    if name in _TAKEN:
        raise CaseError([f"{show(name)} is given, which a run folder has of its own; give the folder another name."])
    for part in list_parts(folder / name):
        find_companion(folder / name, part, "")
    return folder / name


def copy_companions(case: Case, folder: Path, run: Path) -> None:
    """Copy the files that `case` brings from `folder` beside the case in `run`; of a mesh folder its own files."""
    for name in list_companions(case):
        source = case.find_folder(folder, name)
        for file in list_files(source, name):
            (run / file).parent.mkdir(exist_ok=True)
            shutil.copyfile(source / file, run / file)


def list_files(folder: Path, name: str) -> list[str]:
    """The file `name` of a case whose own files lie in `folder`, or the files of the mesh folder `name`."""
    return [f"{name}/{part}" for part in list_parts(folder / name)] if (folder / name).is_dir() else [name]


def list_companions(case: Case) -> list[str]:
    """Names of the files that `case` brings, each once."""
    names = [parse_reference(text).file for text in case.output.references]
    names += [case.particles.positions] if case.particles and case.particles.positions else []
    names += list_code(case).values()
    names += [case.domain.mesh] if case.domain.mesh else []
    for inlet in case.gas.inlets if case.gas else ():
        names += [name for name in (inlet.ramp_file, inlet.profile_file) if name]
    return sorted(set(names))
