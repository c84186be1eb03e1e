"""The registries of figures: function name = registry key = file name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from matplotlib.figure import Figure

from fbcouple.results.reader import Results

Draw = Callable[[Results], Figure]
Compare = Callable[[Sequence[Results]], Figure]
AnyCompare = TypeVar("AnyCompare", bound=Compare)
"""The same, with what it may be given beside."""

FIGURES: dict[str, Draw] = {}
"""Figures of one run."""
COMPARISONS: dict[str, Compare] = {}
"""Figures of several runs side by side."""


def figure(function: Draw) -> Draw:
    """Register `function(results) -> Figure` under its own name; RUN/figures/NAME.png is what it draws."""
    FIGURES[function.__name__] = function
    return function


def comparison(function: AnyCompare) -> AnyCompare:
    """Register `function(runs) -> Figure` under its own name; the report of several runs shows what it draws."""
    COMPARISONS[function.__name__] = function
    return function
