"""What a member's error is measured by, as a registry. To add one: a function under `@measure("name")`.

A measure compares a finished run with a number that follows from physics, with the finest member, or with measured
points; the case file calls it by its name, `name:argument` where it takes one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from fbcouple.case.problems import Problem, show, write_hint
from fbcouple.case.schema.sections import Case
from fbcouple.results.reader import Results


@dataclass(frozen=True)
class Error:
    """A member's value beside the expected one, SI; `error` is relative to the measure's scale, `stderr` its
    statistical standard error: None where chance plays no part in it, nan where it does and nothing tells how much."""

    value: float
    expected: float
    unit: str
    error: float
    stderr: float | None = None


@dataclass(frozen=True)
class Finished:
    """A finished run: its results and its case, which was checked."""

    results: Results
    case: Case


Function = Callable[[Finished, str, Finished | None], Error]


@dataclass(frozen=True)
class Measure:
    """A measure: its function, the arguments that it takes (none: it takes no argument), what it compares with, and
    what of `NEEDS` the case of its runs has to have."""

    name: str
    function: Function
    arguments: tuple[str, ...]
    needs_reference: bool
    needs: tuple[str, ...]


MEASURES: dict[str, Measure] = {}
NEEDS: dict[str, Callable[[Case], bool]] = {
    "[averages]": lambda case: case.averages is not None,
    "output.snapshots_every": lambda case: case.output.snapshots_every is not None,
    "output.particles_every": lambda case: case.output.particles_every is not None,
    "output.references": lambda case: bool(case.output.references),
}
"""What a case may have, by its key."""


def measure(
    name: str, arguments: Sequence[str] = (), needs_reference: bool = False, needs: Sequence[str] = ()
) -> Callable[[Function], Function]:
    """Register a measure under the name by which a study calls it."""

    def register(function: Function) -> Function:
        MEASURES[name] = Measure(name, function, tuple(arguments), needs_reference, tuple(needs))
        return function

    return register


def check_needs(texts: Sequence[str], case: Case) -> Iterator[Problem]:
    """The runs of `case` have what the measures are of."""
    for text in texts:
        for key in MEASURES[text.partition(":")[0]].needs:
            if not NEEDS[key](case):
                yield Problem("measures", f"{show(text)} is given and the case has no {key}; give it that, by [set].")


def check_measures(texts: Sequence[str], has_reference: bool) -> Iterator[Problem]:
    """Each text names a measure, with an argument that it takes, and what it compares with is there."""
    if not texts:
        yield Problem("measures", f"the list is empty; give one or more of: {', '.join(MEASURES)}.")
    for text in texts:
        name, _, argument = text.partition(":")
        if name not in MEASURES:
            hint = write_hint(name, MEASURES)
            yield Problem("measures", f"{show(text)} is given, allowed are: {', '.join(MEASURES)}{hint}.")
            continue
        allowed = MEASURES[name].arguments
        if bool(allowed) != bool(argument) or (argument and argument not in allowed):
            hint = write_hint(text, [f"{name}:{one}" for one in allowed])
            wanted = f"{name}: and one of {', '.join(allowed)}" if allowed else f"`{name}` without an argument"
            yield Problem("measures", f"{show(text)} is given, {wanted} is allowed{hint}.")
        if MEASURES[name].needs_reference and not has_reference:
            yield Problem("measures", f"{show(text)} compares with the finest member; add [reference] with its keys.")


def find_error(text: str, run: Finished, reference: Finished | None) -> Error:
    """Measure `run` by the measure that `text` names.

    Raises: CaseError if the results lack what it needs.
    """
    name, _, argument = text.partition(":")
    return MEASURES[name].function(run, argument, reference)
