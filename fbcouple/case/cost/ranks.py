"""How many ranks a run is worth: doubled as long as that makes it enough faster."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fbcouple.case.cost.coefficients import Coefficients
from fbcouple.case.cost.prediction import DOUBLING, Prediction, time_stages
from fbcouple.case.cost.work import share_ghosts
from fbcouple.case.schema.sections import Case

WORTH = 0.7
"""Efficiency that a doubling of the ranks must have: the wall time before it over twice that after it."""
FEW_CELLS, FEW_PARTICLES = 500, 3000
"""Share of a rank below which messages and waiting, which the prediction does not have, take longer than another rank
saves."""
SHARE = 2.0
"""Factor of that share: nothing here was measured on more ranks than two."""
_MOST = 4096


@dataclass(frozen=True)
class Proposal:
    """`ranks`, and the `least` and `most` that the same rule gives within what is unsure of it.

    walls: predicted wall time [s] by ranks, up to twice those proposed; limit: ranks that have work enough for each.
    """

    ranks: int
    least: int
    most: int
    walls: Mapping[int, float]
    limit: int

    @property
    def gain(self) -> float:
        """How many times as fast twice the ranks are predicted to be."""
        return self.walls[self.ranks] / self.walls[2 * self.ranks]


def propose_ranks(case: Case, found: Coefficients, predicted: Prediction) -> Proposal:
    """Propose ranks for the run of `case` that `predicted` is of, on any number of them, with what a step costs.

    From one rank on they are doubled as long as a doubling has the efficiency WORTH and leaves each rank a share of
    cells or of particles to work on. An efficiency is taken to be right within the factor of a doubling,
    DOUBLING, and the share within SHARE.
    """
    work, walls = predicted.work, {}
    limit, ranks = count_worked(work.cells, int(work.particles)), 1
    while ranks <= _MOST:
        stages = time_stages(work, found, ranks, share_ghosts(case, ranks))
        walls[ranks] = predicted.stages["start-up"] + sum(stages.values())
        ranks *= 2
    proposed = _double(walls, limit, WORTH)
    least = _double(walls, limit / SHARE, WORTH * DOUBLING)
    most = _double(walls, limit * SHARE, WORTH / DOUBLING)
    kept = {count: wall for count, wall in walls.items() if count <= 2 * proposed}
    return Proposal(proposed, least, most, kept, limit)


def count_worked(cells: int, particles: int) -> int:
    """Ranks that have enough of `cells` or of `particles` each, 1 at least."""
    return max(cells // FEW_CELLS, particles // FEW_PARTICLES, 1)


def _double(walls: Mapping[int, float], limit: float, worth: float) -> int:
    ranks = 1
    while 2 * ranks <= min(limit, _MOST // 2) and walls[ranks] / (2.0 * walls[2 * ranks]) >= worth:
        ranks *= 2
    return ranks
