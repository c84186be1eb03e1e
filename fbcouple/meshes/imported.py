"""Meshes of other programs: gmsh's files, by meshio, and patches in the order that a run wants."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.meshes.numbering import NONE, SHAPES, build_mesh
from fbcouple.meshes.polymesh import PolyMesh

_SIDES = {"triangle": 3, "quad": 4}
_FLAT = ("vertex", "line")
WALLS = "walls"


def read_mesh_file(path: Path) -> PolyMesh:
    """Read a gmsh file: tetrahedra, pyramids, wedges and hexahedra; its physical surfaces are the patches.

    Outer faces of no physical surface are in the patch "walls".
    Raises: CaseError (one text) if it is no such file.
    """
    import meshio  # noqa: PLC0415  (only for a case that brings such a file)

    try:
        found = meshio.gmsh.read(path)
    except Exception as error:  # whatever the reader meets in the user's file is the user's to read
        text = f"{path.name} cannot be read as a gmsh mesh ({type(error).__name__}: {str(error)[:120]})"
        raise CaseError([f"{text}; write it with `gmsh -3 -format msh41`, or give a polyMesh folder."]) from error
    blocks = [(block.type, block.data.astype(np.int64)) for block in found.cells]
    foreign = sorted({kind for kind, _ in blocks if kind not in (*SHAPES, *_SIDES, *_FLAT)})
    shapes = [(kind, corners) for kind, corners in blocks if kind in SHAPES]
    if foreign or not shapes:
        text = f"it has {', '.join(foreign)}" if foreign else "it has no cells"
        raise CaseError([f"{path.name}: {text}; allowed are linear {', '.join(SHAPES)}."])
    used = np.unique(np.concatenate([corners.ravel() for _, corners in shapes]))
    number = np.full(len(found.points), NONE, np.int64)
    number[used] = np.arange(len(used))
    names, keys, patches = _list_sides(found, blocks, number)

    def name(rows: np.ndarray) -> np.ndarray:
        both = np.concatenate([keys, np.sort(rows, axis=1)])
        _, which = np.unique(both, axis=0, return_inverse=True)
        patch = np.full(int(which.max()) + 1, len(names))
        patch[which.ravel()[: len(keys)]] = patches
        return patch[which.ravel()[len(keys) :]]

    points = np.asarray(found.points[used], dtype=float)
    return build_mesh(points, [(kind, number[corners]) for kind, corners in shapes], [*names, WALLS], name)


def _list_sides(
    found: Any, blocks: list[tuple[str, np.ndarray]], number: np.ndarray
) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Names of physical surfaces, their faces as sorted rows of four points, and the name of each face."""
    tags = {int(tag): str(name) for name, (tag, dimension) in found.field_data.items() if dimension == 2}
    names = list(tags.values())
    data = found.cell_data.get("gmsh:physical", [np.zeros(len(corners), int) for _, corners in blocks])
    rows, patches = [np.empty((0, 4), np.int64)], [np.empty(0, np.int64)]
    for (kind, corners), physical in zip(blocks, data, strict=True):
        if kind in _SIDES:
            known = np.isin(physical, list(tags))
            row = np.full((int(known.sum()), 4), NONE, np.int64)
            row[:, : _SIDES[kind]] = number[corners[known]]
            rows.append(np.sort(row, axis=1))
            patches.append(np.array([names.index(tags[int(tag)]) for tag in np.asarray(physical)[known]], np.int64))
    return names, np.concatenate(rows), np.concatenate(patches)


def arrange_patches(mesh: PolyMesh, inlet: str, outlet: str) -> PolyMesh:
    """The mesh with three patches: `inlet` and `outlet` under the names inlet and outlet, and all others as walls."""
    inner = len(mesh.neighbour)
    first, second = mesh.list_patch(inlet), mesh.list_patch(outlet)
    rest = np.setdiff1d(np.arange(inner, len(mesh.owner)), np.concatenate([first, second]))
    order = np.concatenate([np.arange(inner), first, second, rest])
    starts = np.cumsum([inner, len(first), len(second)]).tolist()
    patches = dict(
        zip(("inlet", "outlet", WALLS), zip(starts, map(len, (first, second, rest)), strict=True), strict=True)
    )
    return replace(mesh, faces=mesh.faces.take(order), owner=mesh.owner[order], patches=patches)
