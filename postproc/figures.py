"""The registry of figures: function name = registry key = file name."""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.figure import Figure

from postproc.dataset import Results

Draw = Callable[[Results], Figure]

FIGURES: dict[str, Draw] = {}


def figure(function: Draw) -> Draw:
    """Register `function(results) -> Figure` under its own name; RUN/figures/NAME.png is what it draws."""
    FIGURES[function.__name__] = function
    return function
