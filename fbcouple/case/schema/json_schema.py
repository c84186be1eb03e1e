"""The options of a case file as a JSON schema (draft 2020-12), for editors that check TOML while it is written."""

from __future__ import annotations

from typing import Any

from fbcouple.case.schema.gas import FROM_MESH
from fbcouple.case.schema.reference import BASE, FILE_KEYS, UNSET, list_options, list_sections, list_tables
from fbcouple.case.schema.sections import Case

DRAFT = "https://json-schema.org/draft/2020-12/schema"
Rules = dict[str, Any]


def build_schema() -> Rules:
    """Return the schema of a case file. A file with a `base` may leave out what the base has; others must be complete.

    It holds what the options say one by one. What they must be together is for `fbcouple check` to say.
    """
    described = Case.model_json_schema()
    top = _simplify(described)
    sections = {name: _simplify(described["$defs"][model.__name__]) for name, model in list_sections().items() if name}
    for key, model in list_tables().items():
        section, _, name = key.partition(".")
        sections[section]["properties"][name]["items"] = _simplify(model.model_json_schema())
    needed = [name for name in top.pop("required") if name != BASE]
    needed_below = {name: rules.pop("required") for name, rules in sections.items() if "required" in rules}
    needed_below["domain"] = [key for key in needed_below["domain"] if key not in FROM_MESH]
    properties = _describe_file_keys() | top["properties"] | sections
    complete = {"required": needed, "properties": {name: {"required": keys} for name, keys in needed_below.items()}}
    return {
        "$schema": DRAFT,
        "title": "Case file of fbcouple",
        "type": "object",
        "properties": properties,
        "additionalProperties": False,
        "if": {"required": [BASE]},
        "else": complete,
    }


def _describe_file_keys() -> Rules:
    names = [*(name for name in list_sections() if name), *list_options()]
    return {
        BASE: {"type": "string", "description": FILE_KEYS[BASE].sentence},
        UNSET: {
            "type": "array",
            "items": {"type": "string", "enum": names},
            "uniqueItems": True,
            "description": FILE_KEYS[UNSET].sentence,
        },
    }


def _simplify(described: Rules) -> Rules:
    """Of a section its type and its keys; sections within it, which the top has, are left out."""
    keys = {name: rules for name, rules in described["properties"].items() if "unit" in rules}
    simple: Rules = {"type": "object", "properties": {name: _word(rules) for name, rules in keys.items()}}
    return simple | {"additionalProperties": False, "required": described.get("required", [])}


def _word(rules: Rules) -> Rules:
    """The rules of one key, without the null that TOML does not have, with the unit in the sentence."""
    kept = {name: value for name, value in rules.items() if name not in ("anyOf", "title", "unit")}
    choices = [choice for choice in rules.get("anyOf", ()) if choice != {"type": "null"}]
    kept |= {"anyOf": choices} if len(choices) > 1 else choices[0] if choices else {}
    if kept.get("default", 0) is None:
        del kept["default"]
    unit = "" if rules["unit"] == "1" else f" [{rules['unit']}]"
    return kept | {"description": rules["description"] + unit}
