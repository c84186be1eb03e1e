"""What the particles and the gas of a case are in: a box, a cylinder or a box of tetrahedra that is meshed here, or a
mesh from a file."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from fbcouple.case.bed.inlet_profile import read_profiles
from fbcouple.case.bed.openings import Openings, open_mesh
from fbcouple.case.bed.streams import Opening, Stream, has_openings, list_outlets, list_streams
from fbcouple.case.companions import find_mesh
from fbcouple.case.schema.gas import Domain
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.geometry.baffles import find_unsplit, pair_faces, split_points
from fbcouple.geometry.block import PER_SQUARE, list_cyclic, make_block, make_hexahedra
from fbcouple.geometry.cylinder import count_cells, find_section, make_cylinder
from fbcouple.geometry.extrusion import PER_PRISM
from fbcouple.geometry.filling import Filling
from fbcouple.geometry.imported import INLET, OUTLET, ImportedMesh, choose_patches
from fbcouple.geometry.imported import read_mesh as read_imported
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.quality import require_sound

TETRAHEDRA = "tetrahedra"
UP = (0.0, 0.0, 1.0)
Make = Callable[[Domain, Path], PolyMesh]
SHAPES: dict[str, Make] = {}


def shape(name: str) -> Callable[[Make], Make]:
    """Register how the mesh of the word `name` of domain.shape is had; a box of hexahedra asks for none."""

    def register(make: Make) -> Make:
        SHAPES[name] = make
        return make

    return register


@dataclass(frozen=True)
class Region:
    """Number of gas cells, volume [m3], height [m], area [m2] of the inlet, edges (3,) [m] of a usual cell, mean inward
    normal of the inlet's faces, and the lower corner (3,) [m] of the box around it.

    `inlet` is the area that a superficial velocity counts for: of a box the whole floor, also where a part is closed.
    `surface`: the triangles (n, 3, 3) [m] of a mesh from a file; None where the cross-section is one at all heights.
    """

    cells: int
    volume: float
    height: float
    inlet: float
    spacing: np.ndarray
    direction: tuple[float, ...] = UP
    corner: tuple[float, ...] = (0.0, 0.0, 0.0)
    surface: np.ndarray | None = None

    @property
    def bottom(self) -> float:
        """Height [m] of the lowest point."""
        return self.corner[2]

    @property
    def section(self) -> float:
        """Mean horizontal cross-section [m2]."""
        return self.volume / self.height

    def find_level(self, volume: float) -> float:
        """Height [m] above the lowest point up to which `volume` [m3] fills the region from below."""
        return volume / self.section if self.surface is None else Filling(self.surface).find_level(volume)


def read_mesh(case: Case, folder: Path = Path()) -> PolyMesh:
    """The mesh of a case that is no plain box, or has openings, with the patches inlet, outlet and walls; its own files
    lie in `folder`.

    Raises: CaseError (one text, without the key) if the mesh cannot be read.
    """
    if has_openings(case):
        return find_openings(case, folder).mesh
    return SHAPES[case.domain.shape](case.domain, case.find_folder(folder, case.domain.mesh))


def has_own_mesh(case: Case) -> bool:
    """Is the mesh made or read here, and none of blockMesh's?"""
    return not case.domain.is_plain_box or has_openings(case)


def find_openings(case: Case, folder: Path = Path()) -> Openings:
    """The mesh of a case with openings, and what each stream has of its inlet's faces. Raises: CaseError as
    `read_mesh`."""
    streams, outlets = read_profiles(case, list_streams(case), folder), list_outlets(case)
    if case.domain.shape != "file":
        return _open_made(case.domain, streams, outlets)
    found = find_imported(case.domain, case.find_folder(folder, case.domain.mesh))
    return _open_imported(found, streams, outlets)


@lru_cache(maxsize=2)
def _open_made(domain: Domain, streams: tuple[Stream, ...], outlets: tuple[Opening, ...]) -> Openings:
    if domain.is_plain_box:
        kept = [name for pair in list_cyclic(domain.periodic) for name in pair]
        return open_mesh(make_hexahedra(domain.size, domain.cells, domain.periodic), streams, outlets, kept=kept)
    return open_mesh(SHAPES[domain.shape](domain, Path()), streams, outlets)


@lru_cache(maxsize=2)
def _open_imported(found: ImportedMesh, streams: tuple[Stream, ...], outlets: tuple[Opening, ...]) -> Openings:
    return open_mesh(found.mesh, streams, outlets, found)


def find_region(case: Case, folder: Path = Path()) -> Region:
    """Size and cells of the region of a case whose own files lie in `folder`. Raises: CaseError as `read_mesh`."""
    domain = case.domain
    if domain.is_plain_box:
        spacing = np.array(domain.size) / np.array(domain.cells)
        floor = domain.size[0] * domain.size[1]
        return Region(math.prod(domain.cells), math.prod(domain.size), domain.size[2], floor, spacing)
    if domain.shape == "cylinder":
        cells = count_cells(domain.cells[0], domain.cells[2], domain.elements or TETRAHEDRA)
        floor = find_section(domain.size[0], domain.cells[0])
        volume = floor * domain.size[2]
    elif domain.shape == "box":
        cells = math.prod(domain.cells) * PER_SQUARE * PER_PRISM[domain.elements or TETRAHEDRA]
        volume, floor = math.prod(domain.size), domain.size[0] * domain.size[1]
    else:
        return _measure_mesh(read_mesh(case, folder))
    return Region(cells, volume, domain.size[2], floor, find_spacing(volume, cells))


def find_spacing(volume: float, cells: int) -> np.ndarray:
    """Edges (3,) [m] of a cube that is as large as a mean cell."""
    return np.full(3, (volume / cells) ** (1.0 / 3.0))


def _measure_mesh(mesh: PolyMesh) -> Region:
    vectors = mesh.find_vectors(mesh.list_patch(INLET))
    inward = -vectors.sum(axis=0) / np.linalg.norm(vectors, axis=1).sum()
    surface = mesh.cut_faces(np.arange(len(mesh.neighbour), len(mesh.owner)))
    return Region(
        mesh.count,
        mesh.volume,
        float(mesh.high[2] - mesh.low[2]),
        mesh.find_area(INLET),
        find_spacing(mesh.volume, mesh.count),
        tuple(inward.tolist()),
        tuple(mesh.low.tolist()),
        surface,
    )


@shape("cylinder")
def mesh_cylinder(domain: Domain, folder: Path) -> PolyMesh:
    """An upright cylinder of the diameter and height `size`, `cells` across and up."""
    diameter, _, height = domain.size
    return make_cylinder(diameter, height, domain.cells[0], domain.cells[2], domain.elements or TETRAHEDRA)


@shape("box")
def mesh_block(domain: Domain, folder: Path) -> PolyMesh:
    """A box whose hexahedra are cut into the `elements` that the case asks for."""
    return make_block(domain.size, domain.cells, domain.elements or TETRAHEDRA)


@shape("file")
def read_mesh_of_case(domain: Domain, folder: Path) -> PolyMesh:
    """The mesh that the case brings: a gmsh file, or a polyMesh folder."""
    found = find_imported(domain, folder)
    return _choose_once(found, domain.inlet or INLET, domain.outlet or OUTLET)


def read_imported_mesh(case: Case, folder: Path) -> PolyMesh:
    """The mesh from a file as it is there. Raises: CaseError as `read_mesh`."""
    return find_imported(case.domain, case.find_folder(folder, case.domain.mesh)).mesh


def list_inner_surfaces(case: Case, folder: Path) -> dict[str, int]:
    """Surfaces of the case's mesh file that lie between cells, and how many faces of each do."""
    if case.domain.shape != "file":
        return {}
    return find_imported(case.domain, case.find_folder(folder, case.domain.mesh)).inner


def count_baffles(case: Case, folder: Path) -> tuple[int, int]:
    """Faces of the case's mesh file that are wall on both sides, each counted once, and those that weights and filter
    do not see as they have no points of their own on either side."""
    if case.domain.shape != "file":
        return 0, 0
    found = find_imported(case.domain, case.find_folder(folder, case.domain.mesh))
    return len(found.baffles), int(find_unsplit(found.mesh, found.baffles).sum())


def find_imported(domain: Domain, folder: Path) -> ImportedMesh:
    if domain.mesh is None:
        raise CaseError(["no mesh is given."])
    path = find_mesh(folder, domain.mesh).resolve()
    newest = max((part.stat().st_mtime_ns for part in [path, *path.glob("*")] if part.exists()), default=0)
    return _read_once(path, newest, domain.scale or 1.0)


@lru_cache(maxsize=2)
def _read_once(path: Path, newest: int, scale: float) -> ImportedMesh:
    try:
        found = read_imported(path)
        if scale != 1.0:
            found = replace(found, mesh=replace(found.mesh, points=found.mesh.points * scale))
        require_sound(found.mesh)
    except CaseError as error:
        raise CaseError([f"{path.name}: {problem}" for problem in error.problems]) from None
    pairs = pair_faces(found.mesh)
    return replace(found, mesh=split_points(found.mesh, pairs), baffles=pairs) if len(pairs) else found


@lru_cache(maxsize=2)
def _choose_once(found: ImportedMesh, inlet: str, outlet: str) -> PolyMesh:
    return choose_patches(found, inlet, outlet)
