"""A case file on top of another one: `base` names the case below, `unset` what is not taken over from it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from fbcouple.case.problems import show, write_hint
from fbcouple.case.schema.reference import BASE, UNSET, list_options, list_sections
from fbcouple.case.source import list_shipped, read_toml
from fbcouple.errors import CaseError

MOST_BASES = 5
_SUFFIX = ".toml"
_ALLOWED = (
    "the name of a shipped case, or the relative path of a .toml file in or beside the folder of this file or above "
    "it, is allowed"
)


def read_case(path: Path, label: str) -> tuple[dict[str, Any], list[Path]]:
    """Read a case file, and what it leaves out from the case that its `base` names, if it names one.

    Returns: the content, and the folders of the bases, the nearest first.

    A section of the file goes on top of the section of its base, key by key; anything else replaces what the base has.
    What `unset` lists is removed from the base first.

    Raises: CaseError naming `label`.
    """
    return _read(path, label, [])


def list_inherited(raw: dict[str, Any], path: Path, label: str) -> frozenset[str]:
    """Sections, and dotted keys, of `raw`, what `read_case` gives of the file `path`, that the bases brought and not
    the file."""
    own = read_toml(path, label)
    inherited = {name for name in raw if name not in own}
    for name, table in raw.items():
        above = own.get(name, {})
        if isinstance(table, dict) and isinstance(above, dict):
            inherited |= {f"{name}.{key}" for key in table if key not in above}
    return frozenset(inherited)


def _read(path: Path, label: str, above: list[tuple[Path, str]]) -> tuple[dict[str, Any], list[Path]]:
    """Read the file `path` and its bases; `above` are the files, and their names, that lead here."""
    raw = read_toml(path, label)
    base, unset = raw.pop(BASE, None), raw.pop(UNSET, None)
    if base is None:
        if unset is not None:
            raise CaseError([f"{label}: {UNSET}: is given without `{BASE}`; remove the keys themselves."])
        return raw, []
    found, name = _find_base(base, path, label)
    chain = [*above, (path.resolve(), label)]
    if found.resolve() in [file for file, _ in chain]:
        names = " -> ".join([*(above_it for _, above_it in chain), name])
        raise CaseError([f"{label}: {BASE}: the cases stand on each other in a circle ({names}); remove one `{BASE}`."])
    if len(chain) > MOST_BASES:
        raise CaseError([f"{label}: {BASE}: more than {MOST_BASES} cases stand on each other; name one lower down."])
    below, folders = _read(found, name, chain)
    if unset is not None:
        _remove(below, unset, name, label)
    return _put_on_top(below, raw), [found.parent, *folders]


def _find_base(base: Any, path: Path, label: str) -> tuple[Path, str]:
    """The case file that `base` of the file `path` means, and what messages call it."""
    shipped = list_shipped()
    if isinstance(base, str) and base in shipped:
        return shipped[base], base
    if not isinstance(base, str) or not base.endswith(_SUFFIX):
        hint = write_hint(base if isinstance(base, str) else "", shipped, "`fbcouple cases` lists the shipped cases")
        raise CaseError([f"{label}: {BASE}: {show(base)} is given, {_ALLOWED}{hint}."])
    given = f"{label}: {BASE}: {show(base)}"
    folder = path.parent.resolve()
    wanted = Path(os.path.normpath(folder / base))
    if Path(base).is_absolute() or not base.isprintable() or not _is_near(wanted, folder):
        raise CaseError([f"{given} is given, {_ALLOWED}; put the file there and give its relative path."])
    try:
        found = wanted.resolve(strict=True)
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or "its links go round"
        raise CaseError([f"{given} cannot be read: {reason}; the path starts at the folder of this file."]) from None
    if found.parent != wanted.parent:
        raise CaseError([f"{given} is a link that leads out of its folder; put the file itself there."])
    if not found.is_file():
        raise CaseError([f"{given} is not a plain file; give the path of a .toml file."])
    return found, os.path.normpath(os.path.join(os.path.dirname(label), base))


def _is_near(wanted: Path, folder: Path) -> bool:
    """Does the file lie in or beside the folder of the case, or above it?"""
    return wanted.parent in folder.parents or wanted.is_relative_to(folder.parent)


def _remove(below: dict[str, Any], unset: Any, base: str, label: str) -> None:
    """Remove what `unset` lists from the content `below` of the case `base`. Raises: CaseError with every mistake."""
    if not isinstance(unset, list) or not all(isinstance(name, str) for name in unset):
        text = f'{show(unset)} is given, a list of keys and sections in quotes is allowed, as ["gas.closed_nozzle"]'
        raise CaseError([f"{label}: {UNSET}: {text}."])
    problems = []
    known = [*(name for name in list_sections() if name), *list_options()]
    for name in unset:
        section, _, key = name.rpartition(".")
        table = below.get(section) if section else below
        if name not in known:
            hint = write_hint(name, known, "`fbcouple options` lists them")
            problems.append(f"{label}: {UNSET}: {show(name)} is no key or section of a case file{hint}.")
        elif not isinstance(table, dict) or key not in table:
            problems.append(f"{label}: {UNSET}: {show(name)} is not set by {base}; remove it from the list.")
        else:
            del table[key]
    if problems:
        raise CaseError(problems)


def _put_on_top(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    merged = below | above
    for key in below.keys() & above.keys():
        if isinstance(below[key], dict) and isinstance(above[key], dict):
            merged[key] = below[key] | above[key]
    return merged
