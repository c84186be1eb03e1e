"""The claims of the paper judged on runs: what was measured, and whether each holds.

No claim is told to hold, or not to, without the runs that it speaks of and beyond their statistical errors.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fbcouple.postproc.papers.hamidouche2019.paper_runs import AS_COMPUTED, AS_PRINTED, name_differences, sort_runs
from fbcouple.postproc.papers.hamidouche2019.statements import CLAIMS, Finding, Runs
from fbcouple.results.reader import NotDrawableError, Results, open_results

YES, NO, UNDECIDED = "yes", "no", "cannot be told from these runs"


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    name: str
    statement: str
    place: str
    numerics: str
    runs: str
    measured: str
    wanted: str
    verdict: str
    why: str


def judge_claims(runs: Iterable[Results]) -> list[Row]:
    """Judge every claim on `runs`: a row a claim, and one more for each that runs with e = 1 decide as well."""
    by_numerics, left_out = sort_runs(runs)
    rows = [_judge(name, AS_PRINTED, by_numerics[AS_PRINTED], left_out) for name in CLAIMS]
    if by_numerics[AS_COMPUTED]:
        more = [_judge(name, AS_COMPUTED, by_numerics[AS_COMPUTED], left_out) for name in CLAIMS]
        rows += [row for row in more if row.measured]
    return rows


def tabulate_claims(folders: Iterable[Path]) -> list[dict[str, Any]]:
    """The rows of `judge_claims` for run folders, as dicts.

    Raises: CaseError if a folder has no results with time means.
    """
    return [asdict(row) for row in judge_claims(open_results(folder) for folder in folders)]


def _format_run(need: str, runs: Runs) -> str:
    """The name of a bed of the paper, with what the run of it does not take from the paper."""
    differences = name_differences(runs[need])
    return f"{need} ({', '.join(differences)})" if differences else need


def _judge(name: str, numerics: str, runs: Runs, left_out: dict[str, str]) -> Row:
    stated = CLAIMS[name]
    given = [need for need in stated.needs if need in runs or need in left_out]
    used = ", ".join(_format_run(need, runs) if need in runs else f"{need} (left out)" for need in given)
    missing = [need for need in stated.needs if need not in runs]
    if not stated.needs:
        finding = stated.judge(runs)
    elif missing:
        short = "; ".join(left_out[need] for need in missing if need in left_out)
        finding = Finding("", None, f"no run of {', '.join(missing)}" + (f" ({short})" if short else ""))
    else:
        try:
            finding = stated.judge(runs)
        except NotDrawableError as lack:
            finding = Finding("", None, str(lack))
    verdict = UNDECIDED if finding.holds is None else YES if finding.holds else NO
    row = (stated.statement, stated.place, numerics, used, finding.measured, stated.wanted, verdict, finding.why)
    return Row(name, *row)
