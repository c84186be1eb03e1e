"""The files that a case brings beside its case file: start positions, its own drag law, measured lines."""

from __future__ import annotations

from pathlib import Path

from fbcouple.case.problems import show
from fbcouple.case.schema import Case
from fbcouple.errors import CaseError
from fbcouple.reference import parse_reference

_LONGEST_NAME = 255


def find_companion(folder: Path, name: str, suffix: str) -> Path:
    """The file `name` beside the case, which lies in `folder`; it ends in `suffix`.

    A case may come from anybody: its files are plain files of its own folder, and no link leads out of it.

    Raises: CaseError (one text, without the key) if it is not.
    """
    is_bare = Path(name).name == name and "\\" not in name and name.isprintable() and len(name) <= _LONGEST_NAME
    if not is_bare or not name.endswith(suffix):
        text = f"{show(name)} is given, the bare name of a {suffix} file is allowed"
        raise CaseError([f"{text}; put the file beside the case file and give its name only."])
    path = folder / name
    try:
        found = path.resolve(strict=True)
    except OSError as error:
        raise CaseError([f"{name} cannot be read: {error.strerror}; put it beside the case file."]) from None
    if found.parent != folder.resolve():
        raise CaseError([f"{name} is a link that leads out of the folder of the case; put the file itself there."])
    if not found.is_file():
        raise CaseError([f"{name} is not a plain file; put a {suffix} file beside the case file."])
    return path


def list_companions(case: Case) -> list[str]:
    """Names of the files that `case` brings, each once."""
    names = [parse_reference(text).file for text in case.output.references]
    names += [case.particles.positions] if case.particles and case.particles.positions else []
    names += [case.exchange.drag_file] if case.exchange and case.exchange.drag_file else []
    return sorted(set(names))
