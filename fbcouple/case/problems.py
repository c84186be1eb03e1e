"""What is wrong with a case, in words: where, what was given, what is allowed, how to fix it."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from pydantic import ValidationError

from fbcouple.case.schema.option import Section
from fbcouple.case.schema.reference import FILE_KEYS, list_options, list_sections, list_tables
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

_LONGEST = 60
_DEEPEST = 3
_MOST_MEANT = 200
_BARE = re.compile(r"[\w.+-]+")
"""Problems of a file up to which unknown keys are compared with known ones; a file with more is not misspelt."""
_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?\s*")


@dataclass(frozen=True)
class Problem:
    """One mistake: the dotted key that it belongs to and the rest of the text."""

    key: str
    text: str

    def __str__(self) -> str:
        return f"{self.key}: {self.text}"


def show(value: Any, depth: int = 0) -> str:
    """Write a value as a case file would, on one line and never longer than a line takes."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, int):
        text = str(value) if value.bit_length() < 8 * _LONGEST else f"a whole number of {value.bit_length()} bits"
    elif isinstance(value, str):
        text = json.dumps(value[: 2 * _LONGEST], ensure_ascii=not value.isprintable())
    elif isinstance(value, list | tuple):
        inner = "..." if depth >= _DEEPEST else ", ".join(show(entry, depth + 1) for entry in value[:8])
        text = f"[{inner}{', ...' if len(value) > 8 else ''}]"
    elif isinstance(value, dict):
        text = "a table"
    else:
        text = str(value)
    shortened = text if len(text) <= _LONGEST else text[:_LONGEST] + "..."
    return f"{shortened} ({len(value)} characters)" if isinstance(value, str) and len(value) > _LONGEST else shortened


@contextmanager
def naming(name: str) -> Iterator[None]:
    """Put `name` before each text of a CaseError that does not begin with it: one of several cases, or runs."""
    try:
        yield
    except CaseError as error:
        raise CaseError([text if text.startswith(name) else f"{name}: {text}" for text in error.problems]) from error


def show_key(parts: Iterable[str]) -> str:
    """Join the parts of a key with dots, quoting and shortening what is not a plain word."""
    return ".".join(part if part.isidentifier() and len(part) <= _LONGEST else show(part) for part in parts)


def suggest(given: str, known: Iterable[str]) -> str | None:
    """Return the known word that `given` is most probably a misspelling of, or None."""
    words, short = list(known), given[:_LONGEST].lower()
    close = difflib.get_close_matches(short, words, n=1) or [word for word in words if len(short) > 2 and short in word]
    return close[0] if close else None


def write_hint(given: str, known: Iterable[str], otherwise: str = "") -> str:
    """End of a message on a name that is not known: "; did you mean `...`", or "; " and `otherwise` where none of the
    `known` is near."""
    close = suggest(given, known)
    hint = f"did you mean `{close}`" if close else otherwise
    return f"; {hint}" if hint else ""


def format_errors(
    error: ValidationError, raw: dict[str, Any], root: type[Section] = Case
) -> tuple[list[Problem], set[str]]:
    """Put what the schema `root` found into words.

    A key that is missing because it is misspelt is told once, as misspelt.

    Returns: the problems, one a key, and the keys (of options or sections) whose value is not to be used.
    """
    found: dict[str, Problem] = {}
    meant: set[str] = set()
    spoiled: set[str] = set()
    missing: dict[str, Problem] = {}
    for detail in error.errors(include_url=False, include_context=False, include_input=False):
        location = _cut_entry(detail["loc"])
        parts = [part for part in location if isinstance(part, str)]
        key = ".".join(parts)
        is_entry = len(location) < len(detail["loc"])
        spoiled.update((key, _name_list(location)))
        if detail["type"] == "extra_forbidden":
            wanted = _find_meant(parts, root) if len(found) < _MOST_MEANT else None
            meant.update([".".join([*parts[:-1], wanted])] if wanted else [])
            found[key] = _format_unknown(parts, wanted, root)
        elif detail["type"] == "missing" and not is_entry:
            missing[key] = _format_missing(key, root)
        else:
            table = _name_table(location, root)
            found[table + key] = Problem(key, table + _format_wrong(key, _look_up(raw, location), root))
    told = {key: problem for key, problem in missing.items() if key not in meant}
    return [*found.values(), *told.values()], {*meant, *spoiled}


def _cut_entry(location: Sequence[str | int]) -> list[str | int]:
    """A place in a file up to its last key: numbers behind it count entries of a value, those within it tables."""
    last = max(n for n, part in enumerate(location) if isinstance(part, str))
    return list(location[: last + 1])


def _name_list(location: Sequence[str | int]) -> str:
    """The key that `location` lies in: itself, or that of the list of tables around it."""
    tables = next((n for n, part in enumerate(location) if isinstance(part, int)), len(location))
    return ".".join(map(str, location[:tables]))


def _name_table(location: Sequence[str | int], root: type[Section]) -> str:
    """Which of a list of tables `location` lies in, counted from 1, for the front of a text; "" if in none."""
    number = next((part + 1 for part in location if isinstance(part, int)), None)
    return f"{_write_head(_name_list(location), root)} {number}: " if number is not None else ""


def _look_up(raw: dict[str, Any], location: Sequence[str | int]) -> Any:
    value: Any = raw
    for part in location:
        value = value[part]
    return value


def _find_meant(parts: list[str], root: type[Section]) -> str | None:
    return suggest(parts[-1], _list_keys(".".join(parts[:-1]), root))


def _list_keys(section: str, root: type[Section]) -> list[str]:
    """Keys that may stand in `section` of a file ("": at its top)."""
    of_file = FILE_KEYS if root is Case and not section else ()
    return [*of_file, *(list_sections(root) | list_tables(root))[section].model_fields]


@lru_cache
def _find_owners(root: type[Section]) -> dict[str, str]:
    """Last part of an option's key -> the first key that ends in it."""
    return {key.rpartition(".")[2]: key for key in reversed(list_options(root))}


def _format_unknown(parts: list[str], wanted: str | None, root: type[Section]) -> Problem:
    section = ".".join(parts[:-1])
    known = ", ".join(_list_keys(section, root))
    owner = _write_head(section, root) if section else f"a {root.__name__.lower()} file"
    guess = wanted or _find_owners(root).get(parts[-1])
    hint = f"; did you mean `{guess}`" if guess else "; remove it"
    return Problem(show_key(parts), f"{owner} has no such key, allowed are: {known}{hint}.")


def _write_head(section: str, root: type[Section]) -> str:
    return f"[[{section}]]" if section in list_tables(root) else f"[{section}]"


def _format_missing(key: str, root: type[Section]) -> Problem:
    if key in list_options(root):
        option = list_options(root)[key]
        section, _, name = key.rpartition(".")
        where = f"under {_write_head(section, root)}" if section else "at the top of the file"
        unit = f" in {option.unit}" if option.unit != "1" else ""
        return Problem(key, f"is missing; add `{name} = ...` {where}: {option.allowed}{unit}. {option.sentence}")
    needed = [name for name, field in list_sections(root)[key].model_fields.items() if field.is_required()]
    return Problem(key, f"the section is missing; add [{key}] with {', '.join(needed)}.")


def _format_wrong(key: str, value: Any, root: type[Section]) -> str:
    if key not in list_options(root):
        return f"{show(value)} is given, a section is allowed; write [{key}] and its keys below it."
    option = list_options(root)[key]
    unit = f" (in {option.unit})" if option.unit != "1" else ""
    if isinstance(value, str) and "list" in option.allowed and (entries := _split_list(value)):
        mend = f"write a list in square brackets: [{','.join(entries)}]"
    elif isinstance(value, str) and _DECIMAL_COMMA.fullmatch(value):
        mend = f"write a decimal point: {value.strip().replace(',', '.')}"
    elif option.unit != "1" and isinstance(value, list | tuple) and _may_have_commas(value):
        mend = "a comma parts two numbers, so write decimal points"
    elif isinstance(value, str) and "number" in option.allowed:
        mend = "give a bare number, without quotes or unit"
    elif isinstance(value, str) and (close := suggest(value, option.allowed.replace('"', "").split(" or "))):
        mend = f'did you mean "{close}"'
    elif not option.required:
        mend = f"fix the value, or leave the key out (default: {_format_default(option.default)})"
    else:
        mend = "fix the value"
    return f"{show(value)} is given, {option.allowed}{unit} is allowed; {mend}. {option.sentence}"


def _split_list(text: str) -> list[str]:
    """The entries of a list that was written without its brackets, as 20,4,80; none if it is no such list."""
    entries = [entry for entry in re.split(r"[,;\s]+", text.strip()) if entry]
    return entries if len(entries) > 1 and all(_BARE.fullmatch(entry) for entry in entries) else []


def _may_have_commas(value: Sequence[Any]) -> bool:
    """Is it a list of whole numbers, so many that each could be a half of one with a decimal comma?"""
    return len(value) > 1 and len(value) % 2 == 0 and all(type(entry) is int for entry in value)


def _format_default(default: Any) -> str:
    return "none" if default is None else show(default)
