"""Which simulation of Hamidouche et al. 2019 a run is: told by its effective case, never by its name."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations
from typing import Any

from fbcouple.postproc.averaging import find_inlet_change_in_means, find_start_up_in_means
from fbcouple.postproc.papers.hamidouche2019.paper_beds import (
    AS_COMPUTED,
    AS_PRINTED,
    BEDS,
    SUB_GRID_MODELS,
    identify_case,
    list_strangers,
    look_up,
    name_nearest,
)
from fbcouple.postproc.papers.hamidouche2019.paper_numerics import list_numerics
from fbcouple.results.reader import Results
from fbcouple.results.told import list_told

SHORTEST_WINDOW = 5.0
"""Averaging [s] below which a run decides nothing."""
_MOST_STRANGERS = 3
"""Options that are named where a run is left out for them."""


def identify(results: Results) -> tuple[str, list[str]]:
    """Tell which contacts (`AS_PRINTED`, `AS_COMPUTED`) and which rows of `BEDS` a run is; no row if it is none, or if
    its inlet was changed within its time means."""
    return ("", []) if find_inlet_change_in_means(results) else identify_case(results.case)


def explain_strange(results: Results) -> tuple[list[str], str]:
    """The rows of `BEDS` that a run would be but for something, and what that is; no rows if it is near none."""
    strangers = list_strangers(results.case)
    if mark := find_inlet_change_in_means(results):
        strangers.insert(0, mark.brief)
    if not strangers:
        return [], ""
    more = len(strangers) - _MOST_STRANGERS
    told = ", ".join(strangers[:_MOST_STRANGERS]) + (f" and {more} more" if more > 0 else "")
    return name_nearest(results.case)[1], f"not the paper's bed: {told}"


def averaged_time(results: Results) -> float:
    """Averaged time [s] that the run got through, of all replicas together; 0 if it has not begun."""
    return results.averaged


def explain_short(results: Results) -> str:
    """Why a run decides nothing that averaged too short."""
    return f"averaged {averaged_time(results):.3g} s, needed {SHORTEST_WINDOW:g} s"


def sort_runs(runs: Iterable[Results]) -> tuple[dict[str, dict[str, Results]], dict[str, str]]:
    """Sort runs by contacts and name of `BEDS`. Of two runs of one bed that with the paper's sub-grid model counts, of
    two that have it, or have not, the one whose means do not begin in its start-up, and of two such, or two others,
    the one that averaged longer; the other is the twin, if the bed has two names and the seeds are others.

    Returns: contacts -> name -> run, and for each name why a run of it was left out: it averaged too short, or is of
    the bed but for an option.
    """
    found: dict[str, dict[str, list[Results]]] = {AS_PRINTED: {}, AS_COMPUTED: {}}
    left_out: dict[str, str] = {}
    for run in runs:
        which = run.label or run.path.parent.name
        contacts, names = identify(run)
        near, why = explain_strange(run)
        for name in near:
            left_out.setdefault(name, f"{which} is {why}")
        for name in names:
            if averaged_time(run) < SHORTEST_WINDOW:
                left_out[name] = f"{which} {explain_short(run)}"
            else:
                found[contacts].setdefault(name, []).append(run)
    chosen = {
        contacts: {name: _choose(name, known) for name, known in names.items()} for contacts, names in found.items()
    }
    return chosen, left_out


def _choose(name: str, runs: list[Results]) -> Results:
    """Of the `runs` of a bed the one that counts for it under `name`."""
    best, *others = sorted(runs, key=rank, reverse=True)
    place = [other for other, bed in BEDS.items() if bed == BEDS[name]].index(name)
    twins = [best, *(run for run in others if not _list_seeds(run) & _list_seeds(best))]
    return twins[place] if len(twins) > place and rank(twins[place])[:2] == rank(best)[:2] else best


def list_twins(runs: Iterable[Results]) -> list[tuple[str, Results, Results]]:
    """Pairs of runs of one bed and of the same numerics from different seeds, that averaged long enough: its first
    name, and both. Of replicas none has a seed of the other's."""
    beds: dict[tuple[str, str], list[Results]] = {}
    for run in runs:
        contacts, names = identify(run)
        if names and averaged_time(run) >= SHORTEST_WINDOW:
            beds.setdefault((contacts, names[0]), []).append(run)
    return [
        (name, one, other)
        for (_, name), known in beds.items()
        for one, other in combinations(sorted(known, key=rank, reverse=True), 2)
        if not _list_seeds(one) & _list_seeds(other) and list_numerics(one.case) == list_numerics(other.case)
    ]


def _list_seeds(run: Results) -> set[Any]:
    """Seeds of the start of a run, or of all replicas in it."""
    told = [one["seeds"].get("start.seed") for one in list_told(run.data) if "seeds" in one]
    return {look_up(run.case, "start.seed"), *told}


def rank(run: Results) -> tuple[bool, bool, float]:
    """What makes one of two runs of a bed count: the paper's sub-grid model, or none; means that are not marked as
    beginning in the start-up; averaged time [s]."""
    has_model = look_up(run.case, "gas.turbulence") not in SUB_GRID_MODELS[1:]
    return has_model, find_start_up_in_means(run) is None, averaged_time(run)
