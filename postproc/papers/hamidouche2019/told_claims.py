"""What `fbcouple claims` tells of runs: the claims judged on them, and what has to be known of the runs beside."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from fbcouple.postproc.papers.hamidouche2019.claims import Row, judge_claims
from fbcouple.postproc.papers.hamidouche2019.paper_numerics import tell_numerics
from fbcouple.results.reader import open_results


@dataclass(frozen=True)
class Told:
    """The rows of the table, and a sentence on numerics that are not the paper's, if a run has such."""

    rows: list[Row]
    numerics: str

    @property
    def spoken(self) -> list[Row]:
        """Rows on beds that there are runs of."""
        return [row for row in self.rows if row.runs]


def tell_claims(paths: Iterable[Path]) -> Told:
    """Judge the claims on runs: run folders, folders of replicas, or files of means.

    Raises: CaseError if one has no results.
    """
    runs = [open_results(path) for path in paths]
    return Told(judge_claims(runs), tell_numerics(runs))
