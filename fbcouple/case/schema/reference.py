"""The options of a case file as a list: dotted key, what is allowed, unit, default and sentence.

Read from the schema, so that messages and documents never say something else than what is enforced.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from typing import Any, get_args, get_origin

from pydantic_core import PydanticUndefined

from fbcouple.case.schema.option import Section
from fbcouple.case.schema.sections import Case

_KINDS = {
    "number": "a number",
    "integer": "a whole number",
    "string": "a text in quotes",
    "boolean": "true or false",
    "object": "a table",
}
_LIMITS = {
    "exclusiveMinimum": "above",
    "minimum": "at least",
    "exclusiveMaximum": "below",
    "maximum": "at most",
    "minLength": "of at least",
    "maxLength": "at most",
}


@dataclass(frozen=True)
class Option:
    """One option; `default` is None where there is none, `required` says whether the case must give it."""

    key: str
    allowed: str
    unit: str
    default: Any
    required: bool
    sentence: str


BASE = "base"
UNSET = "unset"
FILE_KEYS = {
    BASE: Option(
        BASE,
        "a text in quotes",
        "1",
        None,
        False,
        "Case that this file goes on top of, section by section: the name of a shipped case, or the relative path of a "
        ".toml file in the folder of this file or in a folder above it.",
    ),
    UNSET: Option(
        UNSET,
        "a list, each entry a key or a section in quotes",
        "1",
        (),
        False,
        'Keys and sections that are not taken over from `base`, as ["gas.closed_nozzle", "start"].',
    ),
}
"""Keys at the top of a case file that say where the other keys come from; no case has them once it is read."""


@cache
def list_sections(root: type[Section] = Case) -> dict[str, type[Section]]:
    """Return the sections of a case file (or of what `root` describes) by name; "" stands for the top of the file."""
    sections: dict[str, type[Section]] = {"": root}
    for name, field in root.model_fields.items():
        for part in () if get_origin(field.annotation) is tuple else (field.annotation, *get_args(field.annotation)):
            if isinstance(part, type) and issubclass(part, Section):
                sections[name] = part
    return sections


@cache
def list_tables(root: type[Section] = Case) -> dict[str, type[Section]]:
    """Return what each table of a list of tables holds, by the key of the list: `particles.feeds` is one, whose tables
    stand in a file as [[particles.feeds]]. Also lists at the top of a file."""
    tables: dict[str, type[Section]] = {}
    for section, model in list_sections(root).items():
        for name, field in model.model_fields.items():
            for part in get_args(field.annotation) if get_origin(field.annotation) is tuple else ():
                if isinstance(part, type) and issubclass(part, Section):
                    tables[f"{section}.{name}".lstrip(".")] = part
    return tables


@cache
def list_options(root: type[Section] = Case) -> dict[str, Option]:
    """Return every option of a schema by its dotted key, in the order of the schema; sections are not among them, the
    keys of tables in lists come last."""
    options = {}
    for section, model in (list_sections(root) | list_tables(root)).items():
        described = model.model_json_schema()
        for name, field in model.model_fields.items():
            if not section and name in list_sections(root):
                continue
            key = f"{section}.{name}" if section else name
            rules = described["properties"][name]
            default = None if field.default is PydanticUndefined else field.default
            options[key] = Option(
                key, format_rules(rules), rules["unit"], default, field.is_required(), field.description or ""
            )
    return options


@cache
def list_defaults() -> dict[str, Any]:
    """Return the default of every option of a case as JSON has it, by its dotted key; None where there is none."""
    return {key: json.loads(json.dumps(option.default)) for key, option in list_options().items()}


def format_rules(rules: dict[str, Any]) -> str:
    """Put the rules of one value (JSON schema) into words: kind and limits."""
    if "anyOf" in rules:
        return " or ".join(format_rules(r) for r in rules["anyOf"] if r.get("type") != "null")
    if "enum" in rules:
        return " or ".join(f'"{word}"' for word in rules["enum"])
    if rules["type"] == "array":
        return _format_list(rules)
    limits = [f"{word} {rules[name]:.10g}" for name, word in _LIMITS.items() if name in rules]
    unit = " characters" if limits and rules["type"] == "string" else ""
    return f"{_KINDS[rules['type']]} {' and '.join(limits)}".strip() + unit


def _format_list(rules: dict[str, Any]) -> str:
    if "items" not in rules:
        return f"a list of {rules['minItems']} values, each {format_rules(rules['prefixItems'][0])}"
    if "$ref" in rules["items"]:
        return "a list of tables"
    if "prefixItems" in rules["items"]:
        kinds = " and ".join(format_rules(rule) for rule in rules["items"]["prefixItems"])
        return f"a list of rows, each of {kinds}"
    return f"a list, each entry {format_rules(rules['items'])}"


def find_options(name: str) -> list[Option]:
    """Return the options that `name` means: all (""), those of a section, or a single one by its dotted key, or by the
    last part of it. The list is empty if there is none."""
    known = FILE_KEYS | list_options()
    if not name:
        return list(known.values())
    if name in known and name not in list_tables():
        return [known[name]]
    if name in list_tables():
        return [known[name], *(option for key, option in known.items() if key.startswith(f"{name}."))]
    if name in list_sections():
        return [option for key, option in known.items() if key.startswith(f"{name}.")]
    return [option for key, option in known.items() if key.rpartition(".")[2] == name]


def list_names() -> list[str]:
    """Every name that `find_options` knows: sections, dotted keys and last parts of keys."""
    keys = [*FILE_KEYS, *list_options()]
    return [*filter(None, list_sections()), *keys, *dict.fromkeys(key.rpartition(".")[2] for key in keys)]
