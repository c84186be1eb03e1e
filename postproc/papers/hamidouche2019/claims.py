"""The claims of the paper judged on runs: what was measured, and whether each holds.

No claim is told to hold, or not to, without the runs that it speaks of and beyond their statistical errors.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fbcouple.postproc.papers.hamidouche2019 import friction_statements, mesh_statements
from fbcouple.postproc.papers.hamidouche2019.judging import Finding, Runs
from fbcouple.postproc.papers.hamidouche2019.paper_beds import AS_COMPUTED, AS_PRINTED, list_numerics
from fbcouple.postproc.papers.hamidouche2019.paper_runs import sort_runs
from fbcouple.postproc.papers.hamidouche2019.registry import CLAIMS
from fbcouple.results.reader import NotDrawableError, Results, open_results

YES, NO, UNDECIDED = "yes", "no", "cannot be told from these runs"
STATED = "as stated"
"""A row's beds: those that the claim speaks of."""
STATEMENTS = (friction_statements, mesh_statements)
"""Modules that register the claims."""


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    name: str
    statement: str
    place: str
    numerics: str
    beds: str
    """`STATED`, or which others the claim is judged on here."""
    runs: str
    measured: str
    wanted: str
    reason: str
    """Why the margin is what it is."""
    verdict: str
    why: str


def judge_claims(runs: Iterable[Results]) -> list[Row]:
    """Judge every claim on `runs`: a row a claim; one more for each that other beds, or runs with e = 1, decide too."""
    by_numerics, left_out = sort_runs(runs)
    rows = []
    for name, stated in CLAIMS.items():
        rows.append(_judge(name, AS_PRINTED, by_numerics[AS_PRINTED], left_out))
        more = [(AS_PRINTED, others) for others in stated.also]
        more += [(AS_COMPUTED, beds) for beds in (stated.needs, *stated.also) if beds]
        rows += [
            _judge(name, numerics, by_numerics[numerics], left_out, beds)
            for numerics, beds in more
            if len({str(by_numerics[numerics][bed].path) for bed in beds if bed in by_numerics[numerics]}) == len(beds)
        ]
    return rows


def tabulate_claims(folders: Iterable[Path]) -> list[dict[str, Any]]:
    """The rows of `judge_claims` for run folders, as dicts.

    Raises: CaseError if a folder has no results with time means.
    """
    return [asdict(row) for row in judge_claims(open_results(folder) for folder in folders)]


def _format_run(need: str, runs: Runs) -> str:
    """The name of a bed of the paper, with what the run of it does not take from the paper."""
    differences = list_numerics(runs[need].case)
    return f"{need} ({', '.join(differences)})" if differences else need


def _judge(name: str, numerics: str, runs: Runs, left_out: dict[str, str], beds: tuple[str, ...] = ()) -> Row:
    """Judge a claim on the runs that it needs, or on those of the `beds`, one for one in place of them."""
    stated = CLAIMS[name]
    asked = beds or stated.needs
    given = [bed for bed in asked if bed in runs or bed in left_out]
    used = ", ".join(_format_run(bed, runs) if bed in runs else f"{bed} (left out)" for bed in given)
    missing = [bed for bed in asked if bed not in runs]
    if missing:
        short = "; ".join(left_out[bed] for bed in missing if bed in left_out)
        finding = Finding("", None, f"no run of {', '.join(missing)}" + (f" ({short})" if short else ""))
    else:
        try:
            finding = stated.judge({need: runs[bed] for need, bed in zip(stated.needs, asked, strict=True)})
        except NotDrawableError as lack:
            finding = Finding("", None, str(lack))
    verdict = UNDECIDED if finding.holds is None else YES if finding.holds else NO
    return Row(
        name,
        stated.statement,
        stated.place,
        numerics,
        STATED if asked == stated.needs else ", ".join(asked),
        used,
        finding.measured,
        stated.wanted,
        stated.reason,
        verdict,
        finding.why,
    )
