"""Pareto front of error and cost, and what each knob does to both."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from fbcouple.study.members import Member

_LEAST = 3
"""Points that a slope or an order is fitted to, at least."""


def mark_pareto(costs: Sequence[float], errors: Sequence[float]) -> list[bool]:
    """Is no other member at least as cheap and as exact, and better in one of the two? Not finite: never."""
    points = list(zip(costs, errors, strict=True))
    return [
        math.isfinite(cost)
        and math.isfinite(error)
        and not any(c <= cost and e <= error and (c < cost or e < error) for c, e in points)
        for cost, error in points
    ]


def find_excess(costs: Sequence[float], errors: Sequence[float], bars: Sequence[float]) -> list[float]:
    """Cost of each member over that of the cheapest one of its accuracy: of those whose error is not larger, or larger
    by less than both standard errors `bars` together. nan for a member without cost or error, and for one whose
    standard error is not known (nan); to others such a member is of their accuracy if its error is not larger."""
    points = [p for p in zip(costs, errors, bars, strict=True) if math.isfinite(p[0]) and math.isfinite(p[1])]
    return [
        cost / min(c for c, e, b in points if e <= error or e <= error + math.hypot(b, bar))
        if all(map(math.isfinite, (cost, error, bar)))
        else math.nan
        for cost, error, bar in zip(costs, errors, bars, strict=True)
    ]


def find_coordinate(value: Any) -> float | None:
    """A knob's value as a number: itself, the geometric mean of a list (cells along an axis), None for words."""
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return None
    values = value if isinstance(value, tuple | list) else [value]
    if not values or not all(isinstance(v, int | float) and v > 0 for v in values):
        return None
    return math.exp(sum(map(math.log, values)) / len(values))


def fit_slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Slope of log y against log x by least squares; nan if x does not vary."""
    a, b = np.log(x), np.log(y)
    if np.ptp(a) < 1e-12:
        return math.nan
    return float(np.polyfit(a, b, 1)[0])


def tabulate_knobs(
    members: Sequence[Member], costs: Sequence[float], errors: Sequence[float]
) -> Iterator[dict[str, Any]]:
    """A row for each knob and each set of members that differ in it alone, of at least three.

    `order`: error as a power of the knob's value; `slope`: error as a power of the cost along the knob (none of them
    where the knob has no numbers); `gain` and `price`: largest over smallest error and cost.
    """
    for knob in members[0].knobs if members else ():
        groups: dict[str, list[int]] = {}
        for n, member in enumerate(members):
            rest = str({key: value for key, value in member.knobs.items() if key != knob})
            if math.isfinite(errors[n]) and errors[n] > 0.0 and math.isfinite(costs[n]) and costs[n] > 0.0:
                groups.setdefault(rest, []).append(n)
        for rest, group in groups.items():
            values = {str(members[n].knobs[knob]) for n in group}
            if len(values) < 2:
                continue
            yield _describe(
                knob,
                rest,
                [members[n].knobs[knob] for n in group],
                [costs[n] for n in group],
                [errors[n] for n in group],
            )


def _describe(knob: str, rest: str, values: list[Any], costs: list[float], errors: list[float]) -> dict[str, Any]:
    coordinates = [find_coordinate(value) for value in values]
    numbers = [coordinate for coordinate in coordinates if coordinate is not None]
    fits = len(numbers) == len(values) >= _LEAST
    return {
        "knob": knob,
        "others": rest,
        "points": len(values),
        "order": fit_slope(numbers, errors) if fits else None,
        "slope": fit_slope(costs, errors) if fits else None,
        "gain": max(errors) / min(errors),
        "price": max(costs) / min(costs),
    }
