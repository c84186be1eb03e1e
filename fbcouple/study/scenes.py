"""The scenes of a stability study: every combination of what its tables list, once for each exchange form."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fbcouple.case.bed.derived import dem_step, fastest_inlet, pair_contact_time
from fbcouple.case.bed.exchange_numbers import response_times
from fbcouple.case.bed.fluid_step import coupling_step, gas_step
from fbcouple.case.bed.step_limits import measure_limits
from fbcouple.case.load import load_case
from fbcouple.case.problems import Problem, show, write_hint
from fbcouple.case.schema.reference import list_options
from fbcouple.case.schema.sections import Case
from fbcouple.case.source import find_case
from fbcouple.errors import CaseError
from fbcouple.study.schema import Stability
from fbcouple.study.source import (
    Settings,
    Source,
    check_keys,
    check_number,
    find_mistakes,
    flatten,
    format_settings,
    put_on_top,
)

SPANS = ("gas", "particles", "contact", "fall", "passage")
OWN = ("base", "span", "forms", "times", "ranks")
FORM = "exchange.scheme"
ROWS = 50
"""History rows of a scene."""
MOMENTS = 10
"""Moments for a checkpoint in a scene of so many steps as expected."""


@dataclass(frozen=True)
class Scene:
    """One run of a stability study; `varied` is what tells it from its group's other scenes, `form` its drag scheme
    or "" where nothing is exchanged."""

    name: str
    group: str
    base: str
    settings: Settings
    varied: Settings
    form: str
    ranks: int


def list_scenes(study: Stability, source: Source) -> list[Scene]:
    """Every scene, with an end time of its own. Raises: CaseError with all mistakes of the study and of its cases."""
    problems = [f"{source.label}: {problem}" for problem in _check(study)]
    if problems:
        raise CaseError(problems)
    scenes: list[Scene] = []
    for group, table in study.scenes.items():
        try:
            scenes += _expand(study, source, group, flatten(table))
        except CaseError as error:
            problems += error.problems
    if problems:
        raise CaseError(list(dict.fromkeys(problems)))
    return scenes


def _check(study: Stability) -> Iterator[Problem]:
    yield from check_keys(list(flatten(study.set)), "set")
    yield from _check_forms("forms", study.forms)
    for group, table in study.scenes.items():
        if not isinstance(table, dict):
            yield Problem(f"scenes.{group}", f"{show(table)} is given, a table is allowed; write [scenes.{group}].")
            continue
        yield from check_keys(list(flatten(table)), f"scenes.{group}", OWN)
        yield from _check_forms(f"scenes.{group}.forms", table.get("forms", []))
        span = table.get("span", study.span)
        if span not in SPANS:
            text = f"{show(span)} is given, allowed are: {', '.join(SPANS)}; fix the value."
            yield Problem(f"scenes.{group}.span", text)
        for key, low in (("times", 0.0), ("ranks", 1)):
            value = table.get(key, 1)
            if isinstance(value, bool) or not isinstance(value, int | float) or value < low:
                yield Problem(f"scenes.{group}.{key}", f"{show(value)} is given, a number from {low} is allowed.")


def _check_forms(key: str, forms: Any) -> Iterator[Problem]:
    allowed = list_options()[FORM].allowed.replace('"', "").split(" or ")
    for form in forms if isinstance(forms, list | tuple) else [forms]:
        if form not in allowed:
            hint = write_hint(form, allowed) if isinstance(form, str) else ""
            yield Problem(key, f"{show(form)} is given, allowed are: {', '.join(allowed)}{hint}.")


def _expand(study: Stability, source: Source, group: str, table: Settings) -> Iterator[Scene]:
    own = {key: table.pop(key) for key in OWN if key in table}
    base = source.find_base(own.get("base", study.base))
    lists = {key: value if _is_list_of(key, value) else [value] for key, value in table.items()}
    common = flatten(study.set)
    if problems := list(check_number(f"scenes.{group}", lists, "take fewer values")):
        raise CaseError([f"{source.label}: {problem}" for problem in problems])
    for values in itertools.product(*lists.values()):
        settings = put_on_top(common, dict(zip(lists, values, strict=True)))
        varied = {key: settings[key] for key, choice in lists.items() if len(choice) > 1}
        name = "-".join([group, *(_word(value) for value in varied.values())])
        if mistakes := find_mistakes(base, settings, f"{source.label}: {name}"):
            raise CaseError(mistakes)
        case = load_case(base, format_settings(settings))
        for form in own.get("forms", study.forms) if case.exchange else ("",):
            timed = settings | ({FORM: form} if form else {})
            wanted = load_case(base, format_settings(timed))
            end = find_end(wanted, study, own, f"{source.label}: {name}", find_case(base).parent)
            timed |= {"end_time": end, "output.record_every": end / ROWS}
            if study.restart:
                # Without gas nothing but the rows says how long a coupling step is.
                steps = end / find_step(wanted, find_case(base).parent) if wanted.gas else ROWS
                moment = max(1, int(steps / MOMENTS))
                timed |= {"checkpoint.every": end / 2, "checkpoint.moment_steps": moment}
            full = f"{name}-{form}" if form else name
            yield Scene(full, group, base, timed, varied, form, int(own.get("ranks", study.ranks)))


def _is_list_of(key: str, value: Any) -> bool:
    """Is `value` a list of values of `key`, not one value that is a list itself?"""
    depth = {"a list": 1, "a list of rows": 2}
    allowed = list_options()[key].allowed
    own = next((n for words, n in reversed(depth.items()) if allowed.startswith(words)), 0)
    found = value
    for _ in range(own):
        found = found[0] if isinstance(found, list) and found else None
    return isinstance(found, list)


def _word(value: Any) -> str:
    if isinstance(value, list | tuple):
        return "x".join(map(_word, value))
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return "".join(letter if letter.isalnum() or letter in "+." else "_" for letter in text)


def find_end(case: Case, study: Stability, own: Settings, label: str, folder: Path) -> float:
    """Simulated time [s] of a scene: its characteristic times, and no less than the study's fluid steps; the case's own
    files lie in `folder`.

    Raises: CaseError if the scene has no such time.
    """
    name = own.get("span", study.span)
    span = find_span(case, name)
    if span is None:
        raise CaseError([f"{label}: span: {show(name)} is given, and the scene has no such time; give another."])
    end = max(own.get("times", study.times) * span, study.steps * find_step(case, folder))
    return min(end, study.longest) if study.longest else end


def find_span(case: Case, name: str) -> float | None:
    """A characteristic time [s] of a case by its name, None if it has none."""
    if name in ("gas", "particles"):
        both = case.gas is not None and case.particles is not None
        return response_times(case)[{"gas": "tau_g", "particles": "tau_p"}[name]] if both else None
    if name == "contact":
        return pair_contact_time(case.contact, case.particles) if case.contact and case.particles else None
    if name == "fall":
        return math.sqrt(2.0 * case.domain.size[2] / case.gravity) if case.gravity else None
    fastest = fastest_inlet(case.gas) if case.gas else 0.0
    return case.domain.size[2] / fastest if fastest else None


def find_step(case: Case, folder: Path) -> float:
    """Step [s] that a case whose own files lie in `folder` is expected to take."""
    if case.gas and case.particles:
        return coupling_step(case, measure_limits(case, folder))
    if case.gas:
        return gas_step(case, limits=measure_limits(case, folder))
    assert case.contact is not None and case.particles is not None
    return dem_step(case.contact, case.particles)
