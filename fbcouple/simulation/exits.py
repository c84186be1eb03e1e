"""Where a particle is out: in a box of the region, or behind an opening in its walls."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from fbcouple.case.bed.outlets import find_open_faces, find_reach, find_thickness, is_opening, read_wall_mesh
from fbcouple.case.bed.streams import find_opening
from fbcouple.case.schema.feeds import Outlet
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.distance import find_distances
from fbcouple.geometry.grid import Grid
from fbcouple.geometry.plane_cover import Shape
from fbcouple.geometry.plate import measure_distances
from fbcouple.geometry.sides import SIDES, find_axes

if TYPE_CHECKING:
    from fbcouple.case.bed.region_lattice import Inside  # loads numba

Corners = tuple[np.ndarray, np.ndarray]


class Exit(Protocol):
    """Tells which particles are out."""

    def measure(self, positions: np.ndarray) -> np.ndarray:
        """How far [m] from this outlet each of `positions` (n, 3) came out, inf where it is not out by this one."""


@dataclass(frozen=True)
class Zone:
    """A box from `low` to `high` (3,) [m], infinite where it reaches the end of the region."""

    low: np.ndarray
    high: np.ndarray

    def measure(self, positions: np.ndarray) -> np.ndarray:
        """0 in the box."""
        inside = np.all((positions >= self.low) & (positions <= self.high), axis=1)
        return np.where(inside, 0.0, np.inf)


@dataclass(frozen=True)
class SideExit:
    """What lies behind a side of the box around the region, within `depth` [m] of the opening."""

    side: str
    level: float
    shape: Shape | None
    depth: float

    def measure(self, positions: np.ndarray) -> np.ndarray:
        """Distance from the opening along the side."""
        axis, end = SIDES[self.side]
        distances = np.full(len(positions), np.inf)
        behind = np.flatnonzero(positions[:, axis] > self.level if end else positions[:, axis] < self.level)
        if len(behind):
            across = positions[behind][:, find_axes(self.side)]
            distances[behind] = measure_distances(self.shape, across) if self.shape else 0.0
        return np.where(distances <= self.depth, distances, np.inf)


class PatchExit:
    """What lies outside of a mesh, within a depth of the patches that it left by."""

    def __init__(self, case: Case, outlet: Outlet, inside: Inside, run: Path) -> None:
        """The case's own files lie in `run`."""
        mesh = read_wall_mesh(case, run)
        self._inside, self._depth = inside, find_thickness(case, outlet)
        self._triangles = mesh.cut_faces(find_open_faces(case, [outlet], run))
        corners = self._triangles.reshape(-1, 3)
        self._low, self._high = corners.min(axis=0) - self._depth, corners.max(axis=0) + self._depth

    def measure(self, positions: np.ndarray) -> np.ndarray:
        """Distance from the patches."""
        distances = np.full(len(positions), np.inf)
        near = np.flatnonzero(np.all((positions >= self._low) & (positions <= self._high), axis=1))
        for row in near[~self._inside.holds(positions[near])]:
            point = np.broadcast_to(positions[row], (len(self._triangles), 3))
            distances[row] = find_distances(point, self._triangles).min()
        return np.where(distances <= self._depth, distances, np.inf)


def make_exits(case: Case, grid: Grid, run: Path, inside: Inside | None) -> list[Exit]:
    """The outlets of a case in their order; its own files lie in `run`, `grid` has the extent of the region, and
    `inside` tells what a mesh of polyhedra holds."""
    assert case.particles is not None
    low = np.array(grid.origin)
    return [_make_exit(case, outlet, (low, low + grid.size), inside, run) for outlet in case.particles.outlets]


def _make_exit(case: Case, outlet: Outlet, corners: Corners, inside: Inside | None, run: Path) -> Exit:
    low, high = corners
    if not is_opening(outlet):
        assert outlet.low is not None and outlet.high is not None
        bottom, top = np.array(outlet.low), np.array(outlet.high)
        return Zone(np.where(bottom <= low, -np.inf, bottom), np.where(top >= high, np.inf, top))
    if outlet.face is None:
        assert inside is not None
        return PatchExit(case, outlet, inside, run)
    axis, end = SIDES[outlet.face]
    level = float(high[axis] + find_reach(case) if end else low[axis] - find_reach(case))
    return SideExit(outlet.face, level, find_opening(outlet).shape, find_thickness(case, outlet))
