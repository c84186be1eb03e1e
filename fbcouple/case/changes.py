"""What a case says, option by option, kept beside a run, and what has become of it since."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from fbcouple.case.problems import show
from fbcouple.case.schema.reference import list_options
from fbcouple.case.schema.sections import Case

FREE = ("end_time", "output.save_every", "output.profile_heights")
FREE_SECTIONS = ("monitors", "checkpoint")
"""What may be changed in a run folder at any time: what ends a run, what stops it, how often files are saved, and
what figures show."""

Values = dict[str, Any]
"""Option, by its dotted key -> value, as JSON has it."""


@dataclass(frozen=True)
class Change:
    """An option of another value than before."""

    key: str
    before: Any
    now: Any

    def __str__(self) -> str:
        return f"{self.key} was {_word(self.before)} and is {_word(self.now)} now"


def list_values(case: Case) -> Values:
    """Every option of `case` that matters to what a run computes; a section that is there is true."""
    values: Values = {}
    for name, value in case.model_dump(mode="json").items():
        if isinstance(value, dict):
            values |= {name: True} | {f"{name}.{key}": given for key, given in value.items()}
        else:
            values[name] = value
    return {key: value for key, value in values.items() if not _is_free(key)}


def list_changes(before: Values, case: Case) -> list[Change]:
    """Options whose value in `case` is not the one in `before`; one that is younger than `before` had its default."""
    now = list_values(case)
    defaults = {key: json.loads(json.dumps(option.default)) for key, option in list_options().items()}
    known = sorted({*before, *(key for key in now if key in defaults)})
    changes = [Change(key, before.get(key, defaults.get(key)), now.get(key)) for key in known]
    return [change for change in changes if change.before != change.now]


def _is_free(key: str) -> bool:
    return key in FREE or key.partition(".")[0] in FREE_SECTIONS


def _word(value: Any) -> str:
    return "not given" if value is None else show(value)
