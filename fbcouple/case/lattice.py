"""Start positions of the particles: a jittered simple cubic lattice that fills the floor layer by layer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fbcouple.case.mixture import draw_kinds, largest_diameter, list_kinds, particle_count
from fbcouple.case.region import read_mesh
from fbcouple.case.schema import Case

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True)
class Layout:
    """Sites along x and y, layers along z, and the distance of neighbouring sites [m] along each axis."""

    columns: int
    rows: int
    layers: int
    spacing: tuple[float, float, float]


def lay_out(case: Case) -> Layout:
    """Stretch the wanted spacing along x and y until the sites fill the floor, and count the layers.

    It is a multiple of the largest diameter, so that each site takes any kind.

    A box narrower than the wanted spacing along x or y (but not than a particle) takes one site in its middle.
    """
    assert case.particles is not None and case.start is not None, "checks ask for [particles] and [start]"
    width, depth, _ = case.domain.size
    wanted = case.start.spacing * largest_diameter(case.particles)
    columns = max(1, math.floor(width / wanted))
    rows = max(1, math.floor(depth / wanted))
    layers = -(-particle_count(case.particles) // (columns * rows))
    return Layout(columns, rows, layers, (width / columns, depth / rows, wanted))


def lattice_height(case: Case) -> float:
    """Height [m] that the start lattice takes up, from the floor to half a spacing above the last layer's centres."""
    layout = lay_out(case)
    return layout.layers * layout.spacing[2]


def lattice_positions(case: Case, folder: Path = Path()) -> np.ndarray:
    """Place the particles of a case, whose own files lie in `folder`, on its start lattice.

    Each coordinate is shifted by up to half of `start.jitter` times the free gap along that axis, so no two
    particles touch and none touches a wall. A last layer that is not full is spread over the whole floor.

    Returns: centres [m], shape (particles, 3), layer by layer from the floor.
    """
    if case.domain.shape != "box":
        from fbcouple.case.region_lattice import fill_region  # noqa: PLC0415  (loads numba)

        return fill_region(case, read_mesh(case, folder))
    layout = lay_out(case)
    assert case.particles is not None and case.start is not None
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
    return (sites + 0.5) * spacing + shift * reach


def lattice_kinds(case: Case) -> np.ndarray:
    """Kind of each particle of the start lattice, int (particles,), counted from 0: mixed at random."""
    assert case.particles is not None
    return draw_kinds(case.particles, case.start.seed if case.start else 1)


def _spread(count: int, columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Choose `count` distinct sites of a layer evenly: equal steps along each row, shifted from row to row.

    The shift is the golden ratio's, so that a step that divides the row length does not line particles up.
    """
    row = (2 * np.arange(count) + 1) * rows // (2 * max(count, 1))
    _, first, which, in_row = np.unique(row, return_index=True, return_inverse=True, return_counts=True)
    rank = np.arange(count) - first[which]
    step = columns / in_row[which]
    return np.floor((rank + (row * GOLDEN) % 1.0) * step), row.astype(float)
