"""Particles at the outlet: it is open to the gas alone, and they gather below it if the gas carries them there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.region import OUTLET, read_mesh
from fbcouple.geometry.distance import Surface
from fbcouple.simulation.simulation import Scene


class Outlet:
    """Counts the particles whose surface is within a radius of the outlet: those that it stopped, and their like."""

    def __init__(self, scene: Scene, run: Path) -> None:
        """The case's own files lie in `run` (collective)."""
        self._surface: Surface | None = None
        gas = scene.case.gas
        self._is_open = gas is not None and scene.grains is not None and gas.top == "open"
        if self._is_open and not scene.case.domain.is_plain_box:
            triangles = None
            if scene.comm.rank == 0:
                mesh = read_mesh(scene.case, run)
                triangles = mesh.cut_faces(mesh.list_patch(OUTLET))
            self._surface = Surface(scene.comm.bcast(triangles))

    def measure(self, scene: Scene) -> dict[str, Any]:
        """Number of particles at the outlet; nothing where there is none (collective)."""
        if not self._is_open:
            return {}
        assert scene.grains is not None
        reaches = 2.0 * np.asarray(scene.grains.radii)
        if self._surface:
            near = self._surface.is_near(scene.grains.positions, reaches)
        else:
            near = scene.grains.positions[:, 2] > scene.case.domain.size[2] - reaches
        return {"particles_at_outlet": int(scene.comm.allreduce(int(near.sum())))}
