"""Start positions of the particles: a jittered simple cubic lattice that fills the floor layer by layer.

Each site takes any kind, so that a mixture is mixed at random. Where the box is too low for that, because sites for the
largest are wasted on the smallest, each layer holds one kind at its own spacing (layers.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fbcouple.case.bed.layers import Layer, stack
from fbcouple.case.bed.particle_types import count_kinds, draw_kinds, largest_diameter, list_kinds, particle_count
from fbcouple.case.bed.region import read_mesh
from fbcouple.case.schema.sections import Case

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True)
class Layout:
    """Sites along x and y, layers along z, and the distance of neighbouring sites [m] along each axis."""

    columns: int
    rows: int
    layers: int
    spacing: tuple[float, float, float]


def find_start_box(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Lower corner and size (3,) [m] of what the start in a box fills from below: `start.region`, or all of it."""
    if case.start is None or case.start.region is None:
        return np.zeros(3), np.array(case.domain.size)
    low, high = np.array(case.start.region).T
    return low, high - low


def lay_out(case: Case, diameter: float | None = None, count: int | None = None) -> Layout:
    """Stretch the wanted spacing along x and y until the sites fill the floor, and count the layers.

    It is a multiple of the largest diameter, so that each site takes any kind; or of `diameter` [m], for `count`.

    A box narrower than the wanted spacing along x or y (but not than a particle) takes one site in its middle.
    """
    assert case.particles is not None and case.start is not None, "checks ask for [particles] and [start]"
    width, depth, _ = find_start_box(case)[1].tolist()
    wanted = case.start.spacing * (diameter or largest_diameter(case.particles))
    columns = max(1, math.floor(width / wanted))
    rows = max(1, math.floor(depth / wanted))
    layers = -(-(particle_count(case.particles) if count is None else count) // (columns * rows))
    return Layout(columns, rows, layers, (width / columns, depth / rows, wanted))


def lay_out_kinds(case: Case) -> list[Layout]:
    """The same of each kind on layers of its own."""
    assert case.particles is not None
    kinds = zip(list_kinds(case.particles), count_kinds(case.particles), strict=True)
    return [lay_out(case, kind.diameter, count) for kind, count in kinds]


def mixed_height(case: Case) -> float:
    """Height [m] of a start lattice whose sites take any kind, from the floor to half a spacing above the last layer's
    centres."""
    layout = lay_out(case)
    return layout.layers * layout.spacing[2]


def is_layered(case: Case) -> bool:
    """Does the start in a box hold one kind a layer, because a lattice that mixes them would be higher than the box?"""
    assert case.particles is not None
    return len(list_kinds(case.particles)) > 1 and mixed_height(case) > find_start_box(case)[1][2] * (1 + 1e-9)


def lattice_height(case: Case) -> float:
    """Height [m] that the start in a box takes up."""
    if not is_layered(case):
        return mixed_height(case)
    return sum(layout.layers * layout.spacing[2] for layout in lay_out_kinds(case))


def lattice_positions(case: Case, folder: Path = Path()) -> np.ndarray:
    """Place the particles of a case, whose own files lie in `folder`, on its start lattice.

    Each coordinate is shifted by up to half of `start.jitter` times the free gap along that axis, so no two
    particles touch and none touches a wall. A last layer that is not full is spread over the whole floor.

    Returns: centres [m], shape (particles, 3), layer by layer from the floor.
    """
    assert case.particles is not None and case.start is not None
    if case.domain.shape != "box":
        return _fill_region(case, folder)[0]
    if is_layered(case):
        return _place_layers(case)
    layout = lay_out(case)
    count = particle_count(case.particles)
    full, rest = divmod(count, layout.columns * layout.rows)
    sites = np.empty((count, 3))
    layer, site = np.divmod(np.arange(count - rest), layout.columns * layout.rows)
    sites[: count - rest, 1], sites[: count - rest, 0] = np.divmod(site, layout.columns)
    sites[: count - rest, 2] = layer
    sites[count - rest :, 0], sites[count - rest :, 1] = _spread(rest, layout.columns, layout.rows)
    sites[count - rest :, 2] = full
    spacing = np.array(layout.spacing)
    diameters = np.array([kind.diameter for kind in list_kinds(case.particles)])[lattice_kinds(case)]
    reach = 0.5 * case.start.jitter * (spacing - diameters[:, None])
    shift = np.random.default_rng(case.start.seed).uniform(-1.0, 1.0, sites.shape)
    return (sites + 0.5) * spacing + shift * reach + find_start_box(case)[0]


def lattice_kinds(case: Case, folder: Path = Path()) -> np.ndarray:
    """Kind of each particle of the start, int (particles,), counted from 0: mixed at random, or one a layer."""
    assert case.particles is not None
    # A start that comes from a file has no lattice; its kinds, if it does not say them, are mixed at random.
    if case.start is not None and len(list_kinds(case.particles)) > 1:
        if case.domain.shape != "box":
            return _fill_region(case, folder)[1]
        if is_layered(case):
            layers = _list_layers(case, lay_out_kinds(case))
            return np.concatenate([np.full(layer.count, layer.kind) for layer in layers])
    return draw_kinds(case.particles, case.start.seed if case.start else 1)


def _fill_region(case: Case, folder: Path) -> tuple[np.ndarray, np.ndarray]:
    from fbcouple.case.bed.region_lattice import fill_region  # noqa: PLC0415  (loads numba)

    return fill_region(case, read_mesh(case, folder))


def _list_layers(case: Case, layouts: list[Layout]) -> list[Layer]:
    """All layers of a box, from the floor up; the checks hold their height against the box's."""
    assert case.particles is not None
    heights = np.array([layout.spacing[2] for layout in layouts])
    sites = [layout.columns * layout.rows for layout in layouts]
    return list(stack(count_kinds(case.particles), heights, lambda kind, floor: sites[kind], 0.0, math.inf))


def _place_layers(case: Case) -> np.ndarray:
    """Centres [m], (particles, 3), of a start with one kind a layer."""
    assert case.particles is not None and case.start is not None
    kinds, layouts = list_kinds(case.particles), lay_out_kinds(case)
    placed, reach = [], []
    for layer in _list_layers(case, layouts):
        layout = layouts[layer.kind]
        x, y = _spread(layer.count, layout.columns, layout.rows)
        width, depth, height = layout.spacing
        middle = np.full(layer.count, layer.floor + 0.5 * height)
        placed.append(np.stack([(x + 0.5) * width, (y + 0.5) * depth, middle], axis=1))
        gap = 0.5 * case.start.jitter * (np.array(layout.spacing) - kinds[layer.kind].diameter)
        reach.append(np.broadcast_to(gap, placed[-1].shape))
    sites = np.concatenate(placed)
    shift = np.random.default_rng(case.start.seed).uniform(-1.0, 1.0, sites.shape)
    return sites + shift * np.concatenate(reach) + find_start_box(case)[0]


def _spread(count: int, columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Choose `count` distinct sites of a layer evenly: equal steps along each row, shifted from row to row.

    The shift is the golden ratio's, so that a step that divides the row length does not line particles up.
    """
    row = (2 * np.arange(count) + 1) * rows // (2 * max(count, 1))
    _, first, which, in_row = np.unique(row, return_index=True, return_inverse=True, return_counts=True)
    rank = np.arange(count) - first[which]
    step = columns / in_row[which]
    return np.floor((rank + (row * GOLDEN) % 1.0) * step), row.astype(float)
