"""Per-step check over all ranks: what the gas gave up arrived at the particles, and no particle is lost."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from mpi4py import MPI

from fbcouple.coupling.kernels import sum_up

_SUSPECT = 1e-11
_NEGLIGIBLE = 1e-4
"""Part of the particles' momentum below which an impulse is not compared with: where particles go with the gas, their
drag dies away and what is left of it is the rounding of beta u - beta v."""


class Conservation:
    """Compares the impulse that the gas lost in a step with what the particles carried through it."""

    def __init__(self, comm: MPI.Comm) -> None:
        self._comm = comm
        self._given, self._scale, self._totals = np.zeros(3), 0.0, np.zeros(6)
        self.momentum_error = 0.0
        """Imbalance of the last step over its impulse: the sum of the drag's magnitudes or, in a liquid, what buoyancy
        makes of the whole; no less than 1e-4 of the particles' momentum."""
        self.particles = 0
        self.support = 0.0
        """Upward force [N] of the gas on all particles in the last step."""

    def give(self, loss: np.ndarray, drag: float, dt: float) -> None:
        """The gas of this rank lost the force `loss` (3,) [N] over `dt` [s]; magnitudes of drag and extra forces
        add up to `drag`."""
        self._given, self._scale = loss * dt, max(drag, float(np.linalg.norm(loss))) * dt

    def receive(
        self,
        forces: np.ndarray,
        dt: float,
        find_momentum: Callable[[], float] = lambda: 0.0,
        weight: float = 0.0,
        carried: float = 0.0,
    ) -> None:
        """The particles of this rank were under the forces `forces` (n, 3) [N] for `dt` [s], that of the gas and their
        `weight` [N] if it was held; the sum of their m |v| [kg m/s] is asked for only where the imbalance looks large
        (collective).

        carried [N]: weight of the gas that they carry along, which the forces hold, and which is no support of theirs.
        """
        totals, given = self._totals, self._given
        x, y, z = sum_up(forces)
        z += weight
        totals[:] = given[0] - x * dt, given[1] - y * dt, given[2] - z * dt, self._scale, len(forces), z - carried
        self._comm.Allreduce(MPI.IN_PLACE, totals)
        _, _, _, scale, count, self.support = totals.tolist()
        self.particles = round(count)
        imbalance = float(np.abs(totals[:3]).max())
        self.momentum_error = imbalance / scale if scale > 0 else imbalance
        if self.momentum_error > _SUSPECT:
            momentum = self._comm.allreduce(find_momentum())
            self.momentum_error = imbalance / (max(scale, _NEGLIGIBLE * momentum) or 1.0)

    def count(self, particles: int) -> None:
        """Count the particles of all ranks, for a case without gas (collective)."""
        self.particles = self._comm.allreduce(particles)
