"""The claims of the paper judged on runs: what was measured, and whether each holds.

No claim is told to hold, or not to, without the runs that it speaks of and beyond their statistical errors.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from fbcouple.postproc.papers.hamidouche2019 import friction_statements, mesh_statements
from fbcouple.postproc.papers.hamidouche2019.judging import Finding, Runs
from fbcouple.postproc.papers.hamidouche2019.paper_beds import AS_COMPUTED, AS_PRINTED
from fbcouple.postproc.papers.hamidouche2019.paper_numerics import list_numerics, tell_briefly
from fbcouple.postproc.papers.hamidouche2019.paper_runs import sort_runs
from fbcouple.postproc.papers.hamidouche2019.registry import CLAIMS
from fbcouple.results.reader import NotDrawableError, Results

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
    contacts: str
    """`AS_PRINTED` or `AS_COMPUTED`."""
    numerics: str
    """The contacts, and what else of the numerics of the runs is not the paper's."""
    beds: str
    """`STATED`, or which others the claim is judged on here."""
    runs: str
    """Names of the beds that there are runs of, each with what is not the paper's."""
    measured: str
    wanted: str
    reason: str
    """Why the margin is what it is."""
    verdict: str
    why: str


def judge_claims(runs: Iterable[Results]) -> list[Row]:
    """Judge every claim on `runs`: a row a claim; one more for each that other beds, or runs with e = 1, decide too."""
    by_contacts, left_out = sort_runs(runs)
    rows = []
    for name, stated in CLAIMS.items():
        rows.append(_judge(name, AS_PRINTED, by_contacts[AS_PRINTED], left_out))
        more = [(AS_PRINTED, others) for others in stated.also]
        more += [(AS_COMPUTED, beds) for beds in (stated.needs, *stated.also) if beds]
        rows += [
            _judge(name, contacts, by_contacts[contacts], left_out, beds)
            for contacts, beds in more
            if len({str(by_contacts[contacts][bed].path) for bed in beds if bed in by_contacts[contacts]}) == len(beds)
        ]
    return rows


def _format_run(need: str, runs: Runs) -> str:
    """The name of a bed of the paper, with what the run of it does not take from the paper."""
    differences = list_numerics(runs[need].case)
    return f"{need} ({', '.join(differences)})" if differences else need


def _judge(name: str, contacts: str, runs: Runs, left_out: dict[str, str], beds: tuple[str, ...] = ()) -> Row:
    """Judge a claim on the runs that it needs, or on those of the `beds`, one for one in place of them."""
    stated = CLAIMS[name]
    asked = beds or stated.needs
    given = [bed for bed in asked if bed in runs or bed in left_out]
    used = ", ".join(_format_run(bed, runs) if bed in runs else f"{bed} (left out)" for bed in given)
    known = [runs[bed] for bed in given if bed in runs]
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
        contacts,
        "; ".join(filter(None, [contacts, tell_briefly(list({str(run.path): run for run in known}.values()))])),
        STATED if asked == stated.needs else ", ".join(asked),
        used,
        finding.measured,
        stated.wanted,
        stated.reason,
        verdict,
        finding.why,
    )
