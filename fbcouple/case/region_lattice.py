"""Start positions in a region that is no box: the sites of a lattice that lie inside, clear of the walls."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import partial

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


_PER_PARTICLE, _FEW_SITES = 8, 10_000
"""Sites of a layer that are looked at for each particle that is still to be placed, and beside that."""
_LOOKS = 1


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


class Lattice:
    """Sites of a cubic lattice of a `spacing` [m] in the box around a mesh, in its middle along x and y."""

    def __init__(self, mesh: PolyMesh, spacing: float) -> None:
        extent = mesh.high - mesh.low
        self.spacing = spacing
        self.shape = tuple(max(1, math.floor(edge / spacing)) for edge in extent.tolist())
        self._corner = mesh.low.copy()
        self._corner[:2] += 0.5 * (extent - spacing * np.array(self.shape))[:2]
        points = mesh.points[mesh.faces.values]
        self._low, self._high = (way.reduceat(points, mesh.faces.starts[:-1]) for way in (np.minimum, np.maximum))

    def find_extent(self, layer: int) -> tuple[tuple[int, int], tuple[int, int]]:
        """First columns and rows, and those after the last, that a layer has sites inside of the mesh in: it is no
        wider than the faces that it crosses."""
        height = self._corner[2] + (layer + 0.5) * self.spacing
        crossed = (self._low[:, 2] <= height) & (self._high[:, 2] >= height)
        if not crossed.any():
            return (0, 0), (0, 0)
        low = (self._low[crossed, :2].min(axis=0) - self._corner[:2]) / self.spacing - 0.5
        high = (self._high[crossed, :2].max(axis=0) - self._corner[:2]) / self.spacing - 0.5
        first = np.maximum(np.ceil(low), 0).astype(int).tolist()
        last = np.minimum(np.floor(high) + 1, self.shape[:2]).astype(int).tolist()
        return (first[0], first[1]), (last[0], last[1])

    def list_sites(self, layer: int, low: tuple[int, int], high: tuple[int, int], step: int) -> np.ndarray:
        """Every `step`th site of the columns and rows from `low` to before `high` of a layer [m], (sites, 3)."""
        columns, rows = (np.arange(start, end, step) for start, end in zip(low, high, strict=True))
        x, y = (axis.ravel() for axis in np.meshgrid(columns, rows, indexing="xy"))
        return self._corner + self.spacing * (np.column_stack([x, y, np.full(len(x), layer)]) + 0.5)


def fill_region(case: Case, mesh: PolyMesh) -> np.ndarray:
    """Place the particles of a case on the sites of a cubic lattice inside `mesh`, from its lowest layer up.

    Sites are `start.spacing` largest diameters apart and shaken as in a box. Returns: centres [m], (particles, 3).
    Raises: CaseError (one text) if there are fewer sites than particles.
    """
    assert case.particles is not None and case.start is not None
    count, diameter = particle_count(case.particles), largest_diameter(case.particles)
    spacing = case.start.spacing * diameter
    reach = 0.5 * case.start.jitter * (spacing - diameter)
    inside, lattice = Inside(mesh), Lattice(mesh, spacing)
    clear = partial(inside.is_clear, distance=0.5 * diameter + math.sqrt(3.0) * reach)
    found: list[np.ndarray] = [np.empty((0, 3))]
    for layer in range(lattice.shape[2]):
        found.append(_fill_layer(lattice, layer, count - sum(map(len, found)), clear))
        if sum(map(len, found)) >= count:
            break
    sites = np.concatenate(found)
    if len(sites) < count:
        text = f"a lattice at {case.start.spacing:g} diameters has {len(sites)} sites inside for {count} particles"
        raise CaseError([f"start.spacing: {text}; lower the spacing (above 1), give fewer particles or a larger mesh."])
    sites = _thin_out(sites, count, len(found[-1]))
    shift = np.random.default_rng(case.start.seed).uniform(-1.0, 1.0, sites.shape)
    return sites + shift * reach


def _fill_layer(lattice: Lattice, layer: int, count: int, clear: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """The clear sites of a layer: all of them, or of a layer with far more than `count` of each way the every second,
    third ... if they are enough. A layer with none of them clear, the second time closer, counts as full."""
    low, high = lattice.find_extent(layer)
    columns, rows = (max(0, end - start) for start, end in zip(low, high, strict=True))
    step = max(1, math.isqrt(columns * rows // (_PER_PARTICLE * count + _FEW_SITES)))
    for look in itertools.count():
        sites = lattice.list_sites(layer, low, high, step)
        sites = sites[clear(sites)]
        if step == 1 or len(sites) >= count or (look >= _LOOKS and not len(sites)):
            break
        step = max(1, step // 2)
    return sites


def _thin_out(sites: np.ndarray, count: int, last: int) -> np.ndarray:
    """All sites but the last layer, and what is wanted of it, at even steps."""
    full = len(sites) - last
    chosen = full + (np.arange(count - full) * last) // max(count - full, 1)
    return np.concatenate([sites[:full], sites[chosen]])
