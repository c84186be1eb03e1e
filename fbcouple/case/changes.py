"""What a case says, option by option, kept beside a run, and what has become of it since."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from fbcouple.case.problems import show
from fbcouple.case.schema.reference import list_defaults
from fbcouple.case.schema.sections import Case
from fbcouple.results.inlet_speed import Row, find_after, find_before

FREE = ("end_time", "output.save_every", "output.profile_heights", "output.radial_heights")
FREE_SECTIONS = ("monitors", "checkpoint")
"""What may be changed in a run folder at any time: what ends a run, what stops it, how often files are saved, and
what figures show."""

INLET = ("gas.inlet_velocity", "gas.inlet_ramp", "gas.inlets")
"""What may be another from a checkpoint on, recorded: how fast the gas comes in, and not where."""
_VELOCITIES = ("velocity", "ramp", "ramp_file")
_SAME = 1e-9

Values = dict[str, Any]
"""Option, by its dotted key -> value, as JSON has it."""


@dataclass(frozen=True)
class Change:
    """An option of another value than before."""

    key: str
    before: Any
    now: Any

    def __str__(self) -> str:
        parts = list(self._list_parts())
        return ", ".join(f"{key} was {_word(before)} and is {_word(now)} now" for key, before, now in parts)

    def _list_parts(self) -> Iterator[tuple[str, Any, Any]]:
        """Of as many tables as before what is another in each, counted from 1; else the option as a whole."""
        if not (_are_tables(self.before) and _are_tables(self.now) and len(self.before) == len(self.now)):
            yield self.key, self.before, self.now
            return
        for number, (before, now) in enumerate(zip(self.before, self.now, strict=True), start=1):
            for name in before | now:
                if before.get(name) != now.get(name):
                    yield f"{self.key}.{number}.{name}", before.get(name), now.get(name)


def _are_tables(value: Any) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(one, dict) for one in value)


def list_values(case: Case) -> Values:
    """Every option of `case` that matters to what a run computes; a section that is there is true."""
    values: Values = {}
    for name, value in case.model_dump(mode="json").items():
        if isinstance(value, dict):
            values |= {name: True} | {f"{name}.{key}": given for key, given in value.items()}
        else:
            values[name] = value
    return {key: value for key, value in values.items() if not is_free(key)}


def list_changes(before: Values, case: Case, until: float | None = None) -> list[Change]:
    """Options whose value in `case` is not the one in `before`; one that is younger than `before` had its default.

    until [s]: velocities of the inlet count up to then only.
    """
    now = list_values(case)
    defaults = list_defaults()
    known = sorted({*before, *(key for key in now if key in defaults)})
    changes = [Change(key, before.get(key, defaults.get(key)), now.get(key)) for key in known]
    changes = [change for change in changes if _drop_absent(change.before) != _drop_absent(change.now)]
    if until is not None and _is_same_inflow(before, now, until):
        changes = [change for change in changes if change.key not in INLET]
    return changes


def _drop_absent(value: Any) -> Any:
    """A value as JSON has it, its tables without what is not given in them: an option that is younger is not."""
    if isinstance(value, list):
        return [_drop_absent(entry) for entry in value]
    if isinstance(value, dict):
        return {key: _drop_absent(entry) for key, entry in value.items() if entry is not None}
    return value


def is_free(key: str) -> bool:
    """May this option be changed in a run folder at any time?"""
    return key in FREE or key.partition(".")[0] in FREE_SECTIONS


def list_inflows(values: Values) -> list[tuple[Values, list[Row]]]:
    """Of each inlet what a case says of it beside its velocity, and its rows of time [s] and velocity [m/s]."""
    if tables := values.get("gas.inlets"):
        return [(_keep_opening(table), _list_rows(table.get("velocity"), table.get("ramp"))) for table in tables]
    return [({}, _list_rows(values.get("gas.inlet_velocity"), values.get("gas.inlet_ramp")))]


def _keep_opening(table: Values) -> Values:
    return {key: value for key, value in table.items() if key not in _VELOCITIES and value is not None}


def _list_rows(velocity: float | None, ramp: list[list[float]] | None) -> list[Row]:
    return [(time, speed) for time, speed in ramp] if ramp else [(0.0, velocity or 0.0)]


def _is_same_inflow(before: Values, now: Values, until: float) -> bool:
    """Does gas come in by the same inlets, as fast up to `until` [s]?"""
    try:
        one, other = list_inflows(before), list_inflows(now)
        return [opening for opening, _ in one] == [opening for opening, _ in other] and all(
            is_same_ramp(rows, others, end=until) for (_, rows), (_, others) in zip(one, other, strict=True)
        )
    except (AttributeError, TypeError, ValueError):  # an index of a checkpoint may come from anybody
        return False


def is_same_ramp(one: list[Row], other: list[Row], start: float = -math.inf, end: float = math.inf) -> bool:
    """Does gas come in as fast by `one` as by `other` from `start` to `end` [s]?"""
    room = _SAME * max(abs(speed) for _, speed in [*one, *other])
    times = [time for time, _ in [*one, *other] if start < time < end]
    pairs = [(find(one, time), find(other, time)) for time in times for find in (find_before, find_after)]
    if start > -math.inf:
        pairs.append((find_after(one, start), find_after(other, start)))
    if end < math.inf:
        pairs.append((find_before(one, end), find_before(other, end)))
    return all(abs(a - b) <= room for a, b in pairs)


def _word(value: Any) -> str:
    return "not given" if value is None else show(value)
