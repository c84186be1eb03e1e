"""Start positions in a region that is no box: the sites of a lattice that lie inside, clear of the walls."""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy.spatial import cKDTree

from fbcouple.case.mixture import largest_diameter, particle_count
from fbcouple.case.schema import Case
from fbcouple.errors import CaseError
from fbcouple.meshes.polyhedra import find_centres, take_apart
from fbcouple.meshes.polymesh import PolyMesh
from fbcouple.meshes.tetrahedra import cut

_AROUND = np.array([way for way in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
DIRECTIONS = _AROUND / np.linalg.norm(_AROUND, axis=1, keepdims=True)
LEAST_COSINE = 0.886
"""Of the angle between any direction and the nearest of the 26 DIRECTIONS (3 million random ones, rounded down)."""


class Inside:
    """Which points of a mesh are clear of its walls."""

    def __init__(self, mesh: PolyMesh) -> None:
        from fbcouple.meshes.locator import Locator  # noqa: PLC0415  (loads numba)

        number = np.arange(mesh.count)
        cells = take_apart(mesh, find_centres(mesh), number, np.arange(len(mesh.points)))
        self._locator = Locator(cut(cells))
        triangles = mesh.cut_faces(np.arange(len(mesh.neighbour), len(mesh.owner)))
        self._walls = cKDTree(triangles.mean(axis=1))
        self._widest = float(np.linalg.norm(triangles - triangles.mean(axis=1)[:, None], axis=2).max())

    def is_clear(self, points: np.ndarray, distance: float) -> np.ndarray:
        """Is a sphere of the radius `distance` [m] about each of `points` (n, 3) inside? Walls count as flat there."""
        clear = self._locator.holds(points)
        near = np.flatnonzero(clear)
        near = near[self._walls.query(points[near])[0] < distance + self._widest]
        for way in DIRECTIONS:
            near = near[clear[near]]
            clear[near] = self._locator.holds(points[near] + distance / LEAST_COSINE * way)
        return clear


def fill_region(case: Case, mesh: PolyMesh) -> np.ndarray:
    """Place the particles of a case on the sites of a cubic lattice inside `mesh`, from its lowest layer up.

    Sites are `start.spacing` largest diameters apart and shaken as in a box. Returns: centres [m], (particles, 3).
    Raises: CaseError (one text) if there are fewer sites than particles.
    """
    assert case.particles is not None and case.start is not None
    count, diameter = particle_count(case.particles), largest_diameter(case.particles)
    spacing = case.start.spacing * diameter
    reach = 0.5 * case.start.jitter * (spacing - diameter)
    inside, low, high = Inside(mesh), mesh.low, mesh.high
    columns, rows, layers = (max(1, math.floor(extent / spacing)) for extent in high - low)
    x, y = (a.ravel() for a in np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5, indexing="xy"))
    middle = low[:2] + 0.5 * (high - low - spacing * np.array([columns, rows, layers]))[:2]
    floor = np.column_stack([middle[0] + spacing * x, middle[1] + spacing * y])
    found: list[np.ndarray] = []
    for layer in range(layers):
        sites = np.column_stack([floor, np.full(len(floor), low[2] + (layer + 0.5) * spacing)])
        found.append(sites[inside.is_clear(sites, 0.5 * diameter + math.sqrt(3.0) * reach)])
        if sum(map(len, found)) >= count:
            break
    sites = np.concatenate(found)
    if len(sites) < count:
        text = f"a lattice at {case.start.spacing:g} diameters has {len(sites)} sites inside for {count} particles"
        raise CaseError([f"start.spacing: {text}; lower the spacing (above 1), give fewer particles or a larger mesh."])
    sites = _thin_out(sites, count, len(found[-1]))
    shift = np.random.default_rng(case.start.seed).uniform(-1.0, 1.0, sites.shape)
    return sites + shift * reach


def _thin_out(sites: np.ndarray, count: int, last: int) -> np.ndarray:
    """All sites but the last layer, and what is wanted of it, at even steps."""
    full = len(sites) - last
    chosen = full + (np.arange(count - full) * last) // max(count - full, 1)
    return np.concatenate([sites[:full], sites[chosen]])
