"""A validator of the part of JSON schema (draft 2020-12) that the schema of case files uses; any other word fails."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

_KINDS = {"object": dict, "array": list, "string": str, "boolean": bool, "number": (int, float), "integer": int}
_SAYS_NOTHING = {"$schema", "title", "description", "default", "else"}


def list_errors(value: Any, schema: dict[str, Any], where: str = "file") -> Iterator[str]:
    """Where `value` breaks `schema`, and which of its words."""
    for word, rule in schema.items():
        if word not in _SAYS_NOTHING:
            yield from _WORDS[word](value, rule, schema, where)


def _type(value, rule, schema, where):
    fits = isinstance(value, _KINDS[rule]) and (rule == "boolean" or not isinstance(value, bool))
    if not fits:
        yield f"{where}: type"


def _properties(value, rule, schema, where):
    for name in rule.keys() & (value.keys() if isinstance(value, dict) else ()):
        yield from list_errors(value[name], rule[name], f"{where}.{name}")


def _additional(value, rule, schema, where):
    assert rule is False
    if isinstance(value, dict) and (more := value.keys() - schema["properties"].keys()):
        yield f"{where}: additionalProperties {sorted(more)}"


def _required(value, rule, schema, where):
    if isinstance(value, dict) and (missing := set(rule) - value.keys()):
        yield f"{where}: required {sorted(missing)}"


def _if(value, rule, schema, where):
    if list(list_errors(value, rule, where)):
        yield from list_errors(value, schema["else"], where)


def _prefix_items(value, rule, schema, where):
    for number, (entry, one) in enumerate(zip(value if isinstance(value, list) else [], rule, strict=False)):
        yield from list_errors(entry, one, f"{where}[{number}]")


def _items(value, rule, schema, where):
    for number, entry in enumerate(value if isinstance(value, list) else []):
        yield from list_errors(entry, rule, f"{where}[{number}]")


def _any_of(value, rule, schema, where):
    if all(list(list_errors(value, choice, where)) for choice in rule):
        yield f"{where}: anyOf"


def _limit(word, kinds, holds):
    def check(value, rule, schema, where):
        if isinstance(value, kinds) and not isinstance(value, bool) and not holds(value, rule):
            yield f"{where}: {word}"

    return check


_NUMBER = (int, float)
_WORDS = {
    "type": _type,
    "properties": _properties,
    "additionalProperties": _additional,
    "required": _required,
    "if": _if,
    "prefixItems": _prefix_items,
    "items": _items,
    "anyOf": _any_of,
    "enum": _limit("enum", object, lambda value, rule: value in rule),
    "minimum": _limit("minimum", _NUMBER, lambda value, rule: value >= rule),
    "maximum": _limit("maximum", _NUMBER, lambda value, rule: value <= rule),
    "exclusiveMinimum": _limit("exclusiveMinimum", _NUMBER, lambda value, rule: value > rule),
    "exclusiveMaximum": _limit("exclusiveMaximum", _NUMBER, lambda value, rule: value < rule),
    "minLength": _limit("minLength", str, lambda value, rule: len(value) >= rule),
    "maxLength": _limit("maxLength", str, lambda value, rule: len(value) <= rule),
    "minItems": _limit("minItems", list, lambda value, rule: len(value) >= rule),
    "maxItems": _limit("maxItems", list, lambda value, rule: len(value) <= rule),
    "uniqueItems": _limit("uniqueItems", list, lambda value, rule: len({str(v) for v in value}) == len(value)),
}
