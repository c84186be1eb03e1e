"""Outlets of particles: boxes in the region, and openings in its walls behind which a particle is out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fbcouple.case.bed.openings import find_outlet_faces
from fbcouple.case.bed.particle_types import largest_diameter
from fbcouple.case.bed.region import find_imported, read_mesh
from fbcouple.case.bed.streams import find_opening
from fbcouple.case.schema.feeds import Outlet
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.geometry.polymesh import PolyMesh

DEPTH = 8.0
"""How far there is room behind an opening where the case does not say it, in largest diameters."""
TRAVEL = 0.5
"""Part of the thinnest outlet that the fastest fall may cross in a coupling step."""


@dataclass(frozen=True)
class Opened:
    """From the time `start` [s] on the walls are open to particles at `outlets`."""

    start: float
    outlets: tuple[Outlet, ...]


def is_opening(outlet: Outlet) -> bool:
    """Does it lead through a wall?"""
    return outlet.face is not None or bool(outlet.patches)


def list_openings(case: Case) -> list[Outlet]:
    """The outlets that lead through a wall."""
    return [outlet for outlet in case.particles.outlets if is_opening(outlet)] if case.particles else []


def list_stages(case: Case) -> list[Opened]:
    """The walls as they are opened, one outlet or some after the other; before the first stage all are shut."""
    openings = list_openings(case)
    starts = sorted({outlet.start for outlet in openings})
    return [Opened(start, tuple(one for one in openings if one.start <= start)) for start in starts]


def find_depth(case: Case, outlet: Outlet) -> float:
    """How far [m] there is room behind an opening."""
    assert case.particles is not None
    return outlet.depth or DEPTH * largest_diameter(case.particles)


def find_reach(case: Case) -> float:
    """How far [m] behind an opening the centre of a particle is that is out: gas has no cells there; without gas all of
    the particle has to have passed, as it holds up others until then."""
    assert case.particles is not None
    return 0.0 if case.gas else 0.5 * largest_diameter(case.particles)


def find_thickness(case: Case, outlet: Outlet) -> float:
    """How far [m] a particle may move in a coupling step and cannot pass the outlet unseen."""
    if is_opening(outlet):
        return find_depth(case, outlet) - find_reach(case)
    assert outlet.low is not None and outlet.high is not None
    return min(top - bottom for bottom, top in zip(outlet.low, outlet.high, strict=True))


def find_longest_way(case: Case) -> float:
    """How far [m] the fastest particle may move in a coupling step, so that none passes an outlet unseen."""
    outlets = case.particles.outlets if case.particles else ()
    return min((TRAVEL * find_thickness(case, outlet) for outlet in outlets), default=math.inf)


def find_longest_step(case: Case) -> float:
    """Longest coupling step [s] in which no particle crosses an outlet that falls through the whole region, or comes
    as fast as one that is fed."""
    if case.particles is None or not case.particles.outlets:
        return math.inf
    fed = max((math.hypot(*feed.velocity) for feed in case.particles.feeds), default=0.0)
    speed = math.sqrt(fed**2 + 2.0 * case.gravity * case.domain.size[2])
    return find_longest_way(case) / speed if speed else math.inf


def read_wall_mesh(case: Case, folder: Path = Path()) -> PolyMesh:
    """The mesh whose outer faces are the walls, numbered as `find_open_faces` has it. Raises: CaseError as
    `read_mesh`."""
    if case.domain.shape != "file":
        return read_mesh(case, folder)
    return find_imported(case.domain, case.find_folder(folder, case.domain.mesh)).mesh


def find_open_faces(case: Case, outlets: Sequence[Outlet], folder: Path = Path()) -> np.ndarray:
    """Outer faces of the mesh of a region that is no box which `outlets` open.

    Raises: CaseError (one text) if one has none, or has faces of a baffle.
    """
    assert case.particles is not None
    mesh, found = read_wall_mesh(case, folder), None
    if case.domain.shape == "file":
        found = find_imported(case.domain, case.find_folder(folder, case.domain.mesh))
    faces = [find_outlet_faces(mesh, find_opening(outlet), found) for outlet in outlets]
    opened = np.unique(np.concatenate([np.empty(0, np.int64), *faces]))
    if found and (inner := int(np.isin(opened, found.baffles).sum())):
        text = f"{inner} faces are of baffles, walls inside of the mesh, behind which no particle is out"
        raise CaseError([f"{text}; give patches on the outside of the mesh, or a box (low and high) at the baffle."])
    return opened
