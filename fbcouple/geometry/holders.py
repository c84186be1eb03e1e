"""Which cell holds a point, the same whichever ranks the cells are on."""

from __future__ import annotations

import numpy as np

from fbcouple.geometry.polyhedra import Polyhedra
from fbcouple.geometry.tetrahedra import cut

NOWHERE = -1
ROUNDING = 1e-9
"""How far outside of its cell a point may be by rounding: of a coordinate of a tetrahedron, or of the mesh's size."""


def find_holders(cells: Polyhedra, points: np.ndarray) -> np.ndarray:
    """Numbers in the whole mesh, (n,), of the cells that hold `points` (n, 3) [m], NOWHERE where none does.

    Of the cells that meet at a point it is the one with the highest number: of those of all ranks the highest one is
    the same for every partition of the mesh.
    """
    found = np.full(len(points), NOWHERE, np.int64)
    if not len(cells):
        return found
    low, high = cells.find_bounds()
    room = ROUNDING * float(np.ptp(cells.points, axis=0).max())
    for row, point in enumerate(points):
        near = np.flatnonzero(np.all((low - room <= point) & (point <= high + room), axis=1))
        if len(near):
            holding = near[_hold(cells.select(near), point)]
            found[row] = cells.ids[holding].max(initial=NOWHERE)
    return found


def _hold(cells: Polyhedra, point: np.ndarray) -> np.ndarray:
    """Rows of the `cells` that hold `point` (3,) [m]."""
    parts = cut(cells)
    origin, *others = parts.nodes[parts.corners].transpose(1, 0, 2)
    edges = np.stack([corner - origin for corner in others], axis=2)
    weights = np.linalg.solve(edges, (point - origin)[:, :, None])[:, :, 0]
    inside = (weights.min(axis=1) >= -ROUNDING) & (weights.sum(axis=1) <= 1.0 + ROUNDING)
    return np.unique(parts.owners[inside])
