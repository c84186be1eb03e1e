"""How fast the gas flows in, by the case: the velocity that figures and tables put others in proportion to."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

Row = tuple[float, float]


def list_rows(gas: Mapping[str, Any]) -> list[Row]:
    """Rows (time [s], velocity [m/s]) of the inflow, of several inlets together; one if it is constant. Up is above
    zero."""
    parts = _list_parts(gas)
    return sum_rows(parts) if gas.get("inlets") else parts[0][1]


def _list_parts(gas: Mapping[str, Any]) -> list[tuple[float, list[Row]]]:
    """Of each inlet its part of the whole inlet's area, and its rows."""
    if inlets := gas.get("inlets"):
        section = float(gas["inlet_section"])
        return [(float(inlet["area"]) / section, _list_own(inlet, "velocity", "ramp")) for inlet in inlets]
    return [(1.0, _list_own(gas, "inlet_velocity", "inlet_ramp"))]


def weigh_inlets(gas: Mapping[str, Any], heat: Mapping[str, Any] | None) -> Mapping[str, Any]:
    """The gas of a case with `heat`, the areas of its inlets times the density of theirs over that of the case, which
    differ in an ideal gas alone: what passes them is then a mass over the density of the case."""
    if not heat or heat.get("gas_density") != "ideal" or not gas.get("inlets"):
        return gas
    start = float(heat["gas_temperature"])
    ratios = [start / float(inlet.get("temperature") or start) for inlet in gas["inlets"]]
    inlets = [
        {**inlet, "area": float(inlet["area"]) * ratio} for inlet, ratio in zip(gas["inlets"], ratios, strict=True)
    ]
    return {**gas, "inlets": inlets}


def is_constant(gas: Mapping[str, Any]) -> bool:
    """Does the inflow have one velocity from the start to the end?"""
    return len(list_rows(gas)) == 1 and gas.get("inlet_ramp") is None


def _list_own(table: Mapping[str, Any], velocity: str, ramp: str) -> list[Row]:
    if table.get(velocity) is not None:
        return [(0.0, float(table[velocity]))]
    return [(float(time), float(value)) for time, value in table[ramp]]


def sum_rows(parts: Sequence[tuple[float, Sequence[Row]]]) -> list[Row]:
    """Rows of the sum of several inflows, each a factor and its rows; a jump of one is a jump of the sum."""
    times = sorted({time for _, rows in parts for time, _ in rows})
    if all(len(rows) == 1 for _, rows in parts):
        return [(0.0, sum(factor * rows[0][1] for factor, rows in parts))]
    sums: list[Row] = []
    for time in times:
        before = sum(factor * find_before(rows, time) for factor, rows in parts)
        after = sum(factor * find_after(rows, time) for factor, rows in parts)
        sums += [(time, before)] if before == after else [(time, before), (time, after)]
    return sums


def find_fastest(gas: Mapping[str, Any], start: float, end: float) -> float:
    """Largest speed [m/s] of what passes the inlet, in or out, from `start` to `end` [s]; 0 if nothing does."""
    return find_busiest(_list_parts(gas), start, end)


def find_mean(gas: Mapping[str, Any], start: float, end: float) -> float:
    """Time mean [m/s] of the inflow from `start` to `end` [s], above zero if more comes in than goes out."""
    rows = _cut(list_rows(gas), start, end)
    if end <= start:
        return rows[-1][1]
    area = sum(0.5 * (before[1] + after[1]) * (after[0] - before[0]) for before, after in pairwise(rows))
    return area / (end - start)


def _cut(rows: list[Row], start: float, end: float) -> list[Row]:
    """The rows between `start` and `end`, with one at each of these two: of a jump there only the side within."""
    inner = [row for row in rows if start < row[0] < end]
    return [(start, find_after(rows, start)), *inner, (end, find_before(rows, end))]


def find_after(rows: Sequence[Row], time: float) -> float:
    """Velocity at `time`, of a jump there the later one; before the first row its own, after the last its own."""
    index = bisect_right(rows, time, key=lambda row: row[0])
    return rows[-1][1] if index == len(rows) else _interpolate(rows, max(index, 1), time)


def find_before(rows: Sequence[Row], time: float) -> float:
    """Velocity at `time`, of a jump there the earlier one."""
    index = bisect_left(rows, time, key=lambda row: row[0])
    return rows[-1][1] if index == len(rows) else _interpolate(rows, max(index, 1), time)


def _interpolate(rows: Sequence[Row], index: int, time: float) -> float:
    """Velocity at `time` between the rows `index` - 1 and `index`; before them that of the former."""
    (early, slow), (late, fast) = rows[index - 1], rows[min(index, len(rows) - 1)]
    part = (time - early) / (late - early) if late > early else 0.0
    return fast if part >= 1.0 else slow + max(part, 0.0) * (fast - slow)


def add_speeds(
    parts: Sequence[tuple[float, Sequence[Row]]],
    time: float,
    find: Callable[[Sequence[Row], float], float] = find_after,
) -> float:
    """Sum of the speeds [m/s] of several inflows, each a factor and its rows, at `time` [s]."""
    return sum(factor * abs(find(rows, time)) for factor, rows in parts)


def find_busiest(
    parts: Sequence[tuple[float, Sequence[Row]]], start: float = -math.inf, end: float = math.inf
) -> float:
    """Largest sum of the speeds [m/s] of several inflows, each a factor and its rows, from `start` to `end` [s]: what
    goes out by one does not make up for what comes in by another."""
    inner = {time for _, rows in parts for time, _ in rows if start < time < end}
    sums = [add_speeds(parts, time) for time in (start, *inner)]
    return max(sums + [add_speeds(parts, time, find_before) for time in (*inner, end)])
