"""How a claim is judged: each number against a margin that was fixed before the runs, beyond its errors or not at all.

A number decides if its interval of two standard errors lies wholly on one side of its margin. Where it reaches over the
margin, it is told how much longer the windows of the runs would have to be.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from fbcouple.postproc.measures import Measured
from fbcouple.postproc.value_text import with_error
from fbcouple.results.reader import Results

Runs = Mapping[str, Results]
LONGEST = 100.0
"""Factor on the window from which a number is said to lie on its margin."""


@dataclass(frozen=True)
class Answer:
    """Whether a number is as wanted; None if its two standard errors reach over the margin. Then `longer` is the factor
    on the window that takes them off it, if the number stays. of: the beds of the number, where there are several."""

    holds: bool | None
    longer: float = 1.0
    of: str = ""


@dataclass(frozen=True)
class Finding:
    """What was measured, in words, and whether the claim holds; None if the numbers do not decide it, and why."""

    measured: str
    holds: bool | None
    why: str = ""


Judge = Callable[[Runs], Finding]


def above(value: Measured, limit: float = 0.0) -> Answer:
    """Whether the value is above `limit`."""
    return Answer(value.is_above(limit), _stretch(value.error, value.value - limit))


def below(value: Measured, limit: float = 0.0) -> Answer:
    """Whether the value is below `limit`."""
    return above(Measured(-value.value, value.error), -limit)


def within(value: Measured, middle: float, allowed: float) -> Answer:
    """Whether the value is within `allowed` of `middle`."""
    return below(Measured(abs(value.value - middle), value.error), allowed)


def _stretch(error: float, apart: float) -> float:
    """Factor on the window by which the error falls to half of the distance from the margin; nan where there is no
    error."""
    if math.isnan(error):
        return math.nan
    return math.inf if apart == 0.0 else (2.0 * error / apart) ** 2


def fall(values: Sequence[Measured]) -> list[Answer]:
    """Whether the values fall from the first to the last, and rise nowhere between neighbours by more than their
    errors."""
    rises = [after - before for before, after in pairwise(values)]
    unknown = [Answer(None, math.nan) for rise in rises if math.isnan(rise.error)]
    return [above(values[0] - values[-1]), *unknown, *(Answer(False) for rise in rises if rise.is_above(0.0))]


def rise(values: Sequence[Measured]) -> list[Answer]:
    """The same the other way round."""
    return fall([Measured(-value.value, value.error) for value in values])


def is_largest(values: Mapping[str, Measured], name: str) -> list[Answer]:
    """Whether the value `name` is above each of the others."""
    return [
        replace(above(values[name] - value), of=f"{name} against {other}")
        for other, value in values.items()
        if other != name
    ]


def settle(measured: str, answers: Iterable[Answer]) -> Finding:
    """Every answer must be yes; one clear no is enough for no; otherwise the numbers lie within their errors."""
    found = list(answers)
    if any(answer.holds is False for answer in found):
        return Finding(measured, False)
    waiting = [answer for answer in found if answer.holds is None]
    if not waiting:
        return Finding(measured, True)
    if bare := [answer for answer in waiting if math.isnan(answer.longer)]:
        why = f"a number has no standard error{_name(bare)}: longer windows, or results with blocks"
        return Finding(measured, None, why)
    if stuck := [answer for answer in waiting if answer.longer > LONGEST]:
        return Finding(measured, None, f"within two standard errors{_name(stuck)}: a number lies on its margin")
    longest = max(answer.longer for answer in waiting)
    times = f"{longest:.1f}" if longest < 10.0 else f"{longest:.0f}"
    why = f"within two standard errors{_name(waiting)}: windows {times} times as long decide, if it stays"
    return Finding(measured, None, why)


def _name(answers: Sequence[Answer]) -> str:
    """Which beds the answers are of, in brackets, where that is known."""
    names = ", ".join(dict.fromkeys(answer.of for answer in answers if answer.of))
    return f" ({names})" if names else ""


def word(values: Iterable[Measured], factor: float = 1.0, unit: str = "") -> str:
    """Values with their standard errors, where they are known, in `unit` after `factor`."""
    text = ", ".join(with_error(factor * value.value, factor * value.error) for value in values)
    return f"{text} {unit}".strip()
