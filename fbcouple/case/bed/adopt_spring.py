"""The spring of contacts that a case gives by what it does, `contact.max_overlap`, filled in."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.rest_overlap import find_rest_overlap
from fbcouple.case.bed.speeds import find_largest_overlap, list_speeds
from fbcouple.case.problems import Problem
from fbcouple.case.schema.sections import Case

SPRINGS: dict[str, tuple[str, float, float, float]] = {
    "hooke": ("stiffness", 1000.0, 2.0, 1.0),
    "hertz": ("youngs_modulus", 1e7, 2.5, 1.5),
}
"""Contact model -> its option of the spring, a value to try, and the powers of 1/overlap that it goes by: of an impact
at a speed (eqs 43-45; Johnson 1985, eq. 11.23), and under a weight."""
OVERLAP = "max_overlap"
HUGE = 1e30
DIGITS = 3
"""Digits that the spring is rounded up to."""


def adopt_spring(case: Case, folder: Path = Path()) -> tuple[Case, list[Problem]]:
    """The case with the spring that its `contact.max_overlap` asks for in place of that, of hertz also the impact speed
    where it is left out; its own files lie in `folder`. With it what is wrong; then the case is as it was."""
    contact = case.contact
    assert contact is not None and contact.max_overlap is not None
    name, trial, of_impact, of_weight = SPRINGS[contact.model]
    tried = case.model_copy(update={"contact": contact.model_copy(update={name: trial})})
    given = f"{contact.max_overlap:g} is given, and"
    region = find_region(case, folder)
    try:
        speeds = list_speeds(tried, region, None, folder)
        impact, rest = find_largest_overlap(tried, speeds)[0], find_rest_overlap(tried, region)
        if impact == 0.0:
            text = f"{given} nothing in the case makes a particle move, so that no {name} follows; give {name}."
            return case, [Problem(f"contact.{OVERLAP}", text)]
        wanted = contact.max_overlap
        spring = round_up(trial * max((impact / wanted) ** of_impact, (rest / wanted) ** of_weight))
        found = {name: spring, OVERLAP: None}
        if contact.model == "hertz" and contact.impact_speed is None:
            found["impact_speed"] = round_up(max(speed for _, speed, _ in speeds))
    except ArithmeticError:
        text = f"{given} the values are too large or too small to calculate with; give every one in SI units."
        return case, [Problem(f"contact.{OVERLAP}", text)]
    return case.model_copy(update={"contact": contact.model_copy(update=found)}), []


def gives_spring(raw: dict[str, Any]) -> bool:
    """Does `raw`, a case file's content, have a spring of its own?"""
    contact = raw.get("contact")
    return isinstance(contact, dict) and any(name in contact for name, *_ in SPRINGS.values())


def try_spring(raw: dict[str, Any]) -> dict[str, Any]:
    """The section [contact] of `raw`, a case file's content, for what no spring and no speed changes: with the values
    to try where it gives an overlap in place of them. Raises: KeyError if there is none."""
    contact: dict[str, Any] = raw["contact"]
    if OVERLAP not in contact or contact.get("model") != "hertz":
        return contact
    name, trial, *_ = SPRINGS["hertz"]
    return {name: trial, "impact_speed": 1.0} | contact


def has_spring(case: Case) -> bool:
    """Does the case give the spring of its contacts itself?"""
    assert case.contact is not None
    return SPRINGS[case.contact.model][0] in case.contact.model_fields_set


def round_up(value: float) -> float:
    """The next number of `DIGITS` digits that is not below a positive `value`. Raises: OverflowError if it is no number
    that something could have."""
    if not value < HUGE:
        raise OverflowError
    unit = 10.0 ** (math.floor(math.log10(value)) - DIGITS + 1)
    return float(f"{math.ceil(value / unit * (1.0 - 1e-12)) * unit:.{DIGITS}g}")
