"""Error against run time: makes the members' runs, measures them, and says what each knob costs and brings."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fbcouple.case.cost.coefficients import SHIPPED
from fbcouple.case.cost.prediction import predict
from fbcouple.case.load import load_case
from fbcouple.case.problems import show, write_hint
from fbcouple.case.source import find_case
from fbcouple.errors import CaseError
from fbcouple.launcher.stop_signals import Requests
from fbcouple.results.reader import open_results
from fbcouple.study.measures import MEASURES, Error, Finished, check_measures, check_needs, find_error
from fbcouple.study.members import REFERENCE, Member, list_members
from fbcouple.study.pareto import find_excess, mark_pareto, tabulate_knobs
from fbcouple.study.runs import Ending, look_up_case, require_uninterrupted, run_case
from fbcouple.study.schema import Study
from fbcouple.study.side_by_side import run_side_by_side
from fbcouple.study.source import Source, format_settings

RUNS = "members"
COSTS = {"wall": "core_seconds", "cpu": "cpu_seconds"}
"""What a study takes for cost -> attribute of results.nc."""
UNKNOWN = "its standard error is not known"
Say = Callable[[str], None]


@dataclass(frozen=True)
class Done:
    """A member whose run has ended, its results if it came to its end, and its cost."""

    member: Member
    ending: Ending
    finished: Finished | None
    cost: float
    """Core-seconds a simulated second, nan if the run did not come to its end."""


def plan_members(study: Study, source: Source) -> list[Member]:
    """The members of the study. Raises: CaseError with all mistakes of measures, keys and cases."""
    problems = [f"{source.label}: {p}" for p in check_measures(study.measures, bool(study.reference))]
    try:
        members = list_members(study, source)
    except CaseError as error:
        raise CaseError([*problems, *error.problems]) from None
    if not problems and members:
        case = load_case(source.find_base(study.base), format_settings(members[0].settings))
        problems = [f"{source.label}: {problem}" for problem in check_needs(study.measures, case)]
    if problems:
        raise CaseError(problems)
    return members


def run_members(
    study: Study, source: Source, folder: Path, say: Say, only: Collection[str] | None = None, jobs: int = 1
) -> list[Done]:
    """Run every member that has not been run to its end in `folder` before, `jobs` at a time and the cheapest first;
    `say` is told of each.

    only: names of the members to run, of the others what has been run is taken; None: all.

    Raises: CaseError if the study is wrong, or has no such member; StoppedError if a signal interrupted it.
    """
    members, base = plan_members(study, source), source.find_base(study.base)
    for name in only or ():
        if all(member.name != name for member in members):
            hint = write_hint(name, [member.name for member in members], "`--dry` lists them")
            raise CaseError([f"{source.label}: {show(name)}: the study has no such member{hint}."])
    done = {}
    ordered = sorted(members, key=lambda member: _predict_cost(base, member))
    calls = [(base, m, folder / RUNS / m.name, study.wall_limit, only is None or m.name in only) for m in ordered]
    with Requests() as requests:
        endings = run_side_by_side(_run, calls, jobs, requests)
        for n, (member, ending) in enumerate(zip(ordered, endings, strict=True), 1):
            if ending is None:
                continue
            done[member.name] = _open(member, ending, folder / RUNS / member.name, study.cost)
            told = f"{ending.how} ({ending.seconds:.1f} s) {ending.text}".rstrip() if ending.seconds else ending.how
            say(f"{n}/{len(members)} {member.name}: {told}")
        require_uninterrupted(folder, requests, [one.ending for one in done.values()], len(members))
    return [done[member.name] for member in members]


def _predict_cost(base: str, member: Member) -> float:
    """Core-hours of a member by the costs that are shipped: what members are put in order by."""
    case = load_case(base, format_settings(member.settings))
    return predict(case, member.ranks, SHIPPED, find_case(base).parent).core_hours


def _run(base: str, member: Member, run: Path, wall_limit: float, wanted: bool, requests: Requests) -> Ending:
    if not wanted:
        return look_up_case(base, member.settings, run, member.ranks)
    return run_case(base, member.settings, run, member.ranks, wall_limit, requests)


def _open(member: Member, ending: Ending, run: Path, cost_of: str) -> Done:
    if ending.how != "complete":
        return Done(member, ending, None, math.nan)
    results = open_results(run)
    attributes, end = results.data.attrs, float(results.data["time"].values[-1])
    cost = float(attributes[COSTS[cost_of]]) / end if COSTS[cost_of] in attributes else math.nan
    return Done(member, ending, Finished(results, load_case(str(run))), cost)


def tabulate(study: Study, done: list[Done]) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """A row for each measure and member, and a row for each measure, knob and set of members along it."""
    reference = next((d.finished for d in done if d.member.name == REFERENCE), None)
    rows: list[dict[str, Any]] = []
    knobs: list[dict[str, Any]] = []
    for text in study.measures:
        is_relative = MEASURES[text.partition(":")[0]].needs_reference
        found = [_measure(text, d, reference) for d in done]
        kept = [n for n, d in enumerate(done) if d.member.name != REFERENCE]
        costs = [done[n].cost for n in kept]
        errors = [error.error if (error := found[n][0]) else math.nan for n in kept]
        bars = [0.0 if (error := found[n][0]) is None or error.stderr is None else error.stderr for n in kept]
        front = dict(zip(kept, mark_pareto(costs, errors), strict=True))
        excess = dict(zip(kept, find_excess(costs, errors, bars), strict=True))
        for n, d in enumerate(done):
            if not (d.member.name == REFERENCE and is_relative):
                rows.append(_make_row(text, d, *found[n], front.get(n, False), excess.get(n, math.nan)))
        knobs += [{"measure": text} | row for row in tabulate_knobs([done[n].member for n in kept], costs, errors)]
    return rows, knobs


def _measure(text: str, done: Done, reference: Finished | None) -> tuple[Error | None, str]:
    """The error of a member, or why there is none; and what is not known of one."""
    if done.finished is None:
        return None, done.ending.text
    if MEASURES[text.partition(":")[0]].needs_reference and reference is None:
        return None, "the reference did not come to its end"
    try:
        found = find_error(text, done.finished, reference)
    except CaseError as error:
        return None, str(error)
    if not math.isfinite(found.error):
        return None, "what it is measured by is no number in these results"
    is_unknown = found.stderr is not None and math.isnan(found.stderr)
    return found, UNKNOWN if is_unknown else ""


def _make_row(text: str, done: Done, error: Error | None, why: str, pareto: bool, excess: float) -> dict[str, Any]:
    row: dict[str, Any] = {"measure": text, "member": done.member.name, "how": done.ending.how}
    row |= {key: str(value) if isinstance(value, tuple) else value for key, value in done.member.knobs.items()}
    row |= {
        "error": error.error if error else None,
        "stderr": error.stderr if error else None,
        "value": error.value if error else None,
        "expected": error.expected if error else None,
        "unit": error.unit if error else None,
        "core_seconds_per_second": done.cost if math.isfinite(done.cost) else None,
        "wall_seconds": done.ending.seconds,
        "pareto": pareto,
        "over_cheapest": excess if math.isfinite(excess) else None,
    }
    return row | {"why": why}
