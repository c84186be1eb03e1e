"""The site file: what job scripts of a machine ask for each time, under a name of one's own."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from fbcouple.case.problems import show, write_hint
from fbcouple.errors import CaseError
from fbcouple.paths import find_user_folder


def find_site_file() -> Path | None:
    """`fbcouple/site.toml` in the user's XDG configuration folder; None without a home folder."""
    folder = find_user_folder("XDG_CONFIG_HOME", "~/.config")
    return folder / "site.toml" if folder else None


def read_site(name: str, allowed: Mapping[str, bool]) -> dict[str, Any]:
    """The table `name` of the site file: option -> value, options as on the command line without their dashes.

    Parameters
    ----------
    allowed : each option that may stand in it, and whether it takes a list

    Raises
    ------
    CaseError : no such file or table, an option that is none, or a value that is neither text nor number (nor a list
        of texts where the option takes one)
    """
    file = find_site_file()
    if file is None or not file.is_file():
        text = f"is given and there is no {file or 'home folder'}; write it there as a table"
        raise CaseError([f"--site: {show(name)} {text}."])
    try:
        tables = tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CaseError([f"{file}: cannot be read: {error}."]) from error
    sites = {key: table for key, table in tables.items() if isinstance(table, dict)}
    if stray := [key for key in tables if key not in sites]:
        text = "stands outside of a table; put it under the name of a site, as [mine]"
        raise CaseError([f"{file}: {show(stray[0])} {text}."])
    if name not in sites:
        text = f"has no [{name}], only {_listed(sites)}"
        raise CaseError([f"--site: {file} {text}; name one of them or write it."])
    problems = [f"{file}: [{name}] {fault}" for key in sites[name] for fault in _judge(key, sites[name][key], allowed)]
    if problems:
        raise CaseError(problems)
    return sites[name]


def _judge(key: str, value: object, allowed: Mapping[str, bool]) -> list[str]:
    if key not in allowed:
        hint = write_hint(key, allowed, f"allowed are: {_listed(allowed)}")
        return [f"{show(key)} is no option of `fbcouple batch` that a site may have{hint}."]
    if allowed[key]:
        fits = isinstance(value, list) and all(isinstance(one, str) for one in value)
        return [] if fits else [f"{key}: {show(value)} is given, a list of texts is allowed; put it in [ ]."]
    fits = isinstance(value, str | int) and not isinstance(value, bool)
    return [] if fits else [f"{key}: {show(value)} is given, a text or a whole number is allowed."]


def _listed(names: Collection[str]) -> str:
    return ", ".join(sorted(names)) or "nothing"
