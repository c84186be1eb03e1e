"""Drag, or heat transfer, against its own direction: what a law says beyond the range that it was made for."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fbcouple.physics.jit import inlined

NONE = (0.0, -1, 0.0, 0.0, 0.0)
"""What `find_lowest` begins with: the value, the particle, and what its law was given."""
ROUNDING = 1e-10
"""Part of a particle's drag in creeping flow below which a negative one is rounding: Ergun's ends at voidage 1."""


@inlined
def find_lowest(first, eps, speed, size, values, lowest):
    """`lowest`, or of a block of particles from `first` on the lowest of `values` (n,) if that is below it: value,
    number of the particle, and its `eps`, `speed` and `size` (n,)."""
    least = 0.0
    for q in range(len(values)):
        least = min(least, values[q])
    if least < lowest[0]:
        for q in range(len(values)):
            if values[q] == least:
                lowest = (least, first + q, eps[q], speed[q], size[q])
    return lowest


@dataclass(frozen=True)
class Negative:
    """A particle whose law gave a coefficient below 0 in a step, the worst of this rank."""

    what: str
    """The coefficient with its value, in words."""
    option: str
    """Where the case names the law."""
    law: str
    position: np.ndarray
    """(3,) [m]."""
    voidage: float
    reynolds: float
    slip: float = math.nan
    """[m/s], where the law goes by it."""

    def describe(self) -> str:
        """What is wrong, without the place."""
        speed = "" if math.isnan(self.slip) else f"slip {self.slip:.4g} m/s, "
        where = f"{speed}Re {self.reynolds:.4g}, voidage {self.voidage:.4g}"
        return f"`{self.law}` gives {self.what} at {where}, which is beyond what it was made for ({self.option})"
