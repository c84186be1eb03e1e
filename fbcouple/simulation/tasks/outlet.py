"""Particles at the outlet, where it is open to the gas alone: they gather there if the gas carries them to it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.outlets import find_open_faces, list_openings, read_wall_mesh
from fbcouple.case.bed.region import has_own_mesh, read_mesh
from fbcouple.case.bed.streams import find_opening
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.distance import Surface
from fbcouple.geometry.imported import list_outlets
from fbcouple.geometry.sides import SIDES, find_axes
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.diagnostics import as_grains

_NEAR = 1e-9


class Outlet:
    """Counts the particles whose surface is within a radius of the outlet: those that it stopped, and their like."""

    def __init__(self, sim: Simulation, run: Path) -> None:
        """The case's own files lie in `run` (collective)."""
        self._surface: Surface | None = None
        gas = sim.case.gas
        self._is_open = gas is not None and sim.has_particles and gas.top == "open"
        if self._is_open and has_own_mesh(sim.case):
            triangles = sim.comm.bcast(_cut_outlet(sim.case, run) if sim.comm.rank == 0 else None)
            self._surface, self._is_open = Surface(triangles) if len(triangles) else None, bool(len(triangles))
        elif any(outlet.face == "top" for outlet in list_openings(sim.case)):
            self._is_open = False

    def measure(self, sim: Simulation) -> dict[str, Any]:
        """Number of particles at the outlet; nothing where there is none (collective)."""
        if not self._is_open:
            return {}
        reaches = 2.0 * np.asarray(sim.liggghts.radii)
        if self._surface:
            near = self._surface.is_near(sim.liggghts.positions, reaches)
        else:
            near = sim.liggghts.positions[:, 2] > sim.case.domain.size[2] - reaches
        return {"particles_at_outlet": as_grains(sim, int(sim.comm.allreduce(int(near.sum()))))}


def _cut_outlet(case: Case, run: Path) -> np.ndarray:
    """Triangles (n, 3, 3) [m] of the outlet of the gas that are wall to the particles."""
    mesh = read_mesh(case, run)
    triangles = mesh.cut_faces(np.concatenate([mesh.list_patch(name) for name in list_outlets(mesh)]))
    middles = triangles.mean(axis=1)
    if case.domain.shape == "box":
        return triangles[~_lie_in_openings(case, middles)]
    opened = read_wall_mesh(case, run).cut_faces(find_open_faces(case, list_openings(case), run)).mean(axis=1)
    known = set(map(tuple, opened.tolist()))
    return triangles[[tuple(middle) not in known for middle in middles.tolist()]]


def _lie_in_openings(case: Case, points: np.ndarray) -> np.ndarray:
    """Which of `points` (n, 3) on the sides of a box particles leave by."""
    there = np.zeros(len(points), bool)
    for outlet in list_openings(case):
        side, shape = outlet.face or "floor", find_opening(outlet).shape
        axis, end = SIDES[side]
        near = np.abs(points[:, axis] - case.domain.size[axis] * end) <= _NEAR * case.domain.size[axis]
        there |= near & (shape.has(points[:, find_axes(side)]) if shape else True)
    return there
