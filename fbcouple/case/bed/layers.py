"""Layers of like particles: the start of a mixture whose smallest would be lost on a lattice of its largest.

A layer holds one kind, on a square lattice of its own spacing. The kind of each next layer is the one of which most is
left, as a part of its number, so that the kinds lie in thin layers between each other from the floor to the top.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Layer:
    """Particles of the kind `kind` in a layer from `floor` [m] up."""

    kind: int
    count: int
    floor: float


def stack(
    counts: list[int], heights: np.ndarray, count_sites: Callable[[int, float], int], low: float, high: float
) -> Iterator[Layer]:
    """Layers that take `counts` particles of each kind, from `low` [m] up; they end at `high` or with the particles.

    heights: of a layer of each kind [m]; count_sites: sites of a layer of a kind whose floor is at a height [m].
    """
    left, floor = np.array(counts), low
    sizes = np.lexsort((np.arange(len(counts)), -heights))  # of equal parts the largest first
    while left.any() and floor + heights[left > 0].min() <= high:
        parts = (left / np.maximum(counts, 1))[sizes]
        wanted = [int(kind) for kind in sizes[np.argsort(-parts, kind="stable")] if left[kind]]
        fitting = [kind for kind in wanted if floor + heights[kind] <= high]
        placed = ((kind, count) for kind in fitting if (count := min(int(left[kind]), count_sites(kind, floor))))
        kind, count = next(placed, (-1, 0))
        if count:
            yield Layer(kind, count, floor)
            left[kind] -= count
        floor += heights[kind] if count else heights.min()
