"""The filter of what is exchanged: eqs 33 and 34 of the paper to rounding."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.exchange.filter import filtered
from fbcouple.exchange.plan import Patch
from fbcouple.grid import Grid
from fbcouple.verify.registry import Number, scene

_CELLS = (24, 20, 22)
_PASSES = 3
_EXACT = 1e-12


def _smooth(patch: Patch, values: np.ndarray) -> np.ndarray:
    """Cells (z, y, x) after `_PASSES` passes."""
    field = patch.make_field(1)
    field[:-1, :-1, :-1, 0] = values
    return filtered(field, _PASSES, np.zeros_like(field))[:-1, :-1, :-1, 0]


@scene("filter")
def smoothing(place: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Three passes: a constant stays, a total next to walls stays, the variance grows by half a cell squared a pass."""
    patch = Patch(Grid(_CELLS, (0.024, 0.04, 0.066)), (0, 0, 0), _CELLS)
    shape = _CELLS[::-1]
    yield Number("constant, largest deviation", float(np.abs(_smooth(patch, np.ones(shape)) - 1.0).max()), 0.0, _EXACT)
    corner = np.zeros(shape)
    corner[0, 0, 0] = corner[-1, -1, -1] = corner[0, 7, -1] = 1.0
    yield Number("total of three cells at walls", float(_smooth(patch, corner).sum()), 3.0, _EXACT)
    middle = np.zeros(shape)
    centre = tuple(n // 2 for n in shape)
    middle[centre] = 1.0
    spread = _smooth(patch, middle)
    for axis, name in enumerate("zyx"):
        steps = (np.arange(shape[axis]) - centre[axis]) ** 2
        along = spread.sum(axis=tuple(other for other in range(3) if other != axis))
        yield Number(f"variance along {name}, cells squared", float(along @ steps), 0.5 * _PASSES, _EXACT)
