"""The members of an error-against-run-time study: what the knobs and their values make of the base case."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from fbcouple.case.bed.particle_types import find_ratio, grain_count, particle_count
from fbcouple.case.load import load_case
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.option import as_tuple
from fbcouple.case.schema.particles import Particles
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.study.schema import Study
from fbcouple.study.source import (
    MOST,
    Settings,
    Source,
    check_keys,
    check_number,
    find_mistakes,
    flatten,
    format_settings,
    put_on_top,
)

RANKS = "ranks"
REFERENCE = "reference"
MOST_RANKS = 1024
NUMBERS: dict[str, Callable[[Particles], float]] = {
    "particles.parcels": particle_count,
    "particles.count": grain_count,
    "particles.coarse_graining": find_ratio,
}
"""Knobs that a case may give in another way -> what it has of them."""


@dataclass(frozen=True)
class Member:
    """One run of a study: its `settings` on top of the base, and the value of every knob in it."""

    name: str
    settings: Settings
    knobs: Settings
    ranks: int = 1


def list_members(study: Study, source: Source) -> list[Member]:
    """Every member, the base first where it is one, each once; the reference last if the study names one.

    Raises: CaseError with all mistakes of the study and of its members' cases.
    """
    base, common, knobs = source.find_base(study.base), flatten(study.set), flatten(study.knobs)
    problems = [f"{source.label}: {problem}" for problem in _check(study, knobs)]
    if problems:
        raise CaseError(problems)
    if mistakes := find_mistakes(base, common, f"{source.label}: base"):
        raise CaseError(mistakes)
    usual = {key: _find_value(load_case(base, format_settings(common)), common, key) for key in knobs}
    members: list[Member] = []
    for values in _combine(study.design, usual, knobs):
        if all(member.knobs != values for member in members):
            members.append(_make(values, usual, common, members))
    if study.reference:
        finest = usual | {key: value for key, value in flatten(study.reference).items() if key in usual}
        members.append(Member(REFERENCE, put_on_top(common, flatten(study.reference)), finest))
    for member in members:
        problems += find_mistakes(base, member.settings, f"{source.label}: {member.name}")
    if problems:
        raise CaseError(list(dict.fromkeys(problems)))
    return [_look_at_knobs(member, base) for member in members]


def _check(study: Study, knobs: Settings) -> Iterator[Problem]:
    yield from check_keys(list(flatten(study.set)), "set")
    yield from check_keys(list(flatten(study.reference)), "reference")
    yield from check_keys(list(knobs), "knobs", (RANKS,))
    if not knobs:
        yield Problem("knobs", "the table is empty; give a case key and its list of values.")
    for key, values in knobs.items():
        if not isinstance(values, list) or not values:
            yield Problem(f"knobs.{key}", f"{show(values)} is given, a list of values is allowed; write [a, b, ...].")
        elif key == RANKS and not all(type(n) is int and 1 <= n <= MOST_RANKS for n in values):
            text = f"{show(values)} is given, whole numbers from 1 to {MOST_RANKS} are allowed; fix the values."
            yield Problem(f"knobs.{key}", text)
    lists = {key: values for key, values in knobs.items() if isinstance(values, list)}
    if study.design == "grid":
        yield from check_number("knobs", lists, 'take fewer values, or design = "each"')
    elif sum(map(len, lists.values())) >= MOST:
        yield Problem("knobs", f"more than {MOST} members are given, as many are allowed; take fewer values.")


def _look_at_knobs(member: Member, base: str) -> Member:
    """The member with every knob as its case has it: a preset turns several at once. One that the case does not keep,
    for it stands for others (contact.max_overlap), as the member sets it."""
    case, set_by = load_case(base, format_settings(member.settings)), member.settings
    return replace(
        member, knobs={k: v if k == RANKS else _find_value(case, set_by, k) for k, v in member.knobs.items()}
    )


def _look_up(case: Case, key: str) -> Any:
    if key == RANKS:
        return 1
    value: Any = case
    for part in key.split("."):
        value = getattr(value, part, None)
    return value


def _find_value(case: Case, settings: Settings, key: str) -> Any:
    if key in NUMBERS and case.particles is not None:
        return NUMBERS[key](case.particles)
    value = _look_up(case, key)
    return settings.get(key) if value is None else value


def _combine(design: str, usual: Settings, knobs: Settings) -> Iterator[Settings]:
    """Value of every knob for each member; lists of TOML are held as the tuples of the schema."""
    if design == "grid":
        for values in itertools.product(*knobs.values()):
            yield dict(zip(knobs, map(as_tuple, values), strict=True))
        return
    yield usual
    for key, values in knobs.items():
        for value in values:
            yield usual | {key: as_tuple(value)}


def _make(values: Settings, usual: Settings, common: Settings, known: list[Member]) -> Member:
    differs = {key: value for key, value in values.items() if value != usual[key]}
    stem = "_".join(f"{key.split('.')[-1]}-{_word(value)}" for key, value in differs.items()) or "base"
    taken = {member.name for member in known}
    names = itertools.chain([stem], (f"{stem}.{k}" for k in itertools.count(2)))
    name = next(name for name in names if name not in taken)
    settings = put_on_top(common, {key: value for key, value in differs.items() if key != RANKS})
    return Member(name, settings, values, values.get(RANKS, 1))


def _word(value: Any) -> str:
    """A value as part of a folder's name."""
    if isinstance(value, tuple):
        return "x".join(map(_word, value))
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return "".join(letter if letter.isalnum() or letter in "+-." else "-" for letter in text)
