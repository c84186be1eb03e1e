"""The kinds of cases that `fbcouple init` can write: each is a function from what is wanted to the text of a file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Wanted:
    """What a new case shall have, in SI units; None: the kind chooses.

    diameter [m] and density [kg m-3] of the particles, inner size (3,) of the box [m], superficial velocity [m s-1],
    height [m] of the bed at rest.
    """

    diameter: float = 1e-3
    density: float = 2500.0
    size: tuple[float, float, float] | None = None
    velocity: float | None = None
    bed_height: float | None = None


Write = Callable[[Wanted], str]
KINDS: dict[str, Write] = {}
"""Kind -> what writes the text of its case file."""


def kind(name: str) -> Callable[[Write], Write]:
    """Register the function below as the kind `name`."""

    def register(write: Write) -> Write:
        KINDS[name] = write
        return write

    return register
