"""TOML of unknown origin into nested dicts, in a time that grows as the text."""

from __future__ import annotations

import re
import tomllib
from typing import Any

DEEPEST_KEY = 50
"""Parts of a dotted key; the parser of the standard library takes a time that grows as their number squared, and
for each key of a section that deep again (5000 parts and 5000 keys: 13 s)."""
_PART = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*"|'[^'\n]*')"""
_KEY = re.compile(rf"{_PART}(?:[ \t]*+\.[ \t]*+{_PART})++", re.ASCII)


class NestingError(ValueError):
    """Tables or lists within each other, deeper than any file of fbcouple has them."""


def parse_toml(text: str) -> dict[str, Any]:
    """Parse `text`.

    Raises: tomllib.TOMLDecodeError where it is not TOML, NestingError where tables or lists are nested too deeply.
    """
    for key in _KEY.finditer(text):
        if key[0].count(".") >= DEEPEST_KEY <= len(re.findall(_PART, key[0])):
            line = text.count("\n", 0, key.start()) + 1
            raise NestingError(f"line {line}: a key of more than {DEEPEST_KEY} parts")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise NestingError("lists or tables are nested too deeply") from None
