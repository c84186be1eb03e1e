"""What `fbcouple claims` tells of runs: the claims judged on them, and what has to be known of the runs beside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fbcouple.postproc.averaging import list_warnings
from fbcouple.postproc.papers.hamidouche2019.claims import Row, judge_claims
from fbcouple.postproc.papers.hamidouche2019.paper_numerics import tell_numerics
from fbcouple.postproc.papers.hamidouche2019.registry import CLAIMS
from fbcouple.postproc.papers.hamidouche2019.run_uses import list_uses, tell_choices, tell_idle
from fbcouple.results.reader import open_runs


@dataclass(frozen=True)
class Told:
    """The rows of the table; whether a run is of the paper, be it not used; a sentence on numerics that are not the
    paper's, if a run has such; on each run in whose place another of its bed counts; on each other run that is not used
    or that no claim speaks of; and on means that begin in a start-up."""

    rows: list[Row]
    has_beds: bool
    numerics: str
    choices: list[str]
    idle: list[str]
    warnings: list[str]

    @property
    def shown(self) -> list[Row]:
        """Rows on beds that there are runs of, and, if there are any, those that no run decides."""
        is_spoken = any(row.runs for row in self.rows)
        return [row for row in self.rows if row.runs or (is_spoken and not CLAIMS[row.name].needs)]

    def tell_rest(self) -> list[str]:
        """Sentences on the rows that are not shown, and why they cannot be told."""
        rest = [row for row in self.rows if row not in self.shown]
        on_beds = [row for row in rest if CLAIMS[row.name].needs]
        others = [f"{row.statement} ({row.place}) {row.why}." for row in rest if row not in on_beds]
        what = "that are not among these runs" if self.has_beds else "of the paper (patil/...), and no run here is one"
        lead = f"{len(on_beds)} of {len(self.rows)} statements cannot be told: they speak of beds {what}."
        return [lead, *others] if on_beds else others


def tell_claims(paths: Sequence[Path]) -> Told:
    """Judge the claims on runs: run folders, folders of replicas, or files of means.

    Raises: CaseError if one has no results.
    """
    runs = open_runs(paths)
    uses = list_uses(runs)
    has_beds = any(use.beds for use in uses)
    lines = tell_choices(uses), tell_idle(uses), list_warnings(runs)
    return Told(judge_claims(runs), has_beds, tell_numerics(runs), *lines)
