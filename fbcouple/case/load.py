"""From a name or a path to a checked `Case`, and from a `Case` back to a file that says everything."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

import fbcouple.case.checks.bed
import fbcouple.case.checks.contact
import fbcouple.case.checks.feeds
import fbcouple.case.checks.heat
import fbcouple.case.checks.inlets
import fbcouple.case.checks.mirror
import fbcouple.case.checks.outlets
import fbcouple.case.checks.output
import fbcouple.case.checks.positions
import fbcouple.case.checks.probes
import fbcouple.case.checks.region
import fbcouple.case.checks.start
import fbcouple.case.checks.voidage  # noqa: F401  (each registers its checks)
from fbcouple.case.alternatives import keep_last_said, tell_of_base
from fbcouple.case.base import list_inherited, read_case
from fbcouple.case.bed.adopt_inlets import adopt_inlets
from fbcouple.case.bed.adopt_parcels import adopt_parcels
from fbcouple.case.bed.adopt_spring import adopt_spring
from fbcouple.case.bed.mesh_box import adopt_box
from fbcouple.case.bed.start_sizes import adopt_sizes
from fbcouple.case.checks.idle import drop_idle
from fbcouple.case.checks.registry import list_problems
from fbcouple.case.fit_averages import fit_averages
from fbcouple.case.presets import apply_preset
from fbcouple.case.problems import Problem, format_errors, show
from fbcouple.case.schema.gas import FROM_MESH
from fbcouple.case.schema.option import as_tuple
from fbcouple.case.schema.reference import list_sections, list_tables
from fbcouple.case.schema.sections import Case
from fbcouple.case.source import FILE_NAME, apply_settings, find_case
from fbcouple.errors import CaseError
from fbcouple.machine.whole_files import write_whole


def load_case(name: str, sets: Sequence[str] = (), say: Callable[[str], None] | None = None) -> Case:
    """Read, set, validate and check a case.

    name: a shipped name (`patil/c2`), a case file, or a folder that holds a case.toml.
    sets: `key.path=value` texts that go on top of the file.
    say: takes a sentence on what is fitted to `sets` (averages, where the run ends before they start); None: nothing
    is fitted, and such a case is an error.

    Raises: CaseError with every mistake found, one text each: place, key, given, allowed, how to fix it.
    """
    path = find_case(name)
    label = _format_label(name, path)
    raw, bases = read_case(path, label)
    inherited = list_inherited(raw, path, label) if bases else frozenset()
    set_keys, problems = apply_settings(raw, sets)
    if "start.run" in set_keys and isinstance(raw["start"]["run"], str):
        raw["start"]["run"] = os.path.abspath(raw["start"]["run"])  # a path of the command line, not of the file
    if say and (fitted := fit_averages(raw, set_keys)):
        say(f"{label}: {fitted}")
    problems += keep_last_said(raw, set_keys)
    apply_preset(raw)
    unread = len(problems)
    problems += (unreadable := adopt_box(raw, (path.parent, *bases)))
    case, spoiled = _validate(raw, problems)
    if unreadable:  # what its mesh would say is not asked for
        problems = [one for one in problems if one.key not in [f"domain.{key}" for key in FROM_MESH]]
    case.remember_bases(bases, inherited - set_keys)
    if not spoiled:
        case = drop_idle(case, set_keys)
    if not any(key.split(".")[0] == "particles" for key in spoiled):
        case, unfit = adopt_parcels(case, path.parent)
        problems += unfit
        case = adopt_sizes(case, path.parent)
    if not any(key.split(".")[0] in ("gas", "domain") for key in spoiled):
        case = adopt_inlets(case, path.parent)
    problems += list_problems(case, path.parent, spoiled)
    if not problems and case.contact and case.contact.max_overlap is not None:
        case, problems = adopt_spring(case, path.parent)
        problems = problems or list_problems(case, path.parent, set())
    problems = [tell_of_base(problem, case.inherited) for problem in problems]
    if problems:
        is_set = [i < unread or _is_set(problem.key, set_keys) for i, problem in enumerate(problems)]
        raise CaseError([f"{'--set' if s else label}: {problem}" for s, problem in zip(is_set, problems, strict=True)])
    return case


def _format_label(name: str, path: Path) -> str:
    if name.endswith(path.name):
        label = name
    else:  # a folder, or a shipped name: patil/c2 is patil/c2/case.toml, patil/c6 is patil/c6.toml
        label = f"{name.rstrip('/')}/{path.name}" if path.name == FILE_NAME else f"{name}.toml"
    return label if label.isprintable() else show(label)


def _is_set(key: str, set_keys: set[str]) -> bool:
    return any(given == key or given.startswith(f"{key}.") or key.startswith(f"{given}.") for given in set_keys)


def _validate(raw: dict[str, Any], problems: list[Problem]) -> tuple[Case, set[str]]:
    """Validate; on mistakes add them to `problems` and return the part of the case that is right."""
    try:
        return Case.model_validate(raw), set()
    except ValidationError as error:
        found, spoiled = format_errors(error, raw)
        problems += found
        return _keep_valid(raw, spoiled), spoiled


def _keep_valid(raw: dict[str, Any], spoiled: set[str]) -> Case:
    """Build a case without its spoiled keys, for checks that need none of them; it is never handed out."""
    kept: dict[str, Any] = {}
    for section, model in list_sections().items():
        table = raw.get(section) if section else raw
        if section in spoiled or not isinstance(table, dict):
            continue
        keys = [key for key in model.model_fields if key in table and not (not section and key in list_sections())]
        good = {
            key: _build(f"{section}.{key}", table[key]) for key in keys if f"{section}.{key}".lstrip(".") not in spoiled
        }
        kept.update({section: model.model_construct(**good)} if section else good)
    return Case.model_construct(**kept)


def _build(key: str, value: Any) -> Any:
    """The value of `key`, which is right, as the schema holds it."""
    model = list_tables().get(key)
    return tuple(model.model_validate(row) for row in value) if model else as_tuple(value)


def write_case(case: Case, path: Path) -> None:
    """Write the effective case, every default filled in, as TOML; `load_case` of the file gives the same case."""
    sections = [name for name in list_sections() if name]
    content = case.model_dump()
    lines = _write_keys({key: value for key, value in content.items() if key not in sections})
    for section in sections:
        if content[section] is not None:
            lines += ["", f"[{section}]", *_write_keys(content[section])]
    write_whole(path, "\n".join(lines) + "\n")


def _write_keys(table: dict[str, Any]) -> list[str]:
    return [f"{key} = {write_value(value)}" for key, value in table.items() if value is not None]


def write_value(value: Any) -> str:
    """Write a value as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, dict):
        return f"{{ {', '.join(_write_keys(value))} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(write_value(entry) for entry in value)}]"
    return repr(value)
