"""Meshes of other programs: gmsh's files, polyMesh folders, and the patches that a run wants of them."""

from __future__ import annotations

import fnmatch
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.geometry.foam_files import read_polymesh
from fbcouple.geometry.foreign import refuse_foreign_format
from fbcouple.geometry.gmsh_file import ELEMENTS, Block, GmshFile, read_gmsh_file
from fbcouple.geometry.numbering import NONE, SHAPES, build_mesh
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.ragged import Ragged

INLET, OUTLET, WALLS = "inlet", "outlet", "walls"
_FLAT = ("triangle", "quad")


@dataclass(frozen=True, eq=False)
class ImportedMesh:
    """A mesh and the surfaces that its file names; one face may be in several of them.

    surfaces: name -> outer faces; inner: how many faces of a surface lie between two cells; loose: how many are on no
    cell; others: names of groups that are no surfaces; baffles: pairs (n, 2) of outer faces back to back.
    """

    mesh: PolyMesh
    surfaces: dict[str, np.ndarray]
    inner: dict[str, int] = field(default_factory=dict)
    loose: dict[str, int] = field(default_factory=dict)
    others: tuple[str, ...] = ()
    baffles: np.ndarray = field(default_factory=lambda: np.empty((0, 2), np.int64))


def read_mesh(path: Path) -> ImportedMesh:
    """Read a polyMesh folder or a gmsh file. Raises: CaseError (one text) if it cannot be read."""
    if not path.is_dir():
        return read_mesh_file(path)
    mesh = read_polymesh(path)
    return ImportedMesh(mesh, {name: mesh.list_patch(name) for name in mesh.patches})


def read_mesh_file(path: Path) -> ImportedMesh:
    """Read a gmsh file: tetrahedra, pyramids, wedges and hexahedra; its physical surfaces are the surfaces.

    A physical surface without a name has its number as one. Outer faces of no physical surface are in the surface
    "walls", unless the file names one so.
    Raises: CaseError (one text) if it is no such file.
    """
    refuse_foreign_format(path)
    found = read_gmsh_file(path)
    shapes = [(block.kind, block.corners) for block in found.blocks if block.kind in SHAPES]
    if not any(len(corners) for _, corners in shapes):
        text = "it has surfaces and no cells" if found.blocks else "it has no elements"
        mend = "mesh in 3D, and put the volume into a physical group, too (gmsh saves only what is in one)"
        raise CaseError([f'{text}; {mend}: `Physical Volume("bed") = {{:}};`.'])
    shapes = _drop_repeated(shapes) if found.repeats else shapes
    used = np.unique(np.concatenate([corners.ravel() for _, corners in shapes]))
    number = np.empty(len(found.points), np.int64)  # of the points of cells first, then of those that are on none
    number[np.append(used, np.setdiff1d(np.arange(len(number)), used))] = np.arange(len(number))
    cells = [(kind, number[corners]) for kind, corners in shapes]
    mesh = build_mesh(np.array(found.points[used]), cells, [WALLS], lambda rows: np.zeros(len(rows), np.int64))
    return _find_surfaces(mesh, _list_sides(found, number), _list_others(found))


def _drop_repeated(shapes: Sequence[tuple[str, np.ndarray]]) -> list[tuple[str, np.ndarray]]:
    """Each cell once: format 2 repeats it for each of its groups."""
    kept = []
    for kind in dict.fromkeys(kind for kind, _ in shapes):
        corners = np.concatenate([rows for word, rows in shapes if word == kind])
        _, first = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
        kept.append((kind, corners[np.sort(first)]))
    return kept


def _list_sides(found: GmshFile, number: np.ndarray) -> dict[str, np.ndarray]:
    """Faces of each physical surface as sorted rows of four points, each face once."""
    sides: dict[str, list[np.ndarray]] = {name: [] for (dimension, _), name in found.names.items() if dimension == 2}
    for block in found.blocks:
        if block.kind in _FLAT:
            rows = np.full((len(block.corners), 4), NONE, np.int64)
            rows[:, : block.corners.shape[1]] = number[block.corners]
            for tag in block.groups:
                sides.setdefault(found.names.get((2, tag), str(tag)), []).append(np.sort(rows, axis=1))
    none = np.empty((0, 4), np.int64)
    return {name: np.unique(np.concatenate([none, *rows]), axis=0) for name, rows in sides.items()}


def _list_others(found: GmshFile) -> tuple[str, ...]:
    """Names, or numbers, of the groups of points, curves and volumes."""

    def list_groups(block: Block) -> list[str]:
        dimension = next(of for kind, of, _ in ELEMENTS.values() if kind == block.kind)
        return [found.names.get((dimension, tag), str(tag)) for tag in block.groups if dimension != 2]

    named = [name for (dimension, _), name in found.names.items() if dimension != 2]
    return tuple(dict.fromkeys([*named, *(name for block in found.blocks for name in list_groups(block))]))


def _find_surfaces(mesh: PolyMesh, sides: dict[str, np.ndarray], others: tuple[str, ...]) -> ImportedMesh:
    """Find the faces of `mesh` that the `sides` (rows of four points, sorted) are."""
    names = list(sides)
    rows = np.concatenate([np.empty((0, 4), np.int64), *sides.values()])
    owner = np.repeat(np.arange(len(names)), [len(side) for side in sides.values()])
    marked = np.zeros(max(len(mesh.points), int(rows.max(initial=-1)) + 1), bool)
    marked[rows[rows != NONE]] = True
    there = np.flatnonzero(np.logical_and.reduceat(marked[mesh.faces.values], mesh.faces.starts[:-1]))
    _, which = np.unique(np.concatenate([_pad(mesh.faces.take(there)), rows]), axis=0, return_inverse=True)
    face_of = np.full(int(which.max(initial=-1)) + 1, NONE)
    face_of[which.ravel()[: len(there)]] = there
    faces = face_of[which.ravel()[len(there) :]]
    inside = len(mesh.neighbour)
    surfaces = {name: np.sort(faces[(owner == k) & (faces >= inside)]) for k, name in enumerate(names)}
    inner = np.bincount(owner[(faces >= 0) & (faces < inside)], minlength=len(names)).tolist()
    loose = np.bincount(owner[faces < 0], minlength=len(names)).tolist()
    rest = np.setdiff1d(np.arange(inside, len(mesh.owner)), np.concatenate([[], *surfaces.values()]))
    if len(rest):
        surfaces.setdefault(WALLS, rest)
    between, off = ({name: n for name, n in zip(names, of, strict=True) if n} for of in (inner, loose))
    return ImportedMesh(mesh, surfaces, between, off, others)


def _pad(faces: Ragged) -> np.ndarray:
    """Faces of at most four points as sorted rows of four."""
    rows = np.full((len(faces), 4), NONE, np.int64)
    column = np.arange(len(faces.values)) - np.repeat(faces.starts[:-1], faces.lengths)
    rows[np.repeat(np.arange(len(faces)), faces.lengths), column] = faces.values
    return np.sort(rows, axis=1)


def choose_patches(found: ImportedMesh, inlet: str, outlet: str) -> PolyMesh:
    """The mesh with three patches: the surfaces `inlet` and `outlet` under these names, and all others as walls.

    Raises: CaseError (one text) if one is not there, is not all on the outside, or if they share faces.
    """
    first, second = (take_surface(found, f"domain.{key}", name) for key, name in ((INLET, inlet), (OUTLET, outlet)))
    if shared := len(np.intersect1d(first, second)):
        text = f"{inlet} and {outlet} share {shared} faces"
        raise CaseError([f"{text}; name two surfaces with domain.inlet and domain.outlet that share none."])
    return arrange_patches(found.mesh, first, [second])


def take_surfaces(found: ImportedMesh, key: str, patterns: Sequence[str]) -> np.ndarray:
    """Faces of the surfaces that names or shell patterns, given by the option `key`, mean.

    Raises: CaseError (one text) if one means no surface, or a surface is not all on the outside.
    """
    faces = [np.empty(0, np.int64)]
    for pattern in patterns:
        names = [pattern] if pattern in found.surfaces else fnmatch.filter(found.surfaces, pattern)
        faces += [take_surface(found, key, name) for name in names or [pattern]]
    return np.unique(np.concatenate(faces))


def take_surface(found: ImportedMesh, key: str, name: str) -> np.ndarray:
    """Faces of the surface `name`, which the option `key` gives.

    Raises: CaseError (one text) unless it is there and all of it on the outside of cells.
    """
    if inner := found.inner.get(name):
        text = f"{inner} faces of {name} lie between two cells"
        raise CaseError([f"{text}; {key} is on the outside of the mesh: take them out of the group."])
    if loose := found.loose.get(name):
        text = f"{loose} faces of {name} are no sides of cells"
        raise CaseError([f"{text}; mesh surface and volume in one go, so that they share their points."])
    if len(found.surfaces.get(name, [])):
        return found.surfaces[name]
    known = ", ".join(word for word, faces in found.surfaces.items() if len(faces)) or "none"
    text = f"there is no patch {name} with faces"
    if name in found.others and name not in found.surfaces:
        text = f"{name} is a group of volumes, curves or points, a group of surfaces is allowed"
    elif name in found.surfaces:
        text = f"the patch {name} has no faces"
    if list(found.surfaces) == [WALLS]:
        known += f' (the file names no other; in gmsh `Physical Surface("{name}") = {{...}};`, saved in format 4.1)'
    raise CaseError([f"{text}; give {key} = one of: {known}."])


def arrange_patches(
    mesh: PolyMesh, first: np.ndarray, outlets: Sequence[np.ndarray], kept: Sequence[str] = ()
) -> PolyMesh:
    """The mesh with the outer faces `first` as the patch inlet, those of `outlets` as outlet or, of several, outlet1
    and so on, and all others as walls but for the patches `kept`, which stay as they are."""
    inner = len(mesh.neighbour)
    others = [mesh.list_patch(name) for name in kept]
    rest = np.setdiff1d(np.arange(inner, len(mesh.owner)), np.concatenate([first, *outlets, *others]))
    parts = [first, *outlets, rest, *others]
    several = [f"{OUTLET}{number}" for number in range(1, len(outlets) + 1)] if len(outlets) > 1 else [OUTLET]
    order = np.concatenate([np.arange(inner), *parts])
    starts = np.cumsum([inner, *map(len, parts)]).tolist()[:-1]
    patches = dict(zip((INLET, *several, WALLS, *kept), zip(starts, map(len, parts), strict=True), strict=True))
    return replace(mesh, faces=mesh.faces.take(order), owner=mesh.owner[order], patches=patches)


def list_outlets(mesh: PolyMesh) -> list[str]:
    """The patches of a mesh by which gas leaves, in their order."""
    return [name for name in mesh.patches if name.startswith(OUTLET)]
