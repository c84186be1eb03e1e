"""Particles that left the box: counted in every step, and named with where they were seen last."""

from __future__ import annotations

import numpy as np

from fbcouple.case.bed.particle_types import particle_count
from fbcouple.errors import DivergedError
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.soundness import format_point
from fbcouple.simulation.tasks.limits import require_finite

_MOST_NAMED = 5


class LostParticles:
    """Knows where every particle of this rank was when a row was last recorded, and misses those that are lost."""

    def __init__(self, sim: Simulation) -> None:
        bed = sim.case.particles
        self._particles = particle_count(bed) if bed else 0
        if sim.has_particles:
            # LIGGGHTS would end the process with their number alone; they are counted here in every step.
            sim.liggghts.command("thermo_modify lost ignore")
        self._numbers, self._places, self._time = np.empty(0, int), np.empty((0, 3)), 0.0

    def take(self, sim: Simulation) -> None:
        """Remember where they are."""
        self._numbers, self._places = sim.liggghts.numbers.copy(), sim.liggghts.positions.copy()
        self._time = sim.time

    def require_all(self, sim: Simulation) -> None:
        """Raise DivergedError if some are lost, with the first of them and where they were (collective)."""
        expected = sim.traffic.ledger.count if sim.traffic else self._particles
        if not sim.has_particles or sim.conservation.particles == expected:
            return
        require_finite(sim)
        there = np.concatenate(sim.comm.allgather(sim.liggghts.numbers.copy()))
        seen = dict(zip(self._numbers.tolist(), self._places.tolist(), strict=True))
        everybody: dict[int, list[float]] = {}
        for part in sim.comm.allgather(seen):
            everybody |= part
        missing = np.setdiff1d(self._list_expected(sim), there).tolist()
        named = [
            f"{n}, last seen at {format_point(everybody[n])} at t = {self._time:.6g} s" if n in everybody else str(n)
            for n in missing[:_MOST_NAMED]
        ]
        lost = expected - sim.conservation.particles
        what = "parcels" if sim.case.particles and sim.case.particles.coarse_graining else "particles"
        raise DivergedError(
            f"at t = {sim.time:.6g} s {lost} of {expected} {what} are lost, they left the box: "
            f"particle {'; particle '.join(named)}; use more DEM steps per contact or a stiffer contact"
        )

    def _list_expected(self, sim: Simulation) -> np.ndarray:
        """Numbers of the particles that there have to be."""
        if not sim.traffic:
            return np.arange(1, self._particles + 1)
        ledger = sim.traffic.ledger
        return np.setdiff1d(np.arange(1, ledger.start.count + ledger.fed.count + 1), sim.traffic.exits[:, 0])
