"""What a part of a case is, and how it is decided on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fbcouple.case.schema.sections import Case


@dataclass(frozen=True)
class Part:
    """A part of a case: is it in, and why."""

    name: str
    is_in: bool
    why: str


Decision = Callable[[Case], tuple[bool, str]]


def register(decisions: dict[str, Decision]) -> Callable[[Decision], Decision]:
    """A decorator that puts a decision into `decisions` under its own name, without the line before it."""

    def put(decide: Decision) -> Decision:
        decisions[decide.__name__.strip("_")] = decide
        return decide

    return put
