"""Start positions in a region that is no box: the sites of a lattice that lie inside, clear of the walls."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import partial

import numpy as np
import scipy

from fbcouple.case.bed.layers import stack
from fbcouple.case.bed.particle_types import (
    count_kinds,
    draw_kinds,
    largest_diameter,
    list_kinds,
    particle_count,
    word_count,
)
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.geometry.distance import Surface
from fbcouple.geometry.polyhedra import find_centres, take_apart
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.tetrahedra import cut

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
        from fbcouple.geometry.locator import Locator  # noqa: PLC0415  (loads numba)

        number = np.arange(mesh.count)
        cells = take_apart(mesh, find_centres(mesh), number, np.arange(len(mesh.points)))
        self._locator = Locator(cut(cells))
        triangles = mesh.cut_faces(np.arange(len(mesh.neighbour), len(mesh.owner)))
        self._surface = Surface(triangles)
        self._walls = scipy.spatial.cKDTree(triangles.mean(axis=1))
        self._widest = float(np.linalg.norm(triangles - triangles.mean(axis=1)[:, None], axis=2).max())

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Which of `points` (n, 3) are in the mesh."""
        return np.asarray(self._locator.holds(points))

    def is_clear(self, points: np.ndarray, distance: float) -> np.ndarray:
        """Is a sphere of the radius `distance` [m] about each of `points` (n, 3) inside? Walls count as flat there; of
        one thinner than that, and of edges, the distance is measured: what lies behind them may be inside, too."""
        clear = self._locator.holds(points)
        near = np.flatnonzero(clear)
        near = near[self._walls.query(points[near])[0] < distance + self._widest]
        for way in DIRECTIONS:
            near = near[clear[near]]
            clear[near] = self._locator.holds(points[near] + distance / LEAST_COSINE * way)
        near = near[clear[near]]
        clear[near] = ~self._surface.is_near(points[near], np.full(len(near), distance))
        return clear


class Lattice:
    """Sites of a cubic lattice of a `spacing` [m] in the box `low` to `high` (3,) [m], in its middle along x and y."""

    def __init__(self, mesh: PolyMesh, spacing: float, low: np.ndarray, high: np.ndarray) -> None:
        extent = high - low
        self.spacing = spacing
        *self.across, self.layers = (max(1, math.floor(edge / spacing)) for edge in extent.tolist())
        self._corner = low[:2] + 0.5 * (extent[:2] - spacing * np.array(self.across))
        points = mesh.points[mesh.faces.values]
        self._low, self._high = (way.reduceat(points, mesh.faces.starts[:-1]) for way in (np.minimum, np.maximum))

    def find_extent(self, height: float) -> tuple[tuple[int, int], tuple[int, int]]:
        """First columns and rows, and those after the last, that the layer at `height` [m] has sites inside of the mesh
        in: it is no wider than the faces that it crosses."""
        crossed = (self._low[:, 2] <= height) & (self._high[:, 2] >= height)
        if not crossed.any():
            return (0, 0), (0, 0)
        low = (self._low[crossed, :2].min(axis=0) - self._corner) / self.spacing - 0.5
        high = (self._high[crossed, :2].max(axis=0) - self._corner) / self.spacing - 0.5
        first = np.maximum(np.ceil(low), 0).astype(int).tolist()
        last = np.minimum(np.floor(high) + 1, self.across).astype(int).tolist()
        return (first[0], first[1]), (last[0], last[1])

    def list_sites(self, height: float, low: tuple[int, int], high: tuple[int, int], step: int) -> np.ndarray:
        """Every `step`th site of the columns and rows from `low` to before `high` at `height` [m], (sites, 3)."""
        columns, rows = (np.arange(start, end, step) for start, end in zip(low, high, strict=True))
        x, y = (axis.ravel() for axis in np.meshgrid(columns, rows, indexing="xy"))
        flat = self._corner + self.spacing * (np.column_stack([x, y]) + 0.5)
        return np.column_stack([flat, np.full(len(x), height)])


def fill_region(case: Case, mesh: PolyMesh) -> tuple[np.ndarray, np.ndarray]:
    """Place the particles of a case on the sites of a cubic lattice inside `mesh`, from its lowest layer up.

    Sites are `start.spacing` largest diameters apart and shaken as in a box; where that are too few for a mixture, each
    layer holds one kind at its own spacing. Returns: centres [m], (particles, 3), and the kind of each, (particles,).
    Raises: CaseError (one text) if there are fewer sites than particles.
    """
    assert case.particles is not None and case.start is not None
    count, diameter = particle_count(case.particles), largest_diameter(case.particles)
    spacing, inside = case.start.spacing * diameter, Inside(mesh)
    low, high = find_start_part(case, mesh)
    lattice, reach = Lattice(mesh, spacing, low, high), find_reach(case, spacing, diameter)
    clear = partial(inside.is_clear, distance=0.5 * diameter + math.sqrt(3.0) * reach)
    found: list[np.ndarray] = [np.empty((0, 3))]
    for layer in range(lattice.layers):
        height = float(low[2]) + (layer + 0.5) * spacing
        found.append(_fill_layer(lattice, height, count - sum(map(len, found)), clear))
        if sum(map(len, found)) >= count:
            break
    sites = np.concatenate(found)
    held = len(sites)
    if held < count:
        if len(list_kinds(case.particles)) > 1:
            return _fill_layers(case, mesh, inside, held)
        raise CaseError([_format_few(case, f"has {held} sites inside")])
    sites = _thin_out(sites, count, len(found[-1]))
    shift = np.random.default_rng(case.start.seed).uniform(-1.0, 1.0, sites.shape)
    return sites + shift * reach, draw_kinds(case.particles, case.start.seed)


def find_start_part(case: Case, mesh: PolyMesh) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner (3,) [m] of the box around `mesh`, or of the part of it that `start.region` names."""
    if case.start is None or case.start.region is None:
        return mesh.low, mesh.high
    low, high = np.array(case.start.region).T
    return low, high


def find_reach(case: Case, spacing: float, diameter: float) -> float:
    """How far [m] a particle is shaken along each axis."""
    assert case.start is not None
    return 0.5 * case.start.jitter * (spacing - diameter)


def _fill_layers(case: Case, mesh: PolyMesh, inside: Inside, mixed: int) -> tuple[np.ndarray, np.ndarray]:
    """The same with one kind a layer; a lattice that mixes them has `mixed` sites only."""
    assert case.particles is not None and case.start is not None
    kinds, counts = list_kinds(case.particles), count_kinds(case.particles)
    heights = case.start.spacing * np.array([kind.diameter for kind in kinds])
    reaches = [find_reach(case, height, kind.diameter) for height, kind in zip(heights, kinds, strict=True)]
    low, high = find_start_part(case, mesh)
    lattices = [Lattice(mesh, float(height), low, high) for height in heights]
    seen: dict[tuple[int, float], np.ndarray] = {}

    def count_sites(kind: int, floor: float) -> int:
        if (kind, floor) not in seen:
            clear = partial(inside.is_clear, distance=0.5 * kinds[kind].diameter + math.sqrt(3.0) * reaches[kind])
            seen[kind, floor] = _fill_layer(lattices[kind], floor + 0.5 * heights[kind], int(counts[kind]), clear)
        return len(seen[kind, floor])

    layers = list(stack(counts, heights, count_sites, float(low[2]), float(high[2])))
    if (held := sum(layer.count for layer in layers)) < particle_count(case.particles):
        raise CaseError([_format_few(case, f"has {mixed} sites inside, one with a kind a layer room for {held}")])
    sites = np.concatenate([_thin_out(seen[layer.kind, layer.floor], layer.count) for layer in layers])
    found = np.concatenate([np.full(layer.count, layer.kind) for layer in layers])
    shift = np.random.default_rng(case.start.seed).uniform(-1.0, 1.0, sites.shape)
    return sites + shift * np.array(reaches)[found, None], found


def _format_few(case: Case, held: str) -> str:
    assert case.particles is not None and case.start is not None
    wanted = word_count(case.particles, particle_count(case.particles), 10)
    text = f"a lattice at {case.start.spacing:g} diameters {held} for {wanted}"
    room = "mesh" if case.start.region is None else "start.region"
    return f"start.spacing: {text}; lower the spacing (above 1), give fewer particles or a larger {room}."


def _fill_layer(lattice: Lattice, height: float, count: int, clear: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """The clear sites of a layer: all of them, or of a layer with far more than `count` of each way the every second,
    third ... if they are enough. A layer with none of them clear, the second time closer, counts as full."""
    low, high = lattice.find_extent(height)
    columns, rows = (max(0, end - start) for start, end in zip(low, high, strict=True))
    step = max(1, math.isqrt(columns * rows // (_PER_PARTICLE * count + _FEW_SITES)))
    for look in itertools.count():
        sites = lattice.list_sites(height, low, high, step)
        sites = sites[clear(sites)]
        if step == 1 or len(sites) >= count or (look >= _LOOKS and not len(sites)):
            break
        step = max(1, step // 2)
    return sites


def _thin_out(sites: np.ndarray, count: int, last: int | None = None) -> np.ndarray:
    """`count` of the sites: all but those of the last layer, the `last` ones (None: all are), and what is wanted of it
    at even steps."""
    last = len(sites) if last is None else last
    full = len(sites) - last
    chosen = full + (np.arange(count - full) * last) // max(count - full, 1)
    return np.concatenate([sites[:full], sites[chosen]])
