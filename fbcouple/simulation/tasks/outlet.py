"""Particles at the outlet: it is open to the gas alone, and they gather below it if the gas carries them there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.region import OUTLET, has_own_mesh, read_mesh
from fbcouple.geometry.distance import Surface
from fbcouple.simulation.simulation import Simulation


class Outlet:
    """Counts the particles whose surface is within a radius of the outlet: those that it stopped, and their like."""

    def __init__(self, sim: Simulation, run: Path) -> None:
        """The case's own files lie in `run` (collective)."""
        self._surface: Surface | None = None
        gas = sim.case.gas
        self._is_open = gas is not None and sim.has_particles and gas.top == "open"
        if self._is_open and has_own_mesh(sim.case):
            triangles = None
            if sim.comm.rank == 0:
                mesh = read_mesh(sim.case, run)
                triangles = mesh.cut_faces(mesh.list_patch(OUTLET))
            self._surface = Surface(sim.comm.bcast(triangles))

    def measure(self, sim: Simulation) -> dict[str, Any]:
        """Number of particles at the outlet; nothing where there is none (collective)."""
        if not self._is_open:
            return {}
        reaches = 2.0 * np.asarray(sim.liggghts.radii)
        if self._surface:
            near = self._surface.is_near(sim.liggghts.positions, reaches)
        else:
            near = sim.liggghts.positions[:, 2] > sim.case.domain.size[2] - reaches
        return {"particles_at_outlet": int(sim.comm.allreduce(int(near.sum())))}
