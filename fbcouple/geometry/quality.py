"""Whether the cells of a mesh can hold a gas: one body, closed, of positive volume, seen whole from their centres."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from fbcouple.errors import CaseError
from fbcouple.geometry.polyhedra import find_centres
from fbcouple.geometry.polymesh import PolyMesh

_OPEN = 1e-6
"""Sum of a cell's outward face areas over the sum of their sizes, above which it is open (checkMesh has the same)."""
_TOUCHING = 1e-6
"""Distance of two points, over the edge of a usual cell, below which they are at one place."""
_FACES_AT_ONCE = 100_000


def require_sound(mesh: PolyMesh) -> None:
    """Raise CaseError, a text for each kind of fault, if cells cannot be used or do not hang together."""
    problems = [*_find_bad_cells(mesh)] or [*_find_bodies(mesh)]
    if problems:
        raise CaseError(problems)


def _find_bad_cells(mesh: PolyMesh) -> Iterator[str]:
    centres = find_centres(mesh)
    volumes, least, openness = measure_cells(mesh, centres)
    unclosed = openness > _OPEN
    inverted = (volumes <= 0.0) & ~unclosed
    hidden = (least <= 0.0) & ~unclosed & ~inverted
    yield from _word(unclosed, centres, "are not closed: a face is missing, or its points go round the wrong way")
    yield from _word(inverted, centres, "have no positive volume: they are inside out, flat, or have no faces")
    yield from _word(hidden, centres, "are not star-shaped: their centres do not see all of their faces")


def _word(chosen: np.ndarray, centres: np.ndarray, what: str) -> Iterator[str]:
    cells = np.flatnonzero(chosen)
    if len(cells):
        where = ", ".join(f"{x:.4g}" for x in centres[cells[0]])
        text = f"{len(cells)} of {len(chosen)} cells {what} (first: cell {cells[0]} at ({where}) m)"
        yield f"{text}; mesh again (gmsh: Mesh.Optimize = 1; checkMesh names such cells)."


def measure_cells(mesh: PolyMesh, centres: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each cell its volume [m3], the least volume [m3] of the tetrahedra from its centre (n, 3) [m] to its surface,
    and how far it is from closed: its outward areas added up, over their sizes."""
    count, inner = mesh.count, len(mesh.neighbour)
    volumes, least = np.zeros(count), np.full(count, np.inf)
    areas, sizes = np.zeros((count, 3)), np.zeros(count)
    for first in range(0, len(mesh.owner), _FACES_AT_ONCE):
        faces = np.arange(first, min(first + _FACES_AT_ONCE, len(mesh.owner)))
        triangles, which = mesh.list_triangles(faces)
        a, b, c = triangles.transpose(1, 0, 2)
        normals = 0.5 * np.cross(b - a, c - a)
        both = faces[which] < inner
        for cells, chosen, sign in ((mesh.owner, slice(None), 1.0), (mesh.neighbour, both, -1.0)):
            cell = cells[faces[which[chosen]]]
            parts = sign * np.einsum("ij,ij->i", a[chosen] - centres[cell], normals[chosen]) / 3.0
            volumes += np.bincount(cell, parts, count)
            np.minimum.at(least, cell, parts)
            sizes += np.bincount(cell, np.linalg.norm(normals[chosen], axis=1), count)
            areas += np.stack([np.bincount(cell, sign * normals[chosen, k], count) for k in range(3)], axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        openness = np.nan_to_num(np.linalg.norm(areas, axis=1) / sizes)
    return volumes, least, openness


def measure_widths(mesh: PolyMesh) -> np.ndarray:
    """Width of each cell along x, y and z [m], (n, 3): its volume over its area across that axis. The Courant number of
    a flow u along it is u dt over this width, as OpenFOAM counts it: half the sum of the flows through its faces."""
    volumes, *_ = measure_cells(mesh, find_centres(mesh))
    across = 0.5 * np.abs(mesh.find_vectors(np.arange(len(mesh.owner))))
    inner = len(mesh.neighbour)
    areas = [
        np.bincount(mesh.owner, part, mesh.count) + np.bincount(mesh.neighbour, part[:inner], mesh.count)
        for part in across.T
    ]
    return volumes[:, None] / np.stack(areas, axis=1)


def _find_bodies(mesh: PolyMesh) -> Iterator[str]:
    """Parts of the mesh that share no face: gas that cannot flow from one to the other."""
    inner = len(mesh.neighbour)
    links = scipy.sparse.coo_matrix((np.ones(inner), (mesh.owner[:inner], mesh.neighbour)), (mesh.count, mesh.count))
    bodies, label = scipy.sparse.csgraph.connected_components(links, directed=False)
    if bodies == 1:
        return
    sizes = ", ".join(str(size) for size in np.sort(np.bincount(label))[::-1][:5].tolist())
    text = f"the mesh has {bodies} bodies that share no face (of {sizes}{', ...' if bodies > 5 else ''} cells)"
    edge = (mesh.volume / mesh.count) ** (1.0 / 3.0)
    if double := len(scipy.spatial.cKDTree(mesh.points).query_pairs(_TOUCHING * edge)):
        mend = "make the volumes share their surface (gmsh: Coherence; or BooleanFragments; OpenFOAM: stitchMesh)"
        yield f"{text}, and {double} points are there twice: {mend}."
    else:
        yield f"{text}; join them, or keep one."
