"""A pre-flight number: a value, what is wanted of it, and whether it is fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

Verdict = Literal["fit", "warn", "unfit"]
Law = Callable[..., Any]
"""A drag law: beta [kg/s] of voidage, slip, diameter, gas density and viscosity."""


@dataclass(frozen=True)
class Number:
    """One pre-flight number; `limit` says what is wanted, `verdict` is None where nothing is."""

    name: str
    value: float
    unit: str
    limit: str | None
    verdict: Verdict | None
    meaning: str

    def format_value(self) -> str:
        """The value in four digits, a count in all."""
        return f"{self.value:.4g}" if isinstance(self.value, float) else str(self.value)

    def format(self) -> str:
        """The value with its unit, where it has one."""
        return self.format_value() if self.unit == "1" else f"{self.format_value()} {self.unit}"


def judge(fits: bool, otherwise: Verdict = "warn") -> Verdict:
    """The verdict "fit", or `otherwise`."""
    return "fit" if fits else otherwise
