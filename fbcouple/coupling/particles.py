"""The particles of this rank, as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from fbcouple.errors import DivergedError


@dataclass(frozen=True)
class Particles:
    """This rank's particles as the solver shows them now: positions, velocities (n, 3), radii, masses (n,), the last
    with the gas that they carry along where a case has virtual mass: what a force has to move."""

    positions: np.ndarray
    velocities: np.ndarray
    radii: np.ndarray
    masses: np.ndarray
    last_velocities: np.ndarray | None = None
    """Velocities (n, 3) before the last move, where a force asks for them."""
    drag_only_velocities: np.ndarray | None = None
    """Velocities (n, 3) that drag alone would give in the move under way, writable, where the drag of a step knows the
    other forces."""


NOBODY = Particles(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty(0))


def report_outside(position: np.ndarray, why: str) -> NoReturn:
    """Raise DivergedError with the place (3,) [m] of a particle that is where none can be."""
    x, y, z = position
    text = f"a particle at ({x:.6g}, {y:.6g}, {z:.6g}) m is outside: {why}"
    raise DivergedError(f"{text}; it left the walls or moved too far in one fluid step; use a smaller step")
