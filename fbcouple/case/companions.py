"""The files that a case brings beside its case file: start positions, its own drag law, a mesh, measured lines."""

from __future__ import annotations

import shutil
from pathlib import Path

from fbcouple.case.problems import show
from fbcouple.case.schema import Case
from fbcouple.companion_files import find_companion, is_bare
from fbcouple.errors import CaseError
from fbcouple.meshes.foam_text import list_parts
from fbcouple.reference import parse_reference


def find_mesh(folder: Path, name: str) -> Path:
    """The mesh `name` beside the case, which lies in `folder`: a gmsh file, or a folder with OpenFOAM's five files.

    Raises: CaseError (one text, without the key) as `find_companion`.
    """
    if name.endswith(".msh") or not (folder / name).is_dir():
        return find_companion(folder, name, ".msh")
    if not is_bare(name) or (folder / name).resolve().parent != folder.resolve():
        raise CaseError([f"{show(name)} is given, the bare name of a folder beside the case file is allowed."])
    for part in list_parts(folder / name):
        find_companion(folder / name, part, "")
    return folder / name


def copy_companions(case: Case, folder: Path, run: Path) -> None:
    """Copy the files that `case` brings from `folder` beside the case in `run`; of a mesh folder its own files."""
    for name in list_companions(case):
        if (folder / name).is_dir():
            (run / name).mkdir(exist_ok=True)
            for part in list_parts(folder / name):
                shutil.copyfile(folder / name / part, run / name / part)
        else:
            shutil.copyfile(folder / name, run / name)


def list_companions(case: Case) -> list[str]:
    """Names of the files that `case` brings, each once."""
    names = [parse_reference(text).file for text in case.output.references]
    names += [case.particles.positions] if case.particles and case.particles.positions else []
    names += [case.exchange.drag_file] if case.exchange and case.exchange.drag_file else []
    names += [case.domain.mesh] if case.domain.mesh else []
    return sorted(set(names))
