"""The spring of contacts that a case gives by what it does, `contact.max_overlap`, filled in."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.rest_overlap import find_rest_overlap
from fbcouple.case.bed.speeds import find_largest_overlap, list_speeds
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

SPRINGS: dict[str, tuple[str, float, float, float]] = {
    "hooke": ("stiffness", 1000.0, 2.0, 1.0),
    "hertz": ("youngs_modulus", 1e7, 2.5, 1.5),
}
"""Contact model -> its option of the spring, a value to try, and the powers of 1/overlap that it goes by: of an impact
at a speed (eqs 43-45; Johnson 1985, eq. 11.23), and under a weight."""
OVERLAP = "max_overlap"
DIGITS = 3
"""Digits that the spring is rounded up to."""


def adopt_spring(case: Case, folder: Path = Path()) -> Case:
    """The case with the spring that its `contact.max_overlap` asks for in place of that, of hertz also the impact speed
    where it is left out; its own files lie in `folder`. What cannot be had is left as it is: the checks tell."""
    contact = case.contact
    if contact is None or case.particles is None or contact.max_overlap is None or has_spring(case):
        return case
    name, trial, of_impact, of_weight = SPRINGS[contact.model]
    tried = case.model_copy(update={"contact": contact.model_copy(update={name: trial})})
    try:
        region = find_region(case, folder)
        speeds = list_speeds(tried, region, None, folder)
        impact, rest = find_largest_overlap(tried, speeds)[0], find_rest_overlap(tried, region)
    except (CaseError, ArithmeticError):
        return case
    if impact == 0.0:
        return case
    wanted = contact.max_overlap
    spring = round_up(trial * max((impact / wanted) ** of_impact, (rest / wanted) ** of_weight))
    found = {name: spring, OVERLAP: None}
    if contact.model == "hertz" and contact.impact_speed is None:
        found["impact_speed"] = round_up(max(speed for _, speed, _ in speeds))
    return case.model_copy(update={"contact": contact.model_copy(update=found)})


def keep_last_said(raw: dict[str, Any], set_keys: set[str]) -> None:
    """Of overlap and spring in `raw`, a case file's content, leave what `--set` gives (`set_keys`) where the file gives
    the other one: a setting goes on top of the file."""
    contact = raw.get("contact")
    if not isinstance(contact, dict):
        return
    springs = [name for name, *_ in SPRINGS.values()]
    for said, other in (([OVERLAP], springs), (springs, [OVERLAP])):
        if any(f"contact.{name}" in set_keys for name in said):
            for name in other:
                if f"contact.{name}" not in set_keys:
                    contact.pop(name, None)


def has_spring(case: Case) -> bool:
    """Does the case give the spring of its contacts itself?"""
    assert case.contact is not None
    return SPRINGS[case.contact.model][0] in case.contact.model_fields_set


def round_up(value: float) -> float:
    """The next number of `DIGITS` digits that is not below a positive `value`."""
    unit = 10.0 ** (math.floor(math.log10(value)) - DIGITS + 1)
    return float(f"{math.ceil(value / unit * (1.0 - 1e-12)) * unit:.{DIGITS}g}")
