"""How values and headings are written on the page: four digits, and units that never break over two lines."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from fbcouple.paths import TEMPLATES

SHORT = 24
"""Letters up to which a text stays on one line."""
LISTED = 4
"""Entries up to which a list is written out; the JSON file beside the page has all of them."""
_UNIT = re.compile(r"\[[^\[\]]*\]|(?<=\d) (?=(?:[kM]?g|[mk]?m|s|Pa|Hz|K)\b)|(?<=\b[msa]) (?=[a-zA-Z]{1,2}-\d)")
_FIXED = "\u00a0"


def open_templates(escapes: bool = True) -> Environment:
    """The templates of reports with the filters `shown`, `unbroken`, `narrow` and `halves`; `escapes`: of HTML."""
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES / "report"),
        undefined=StrictUndefined,
        autoescape=escapes,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"shown": show, "unbroken": keep_units, "narrow": is_narrow, "halves": split_rows}
    return environment


def show(value: Any, heading: str = "") -> str:
    """Write a value of a table: four digits of a number, three of a time, a dash for what there is none of.

    A time ends where its last step does, a little behind what was asked for: 0.05001 s.
    """
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return _show_list(value)
    return f"{value:.{3 if heading.endswith('[s]') else 4}g}" if isinstance(value, float) else str(value)


def _show_list(values: Sequence[Any]) -> str:
    """The entries of a list, or how many there are."""
    return f"{len(values)} values" if len(values) > LISTED else ", ".join(map(show, values)) or "none"


def keep_units(text: str) -> str:
    """The same text with blanks that do not break inside of units: "[kg m-2 s-1]", "2.5 kg m-3"."""
    return _UNIT.sub(lambda found: found.group().replace(" ", _FIXED), text)


def is_narrow(value: Any) -> bool:
    """Whether a cell has to stay on one line: numbers and short words."""
    return not isinstance(value, str) or len(value) <= SHORT


def split_rows(rows: list[Any]) -> list[list[Any]]:
    """Rows in two tables of about the same length, to stand side by side."""
    middle = (len(rows) + 1) // 2
    return [part for part in (rows[:middle], rows[middle:]) if part]
