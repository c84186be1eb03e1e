"""The registry of the claims: each with the runs it speaks of, its margin, fixed before the runs, and its judge."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fbcouple.postproc.measures import Measured
from fbcouple.postproc.papers.hamidouche2019.judging import Judge, Runs
from fbcouple.results.reader import Results


@dataclass(frozen=True)
class Claim:
    """A statement, where the paper makes it, the runs it speaks of, the judge, and what is wanted of the number.

    reason: why the margin is what it is; also: runs in place of `needs`, one for one, with which it is judged as well;
    is_ours: the paper did not try it.
    """

    statement: str
    place: str
    needs: tuple[str, ...]
    wanted: str
    reason: str
    also: tuple[tuple[str, ...], ...]
    judge: Judge
    is_ours: bool = False


CLAIMS: dict[str, Claim] = {}
DIRECTION = "a direction is claimed and no size: beyond chance is enough"
"""Why a claim has no other margin than 0."""


def claim(
    name: str,
    statement: str,
    place: str,
    needs: tuple[str, ...],
    wanted: str,
    reason: str = DIRECTION,
    also: tuple[tuple[str, ...], ...] = (),
    is_ours: bool = False,
) -> Callable[[Judge], Judge]:
    """Register `judge(runs) -> Finding` under `name`; it is called only if every run of `needs` is there."""

    def register(judge: Judge) -> Judge:
        CLAIMS[name] = Claim(statement, place, needs, wanted, reason, also, judge, is_ours)
        return judge

    return register


def measure_runs(runs: Runs, names: tuple[str, ...], measure: Callable[[Results], Measured]) -> dict[str, Measured]:
    """Name -> what `measure` gives of the run."""
    return {name: measure(runs[name]) for name in names}
