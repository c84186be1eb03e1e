"""What a pre-flight number is: a value, what is wanted of it, and whether it is met."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["fit", "warn", "unfit"]


@dataclass(frozen=True)
class Number:
    """One pre-flight number; `limit` says what is wanted, `verdict` is None where nothing is."""

    name: str
    value: float
    unit: str
    limit: str | None
    verdict: Verdict | None
    meaning: str
