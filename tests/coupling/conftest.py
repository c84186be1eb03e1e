"""Patches, random particles, and hat functions: the trilinear weights written down a second way, without a stencil."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from fbcouple.coupling.box.halo import LocalGrid
from fbcouple.geometry.grid import Grid

Hats = Callable[[Grid, np.ndarray], np.ndarray]
Inside = Callable[[np.ndarray], np.ndarray]


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers, the same in every run."""
    return np.random.default_rng(20190151)


@pytest.fixture
def whole() -> Callable[..., LocalGrid]:
    """The local grid that covers a whole grid of cells (0.02, 0.03, 0.05) m: `whole((4, 3, 5))`."""

    def make(cells: tuple[int, int, int]) -> LocalGrid:
        size = tuple(n * edge for n, edge in zip(cells, (0.02, 0.03, 0.05), strict=True))
        return LocalGrid(Grid(cells, size), (0, 0, 0), cells)

    return make


@pytest.fixture
def inside() -> Inside:
    """View (x, y, z, c) of a local field's cells, without the extra upper layers."""
    return lambda field: field[:-1, :-1, :-1].transpose(2, 1, 0, 3)


@pytest.fixture
def hats() -> Hats:
    """Weights (particles, x, y, z) from hat functions max(0, 1 - |x - x_c|/dx), x kept between outermost centres."""

    def weigh(grid: Grid, positions: np.ndarray) -> np.ndarray:
        axes = []
        for axis in range(3):
            centres = grid.centres(axis)
            inner = np.clip(positions[:, axis], centres[0], centres[-1])
            axes.append(np.maximum(0.0, 1.0 - np.abs(inner[:, None] - centres) / grid.spacing[axis]))
        return np.einsum("pi,pj,pk->pijk", *axes)

    return weigh
