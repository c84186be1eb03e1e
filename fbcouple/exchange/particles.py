"""The particles of this rank, as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Particles:
    """This rank's particles as the solver shows them now: positions, velocities (n, 3), radii, masses (n,)."""

    positions: np.ndarray
    velocities: np.ndarray
    radii: np.ndarray
    masses: np.ndarray
    last_velocities: np.ndarray | None = None
    """Velocities (n, 3) before the last move, where a force asks for them."""


NOBODY = Particles(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty(0))
