"""A case file that stands on another case and sets what was planned."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fbcouple.case.alternatives import has_option, list_replaced
from fbcouple.case.base import read_case
from fbcouple.case.checks.idle import list_idle
from fbcouple.case.load import load_case, write_value
from fbcouple.case.problems import show
from fbcouple.case.schema.reference import BASE, UNSET
from fbcouple.case.source import find_case, list_shipped, read_value
from fbcouple.errors import CaseError
from fbcouple.machine.whole_files import require_writable

_WIDTH = 118


def write_case_file(path: Path, name: str, sets: Sequence[str], settings: dict[str, Any], note: Sequence[str]) -> Path:
    """Write to `path` a case that stands on the case `name`, with `sets` (as on the command line) and then `settings`
    on top, below the sentences of `note`; load it.

    Returns: the file. Raises: CaseError if there is such a file, it cannot be written, or is no case where it lies.
    """
    given = show(str(path))
    require_free(path)
    values = _read_sets(sets) | settings
    text = _write_text(path, name, values, note)
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        raise CaseError([_tell_taken(path)]) from None
    except OSError as error:
        raise CaseError([f"{given}: cannot be written ({error.strerror}); give another place."]) from error
    try:
        load_case(str(path))
    except CaseError as error:
        path.unlink()
        text = f"{given}: a plan written there is no case; write it beside the case that it stands on."
        raise CaseError([text, *error.problems]) from None
    return path


def require_free(path: Path) -> None:
    """Raise CaseError unless a new case file can be written to `path`: asked before the work whose result it takes."""
    given = show(str(path))
    if path.suffix != ".toml":
        raise CaseError([f"{given}: is given, a name that ends in .toml is allowed: it is a case file."])
    if os.path.lexists(path):
        raise CaseError([_tell_taken(path)])
    if not path.parent.is_dir():
        raise CaseError([f"{given}: cannot be written, {show(str(path.parent))} is no folder; give another place."])
    require_writable(path, "give another place")


def _tell_taken(path: Path) -> str:
    return f"{show(str(path))}: is there already; give another name, or remove it first."


def _read_sets(sets: Sequence[str]) -> dict[str, Any]:
    values = {}
    for setting in sets:
        key, _, text = setting.partition("=")
        values[key.strip()] = read_value(text)
    if isinstance(values.get("start.run"), str):
        values["start.run"] = os.path.abspath(values["start.run"])
    return values


def _write_text(path: Path, name: str, values: dict[str, Any], note: Sequence[str]) -> str:
    lines = [f"# {line}" for sentence in note for line in textwrap.wrap(sentence, _WIDTH)]
    lines.append(f"{BASE} = {write_value(_name_base(path, name))}")
    if unset := _find_replaced(name, values):
        lines.append(f"{UNSET} = {write_value(unset)}")
    lines += [f"{key} = {write_value(value)}" for key, value in values.items() if "." not in key]
    for section in dict.fromkeys(key.partition(".")[0] for key in values if "." in key):
        inner = {key.partition(".")[2]: value for key, value in values.items() if key.startswith(f"{section}.")}
        lines += ["", f"[{section}]", *(f"{key} = {write_value(value)}" for key, value in inner.items())]
    return "\n".join(lines) + "\n"


def _name_base(path: Path, name: str) -> str:
    if name in list_shipped():
        return name
    return Path(os.path.relpath(find_case(name).resolve(), path.parent.resolve())).as_posix()


def _find_replaced(name: str, values: dict[str, Any]) -> list[str]:
    """Options of the case `name` that `values` say in another way, or leave without effect."""
    raw = read_case(find_case(name), name)[0]
    case = load_case(name, [f"{key}={write_value(value)}" for key, value in values.items()])
    idle = [key for key in list_idle(case) if key not in values and has_option(raw, key)]
    return list(dict.fromkeys([*(other for _, other in list_replaced(raw, values)), *idle]))
