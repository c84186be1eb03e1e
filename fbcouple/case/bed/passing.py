"""Particles that are about to leave a region by an opening when a run starts, as a bed that empties always has some."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fbcouple.case.bed.derived import wraps
from fbcouple.case.bed.outlets import find_open_faces, list_openings, read_wall_mesh
from fbcouple.case.bed.region import read_mesh
from fbcouple.case.bed.streams import find_opening
from fbcouple.case.schema.feeds import Outlet
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.distance import Surface
from fbcouple.geometry.sides import SIDES, find_axes


def find_in_openings(
    case: Case, folder: Path, positions: np.ndarray, margins: np.ndarray, latest: float = 0.0
) -> np.ndarray:
    """Which of `positions` (n, 3) [m] are inside of the region and come nearer than their `margins` (n,) [m] to
    openings that are there at the time `latest` [s], and not to the walls that are left; shape (n,)."""
    opened = [outlet for outlet in list_openings(case) if outlet.start <= latest]
    if not opened or not len(positions):
        return np.zeros(len(positions), bool)
    if case.domain.shape == "box":
        return np.any([_pass_side(case, outlet, positions, margins) for outlet in opened], axis=0)
    from fbcouple.case.bed.region_lattice import Inside  # noqa: PLC0415  (loads numba)

    mesh = read_wall_mesh(case, folder)
    outer = np.arange(len(mesh.neighbour), len(mesh.owner))
    walls = Surface(mesh.cut_faces(np.setdiff1d(outer, find_open_faces(case, opened, folder))))
    return Inside(read_mesh(case, folder)).holds(positions) & ~walls.is_near(positions, margins)


def _pass_side(case: Case, outlet: Outlet, positions: np.ndarray, margins: np.ndarray) -> np.ndarray:
    """Which of `positions` are over an outlet in a side of the box, clear of its other sides."""
    assert outlet.face is not None
    across, end = SIDES[outlet.face]
    walls = np.where(wraps(case.domain), 0.0, margins[:, None])
    low, high = walls, np.array(case.domain.size) - walls
    (high if end else low)[:, across] = case.domain.size[across] if end else 0.0
    shape, along = find_opening(outlet).shape, list(find_axes(outlet.face))
    clear = np.all((positions >= low) & (positions <= high), axis=1)
    return clear & shape.has(positions[:, along]) if shape else clear
