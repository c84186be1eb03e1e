"""Where a case comes from: shipped cases and sets of them, case files, and what `--set` puts on top of them."""

from __future__ import annotations

import codecs
import re
import tomllib
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import fbcouple.paths as paths  # noqa: PLR0402  (the package itself stands on a higher floor)
from fbcouple.case.problems import Problem, show, write_hint
from fbcouple.case.schema.reference import FILE_KEYS
from fbcouple.errors import CaseError
from fbcouple.input_files.toml_text import NestingError, parse_toml

FILE_NAME = "case.toml"
SETS_NAME = "sets.toml"
VALIDATION_NAME = "validation.toml"
"""Beside a case.toml: what was measured of that bed."""
STUDIES = "studies"
"""Folder of the shipped studies, whose files are no cases."""
LARGEST_FILE = 5_000_000
_DECIMAL_COMMA = re.compile(r"(?:=|\[|,\s)\s*([+-]?\d+,\d+(?:[eE][+-]?\d+)?)(?![\w.])")


def list_shipped() -> dict[str, Path]:
    """Return the case files that come with fbcouple, by name: patil/c2/case.toml and patil/c2.toml are `patil/c2`."""
    return dict(_list_cases(paths.CASES))


@cache
def _list_cases(folder: Path) -> dict[str, Path]:
    """What `list_shipped` gives of `folder`, looked up once."""
    others, named = (SETS_NAME, VALIDATION_NAME), {}
    for path in folder.glob("**/*.toml"):
        inner = path.parent if path.name == FILE_NAME else path.with_suffix("")
        if path.name not in others and path.relative_to(folder).parts[0] != STUDIES:
            named[inner.relative_to(folder).as_posix()] = path
    return {name: named[name] for name in sorted(named)}


def list_sets() -> dict[str, list[str]]:
    """Return the sets of shipped cases, by name (`patil/all`): the lists in the `sets.toml` files."""
    sets = {}
    for path in sorted(paths.CASES.glob(f"**/{SETS_NAME}")):
        folder = path.parent.relative_to(paths.CASES).as_posix()
        for name, members in read_toml(path, f"{folder}/{SETS_NAME}").items():
            sets[f"{folder}/{name}"] = [f"{folder}/{member}" for member in members]
    return sets


def find_case(name: str) -> Path:
    """Find the case file that `name` means: a shipped name, a case file, or a folder that holds a case.toml.

    Raises: CaseError with the shipped names, and the closest of them, if there is no such case.
    """
    shipped = list_shipped()
    if name in shipped:
        return shipped[name]
    try:
        path = Path(name)
        candidate = path / FILE_NAME if path.is_dir() else path
        if candidate.is_file():
            return candidate
        exists, is_folder = candidate.exists(), path.is_dir()
    except (OSError, ValueError) as error:
        raise CaseError([f"{show(name)}: cannot be a file name ({_reason(error)}); {_format_shipped(name)}"]) from None
    if is_folder:
        raise CaseError([f"{show(name)}: the folder holds no {FILE_NAME}; {_format_shipped(name)}"])
    if exists:
        raise CaseError([f"{show(name)}: is not a plain file; give a case file or the folder that holds one."])
    if name in list_sets():
        raise CaseError([f"{show(name)}: is a set of cases, which only `fbcouple setup` takes; give one of its cases."])
    raise CaseError([f"{show(name)}: neither a shipped case nor a file or folder; {_format_shipped(name)}"])


def _format_shipped(name: str) -> str:
    hint = write_hint(name, [*list_shipped(), *list_sets()])
    return f"`fbcouple cases` lists the shipped cases{hint}."


def _reason(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)[:200]


def read_toml(path: Path, label: str) -> dict[str, Any]:
    """Read a TOML file into nested dicts.

    Raises: CaseError naming `label`, with line and column where the text is not TOML.
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise CaseError([f"{label}: larger than {LARGEST_FILE / 1e6:.0f} MB; a case file has a few kB."])
        content = path.read_bytes()
        return parse_toml(content.decode("utf-8-sig"))
    except OSError as error:
        problem = f"cannot be read: {error.strerror}; check the path and its permissions."
    except tomllib.TOMLDecodeError as error:
        problem = _format_not_toml(str(error), content.decode("utf-8-sig").splitlines())
    except UnicodeDecodeError as error:
        problem = _format_not_utf8(error, content)
    except NestingError as error:
        problem = f"{error}; a case file needs two levels."
    except ValueError as error:
        problem = f"holds a value that cannot be read ({str(error)[:100]}); fix it."
    raise CaseError([f"{label}: {problem}"])


def _format_not_toml(words: str, lines: list[str]) -> str:
    """The place first, which the reader gives behind its words; a text of the file within them may be of any length."""
    what, _, where = words.rpartition(" (at ")
    position = where.removesuffix(")")
    number = re.match(r"line (\d+)", position)
    line = lines[int(number[1]) - 1] if number and int(number[1]) <= len(lines) else ""
    comma = _DECIMAL_COMMA.search(line)
    if comma:
        hint = f"{comma[1]} has a decimal comma; write a decimal point: {comma[1].replace(',', '.')}"
    elif any(word in what for word in ("overwrite", "twice", "declared", "mutate")):
        hint = "fix that line (a key or section is given twice)"
    elif "Unclosed" in what:
        hint = "close the bracket or the quotes that a line before leaves open"
    else:
        hint = "fix that line, or what is left open before it"
    return f"{position or 'the file'}: is not TOML: {show(what or words).strip(chr(34))}; {hint}."


def _format_not_utf8(error: UnicodeDecodeError, content: bytes) -> str:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "is UTF-16 text; save the file as UTF-8."
    line = content.count(b"\n", 0, error.start) + 1
    return f"line {line}: is not UTF-8 text (byte 0x{content[error.start]:02X}); save the file as UTF-8."


def apply_settings(raw: dict[str, Any], sets: Sequence[str]) -> tuple[set[str], list[Problem]]:
    """Put each `key.path=value` of `sets` into `raw`; whether the key exists is for the schema to say.

    Returns: the dotted keys that were set, and the problems of settings that could not be read.
    """
    keys: set[str] = set()
    problems = []
    for setting in sets:
        key, equals, text = setting.partition("=")
        parts = [part.strip() for part in key.split(".")]
        in_table = len(parts) == 4 and parts[2].isdecimal()
        if not equals or not all(parts) or (len(parts) > 2 and not in_table):
            text = (
                "is not a setting; write key=value or section.key=value, as gas.density=1.2, of one of several tables"
            )
            problems.append(
                Problem(show(setting), f"{text} section.tables.number.key=value, as gas.inlets.2.velocity=3.")
            )
        elif key.strip() in FILE_KEYS:
            problems.append(Problem(key.strip(), "is read from case files alone; write it into one."))
        elif not _is_text(setting):
            problems.append(Problem(show(setting), "is not UTF-8 text; use characters that your terminal can encode."))
        elif not text.strip():
            problems.append(Problem(".".join(parts), "no value is given; write a value after the equals sign."))
        elif in_table:
            problems += _place_in_table(raw, parts, read_value(text))
            keys.add(".".join(parts[:2]))
        elif not _place(raw, parts, read_value(text)):
            problems.append(Problem(".".join(parts), f"{parts[0]} is not a section in the case file; fix it there."))
        else:
            keys.add(".".join(parts))
    return keys, problems


def _is_text(text: str) -> bool:
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        return False
    return True


def _place(raw: dict[str, Any], parts: list[str], value: Any) -> bool:
    table = raw
    for part in parts[:-1]:
        inner = table.setdefault(part, {})
        if not isinstance(inner, dict):
            return False
        table = inner
    table[parts[-1]] = value
    return True


def _place_in_table(raw: dict[str, Any], parts: Sequence[str], value: Any) -> list[Problem]:
    """Put a value into one of the tables of a list, which are counted from 1."""
    section, name, number, key = parts
    inner = raw.get(section)
    inner = inner if isinstance(inner, dict) else {}
    tables = inner.get(name)
    if not isinstance(tables, list | tuple) or not all(isinstance(table, dict) for table in tables):
        return [Problem(".".join(parts), f"the case has no tables [[{section}.{name}]]; fix it in the case file.")]
    index = int(number) - 1
    if not 0 <= index < len(tables):
        text = f"the case has {len(tables)} tables [[{section}.{name}]], counted from 1 as in its file"
        return [Problem(".".join(parts), f"{text}; give one of these.")]
    changed = [table | {key: value} if n == index else table for n, table in enumerate(tables)]
    raw[section] = inner | {name: changed}
    return []


def read_value(text: str) -> Any:
    """Read a TOML value; words that are not TOML are text, which the schema refuses where it wants a number."""
    try:
        read = parse_toml(f"value = {text}")
    except ValueError:
        return text
    return read["value"] if set(read) == {"value"} else text
