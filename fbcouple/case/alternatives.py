"""Options that say the same in another way: which of them a case keeps where `--set` gives one and its file the other,
and how the other is told to be removed."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from fbcouple.case.problems import Problem
from fbcouple.case.schema.reference import UNSET, list_tables
from fbcouple.case.schema.sections import Case

_PAIRS = (
    ("contact.max_overlap", "contact.stiffness"),
    ("contact.max_overlap", "contact.youngs_modulus"),
    ("particles.coarse_graining", "particles.parcels"),
    ("particles.mass", "particles.count"),
    ("gas.inlet_velocity", "gas.inlet_ramp"),
    ("gas.closed_nozzle", "gas.closed_nozzle_size"),
    ("heat.gas_conductivity", "heat.prandtl"),
    ("start.run", "start.restart"),
)
_ONE_WAY = (
    ("gas.inlets", "gas.inlet_velocity"),
    ("gas.inlets", "gas.inlet_ramp"),
    ("start.restart", "start.time"),
)
"""The other way round the tables would be lost, which say more than a velocity, and a time says no file."""
REPLACED: tuple[tuple[str, str], ...] = (*_PAIRS, *((other, one) for one, other in _PAIRS), *_ONE_WAY)
"""Option, and the one that it takes the place of."""


def list_replaced(raw: dict[str, Any], values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Of `REPLACED` the pairs of which `values`, by dotted key, go on top of a case file's content `raw` and `raw` has
    the other one."""
    return [pair for pair in list_displaced(values) if has_option(raw, pair[1])]


def list_displaced(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Of `REPLACED` the pairs of which `values`, by dotted key, say one and not the other; an empty list says
    nothing."""
    return [(said, other) for said, other in REPLACED if values.get(said, []) != [] and other not in values]


def keep_last_said(raw: dict[str, Any], set_keys: Collection[str]) -> list[Problem]:
    """Remove from `raw`, a case file's content with what `--set` gives (`set_keys`) in it, what the file says in
    another way: a setting goes on top of the file. Returns: a setting that cannot, and is removed itself."""
    for _, other in list_replaced(raw, {key: _look_up(raw, key) for key in set_keys}):
        _pop(raw, other)
    return [
        _refuse(raw, key)
        for key in ("gas.inlet_velocity", "gas.inlet_ramp")
        if key in set_keys and "gas.inlets" not in set_keys and _look_up(raw, "gas.inlets")
    ]


def has_option(raw: dict[str, Any], dotted: str) -> bool:
    """Does a case file's content `raw` give this option?"""
    return _look_up(raw, dotted) is not None


def _refuse(raw: dict[str, Any], key: str) -> Problem:
    _pop(raw, key)
    text = "is given for the whole floor and the case has [[gas.inlets]], which say where gas comes in"
    mend = "give their velocities in the file, or take them away: gas.inlets=[] too"
    return Problem(key, f"{text}; {mend}.")


def _look_up(raw: dict[str, Any], dotted: str) -> Any:
    section, _, key = dotted.partition(".")
    table = raw.get(section)
    return table.get(key) if isinstance(table, dict) else None


def _pop(raw: dict[str, Any], dotted: str) -> None:
    section, _, key = dotted.partition(".")
    if isinstance(table := raw.get(section), dict):
        table.pop(key, None)


def tell_of_base(problem: Problem, inherited: Collection[str]) -> Problem:
    """A problem that asks for its option to be removed says how, where the base of the case brought that option."""
    key = problem.key
    if key not in inherited or key in list_tables():  # of a list of tables one is meant
        return problem
    what = rf"\bremove (it|this|\[{key}\])(?!\w)"
    return Problem(key, re.sub(what, rf'remove \1 by {UNSET} = ["{key}"]', problem.text, count=1))


def word_removal(case: Case, given: Iterable[str]) -> str:
    """How one of the options `given` of a case is removed: where its base brought some of them and its file the others,
    those of the base."""
    keys = list(given)
    inherited = [key for key in keys if key in case.inherited]
    if not inherited:
        return "remove one"
    names = ", ".join(f'"{key}"' for key in (inherited if len(inherited) < len(keys) else inherited[1:]))
    return f"remove one, that of the base by {UNSET} = [{names}]"
