"""How a region is cut into the parts of the ranks, the same for both solvers: columns of full height.

A bed is as deep everywhere, or nearly: a cut along z would leave ranks without particles.
"""

from __future__ import annotations

from collections.abc import Sequence


def find_rank_grid(size: Sequence[float], ranks: int) -> tuple[int, int]:
    """Ranks along x and y of a region of `size` (3,) [m]: the columns of least surface, as LIGGGHTS chooses them.

    Its rule (`processors * * 1`) is the first of the pairs, fewest along x first, with the least area of a column.
    """
    width, depth, height = size
    best, least = (1, ranks), float("inf")
    for nx in (n for n in range(1, ranks + 1) if ranks % n == 0):
        ny = ranks // nx
        surface = width * depth / nx / ny + width * height / nx + depth * height / ny
        if surface < least:
            best, least = (nx, ny), surface
    return best


def locate_rank(rank: int, grid: tuple[int, int]) -> tuple[int, int]:
    """Place of a rank's column along x and y: ranks go on along y first."""
    return divmod(rank, grid[1])
