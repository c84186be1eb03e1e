"""Triangles of a floor drawn up into prisms, layer on layer, and prisms cut into tetrahedra."""

from __future__ import annotations

import numpy as np

from fbcouple.geometry.numbering import build_mesh
from fbcouple.geometry.polymesh import PolyMesh

PATCHES = ("inlet", "outlet", "walls")
PER_PRISM = {"prisms": 1, "tetrahedra": 3}
"""Cells that a prism makes, by the word of domain.elements."""
_SEED = 1


def extrude(flat: np.ndarray, triangles: np.ndarray, height: float, layers: int, elements: str) -> PolyMesh:
    """`layers` of prisms up to `height` [m] over the `triangles` (m, 3), anticlockwise, of the points `flat` (n, 2)
    [m], or three tetrahedra of the same volume from each prism; with the patches inlet (floor), outlet (top), walls."""
    heights = np.linspace(0.0, height, layers + 1)
    points = np.column_stack([np.tile(flat, (layers + 1, 1)), np.repeat(heights, len(flat))])
    step = len(flat)
    lifted = np.arange(layers)[:, None, None] * step
    if elements == "prisms":
        corners = np.concatenate([triangles, triangles + step], axis=1)
        shapes = [("wedge", (lifted + corners).reshape(-1, 6))]
    else:
        shapes = [("tetra", (lifted + _split(triangles, step).reshape(-1, 4)).reshape(-1, 4))]

    def name(rows: np.ndarray) -> np.ndarray:
        layer = np.where(rows < 0, rows[:, :1], rows) // step
        flat_side = np.all(layer == layer[:, :1], axis=1)
        return np.where(flat_side & (layer[:, 0] == 0), 0, np.where(flat_side & (layer[:, 0] == layers), 1, 2))

    return build_mesh(points, shapes, PATCHES, name)


def _split(triangles: np.ndarray, step: int) -> np.ndarray:
    """Three tetrahedra of each prism (m, 3, 4) whose cuts across the sides are those of the prisms beside it.

    A side is cut from the lower of its points in a fixed random order, at the bottom, to the other one at the top; an
    order from the centre outwards would lean all cuts to one side.
    """
    rank = np.random.default_rng(_SEED).permutation(int(triangles.max()) + 1)
    a, b, c = np.take_along_axis(triangles, np.argsort(rank[triangles], axis=1), axis=1).T
    cut = np.stack([[a, b, c, c + step], [a, b, b + step, c + step], [a, a + step, b + step, c + step]])
    return cut.transpose(2, 0, 1)
