"""Start positions in a region that is no box: the sites of a lattice that lie inside, clear of the walls."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fbcouple.case.layers import stack
from fbcouple.case.mixture import count_kinds, draw_kinds, largest_diameter, list_kinds, particle_count
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


def fill_region(case: Case, mesh: PolyMesh) -> tuple[np.ndarray, np.ndarray]:
    """Place the particles of a case on the sites of a cubic lattice inside `mesh`, from its lowest layer up.

    Sites are `start.spacing` largest diameters apart and shaken as in a box; where that are too few for a mixture, each
    layer holds one kind at its own spacing. Returns: centres [m], (particles, 3), and the kind of each, (particles,).
    Raises: CaseError (one text) if there are fewer sites than particles.
    """
    assert case.particles is not None and case.start is not None
    count, diameter = particle_count(case.particles), largest_diameter(case.particles)
    spacing = case.start.spacing * diameter
    floors = _Floors(Inside(mesh), mesh.low, mesh.high, case.start.jitter)
    found: list[np.ndarray] = []
    for layer in range(max(1, math.floor((mesh.high - mesh.low)[2] / spacing))):
        found.append(floors.find_sites(mesh.low[2] + (layer + 0.5) * spacing, spacing, diameter))
        if sum(map(len, found)) >= count:
            break
    sites = np.concatenate(found)
    held = len(sites)
    if held < count:
        if len(list_kinds(case.particles)) > 1:
            return _fill_layers(case, floors, held)
        raise CaseError([_word_few(case, f"has {held} sites inside")])
    sites = _thin_out(sites, count, len(found[-1]))
    shift = np.random.default_rng(case.start.seed).uniform(-1.0, 1.0, sites.shape)
    return sites + shift * floors.find_reach(spacing, diameter), draw_kinds(case.particles, case.start.seed)


@dataclass(frozen=True)
class _Floors:
    """Sites of square lattices in a region, layer by layer."""

    inside: Inside
    low: np.ndarray
    high: np.ndarray
    jitter: float

    def find_reach(self, spacing: float, diameter: float) -> float:
        """How far [m] a particle is shaken along each axis."""
        return 0.5 * self.jitter * (spacing - diameter)

    def find_sites(self, height: float, spacing: float, diameter: float) -> np.ndarray:
        """Sites (n, 3) [m] at `height` that keep clear of the walls however they are shaken."""
        columns, rows = (max(1, math.floor(extent / spacing)) for extent in (self.high - self.low)[:2])
        x, y = (a.ravel() for a in np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5, indexing="xy"))
        middle = self.low[:2] + 0.5 * ((self.high - self.low)[:2] - spacing * np.array([columns, rows]))
        sites = np.column_stack([middle[0] + spacing * x, middle[1] + spacing * y, np.full(len(x), height)])
        return sites[self.inside.is_clear(sites, 0.5 * diameter + math.sqrt(3.0) * self.find_reach(spacing, diameter))]


def _fill_layers(case: Case, floors: _Floors, mixed: int) -> tuple[np.ndarray, np.ndarray]:
    """The same with one kind a layer; a lattice that mixes them has `mixed` sites only."""
    assert case.particles is not None and case.start is not None
    kinds = list_kinds(case.particles)
    heights = case.start.spacing * np.array([kind.diameter for kind in kinds])
    seen: dict[tuple[int, float], np.ndarray] = {}

    def count_sites(kind: int, floor: float) -> int:
        if (kind, floor) not in seen:
            middle = floor + 0.5 * heights[kind]
            seen[kind, floor] = floors.find_sites(middle, heights[kind], kinds[kind].diameter)
        return len(seen[kind, floor])

    layers = list(stack(count_kinds(case.particles), heights, count_sites, floors.low[2], floors.high[2]))
    if (held := sum(layer.count for layer in layers)) < particle_count(case.particles):
        raise CaseError([_word_few(case, f"has {mixed} sites inside, one with a kind a layer room for {held}")])
    sites = np.concatenate([_thin_out(seen[layer.kind, layer.floor], layer.count) for layer in layers])
    found = np.concatenate([np.full(layer.count, layer.kind) for layer in layers])
    reach = np.array([floors.find_reach(h, kind.diameter) for h, kind in zip(heights, kinds, strict=True)])[found]
    return sites + np.random.default_rng(case.start.seed).uniform(-1.0, 1.0, sites.shape) * reach[:, None], found


def _word_few(case: Case, held: str) -> str:
    assert case.particles is not None and case.start is not None
    text = f"a lattice at {case.start.spacing:g} diameters {held} for {particle_count(case.particles)} particles"
    return f"start.spacing: {text}; lower the spacing (above 1), give fewer particles or a larger mesh."


def _thin_out(sites: np.ndarray, count: int, last: int | None = None) -> np.ndarray:
    """`count` of the sites: all but those of the last layer, the `last` ones (None: all are), and what is wanted of it
    at even steps."""
    last = len(sites) if last is None else last
    full = len(sites) - last
    chosen = full + (np.arange(count - full) * last) // max(count - full, 1)
    return np.concatenate([sites[:full], sites[chosen]])
