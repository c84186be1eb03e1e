"""Walls of LIGGGHTS that are opened to particles, stage by stage: what is taken away, and the surfaces in its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fbcouple.case.bed.outlets import find_open_faces, list_stages, read_wall_mesh
from fbcouple.case.bed.streams import find_opening
from fbcouple.case.schema.feeds import Outlet
from fbcouple.case.schema.gas import Domain
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.plane_cover import Shape
from fbcouple.geometry.plate import cut_plate
from fbcouple.geometry.sides import SIDES, find_axes
from fbcouple.geometry.stl import list_walls

_ENDS = "lo", "hi"


@dataclass(frozen=True)
class Opening:
    """What a stage does: ends the fixes `closed`, and makes one wall of `surfaces`, by name: LIGGGHTS has no more than
    one wall of surfaces.

    surfaces: name -> triangles (n, 3, 3) [m].
    """

    closed: list[str]
    surfaces: dict[str, np.ndarray]


def name_opening(number: int) -> str:
    """In a run folder: the deck of the stage `number`, counted from 1."""
    return f"DEM/open-{number}.liggghts"


def name_surface(name: str, number: int) -> str:
    """In a run folder: the file of a surface of the stage `number`."""
    return f"DEM/{name}-{number}.stl"


def list_openings(case: Case, folder: Path) -> list[Opening]:
    """The stages of a case whose own files lie in `folder`. Raises: CaseError as `find_open_faces`."""
    found: list[Opening] = []
    for stage in list_stages(case):
        if case.domain.shape == "box":
            found.append(_open_sides(case.domain, stage.outlets, found))
            continue
        walls = list_walls(read_wall_mesh(case, folder), find_open_faces(case, stage.outlets, folder))
        found.append(Opening(["walls", "surface"], {"surface": walls}))
    return found


def _open_sides(domain: Domain, outlets: Sequence[Outlet], before: Sequence[Opening]) -> Opening:
    """A stage of a box, after those `before`: its sides are planes until a plate with holes takes the place of one."""
    planes = {side: f"{'xyz'[axis]}{_ENDS[end]}" for side, (axis, end) in SIDES.items()}
    last = before[-1].surfaces if before else {}
    gone = {name for opening in before for name in opening.closed}
    opened = {side: [find_opening(one).shape for one in outlets if one.face == side] for side in SIDES}
    closed = [plane for side, plane in planes.items() if opened[side] and plane not in gone]
    surfaces = {}
    for side, shapes in opened.items():
        holes = [shape for shape in shapes if shape is not None]
        if holes and len(triangles := _cut_side(domain, side, holes)):
            surfaces[f"{planes[side]}Plate"] = triangles
    return Opening([*(["walls"] if last else []), *last, *closed], surfaces)


def _cut_side(domain: Domain, side: str, holes: Sequence[Shape]) -> np.ndarray:
    """Triangles (n, 3, 3) [m] of a side of a box around `holes`, anticlockwise from inside."""
    (axis, end), (one, other) = SIDES[side], find_axes(side)
    flat = cut_plate((domain.size[one], domain.size[other]), holes)
    triangles = np.full((*flat.shape[:2], 3), domain.size[axis] * end, dtype=float)
    triangles[..., [one, other]] = flat
    normal = np.cross(np.eye(3)[one], np.eye(3)[other])[axis]
    return triangles if (normal > 0.0) == (end == 0) else triangles[:, ::-1]
