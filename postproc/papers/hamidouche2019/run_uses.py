"""What each run is used for: the beds that it counts for, or why it counts for none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fbcouple.postproc.averaging import find_start_up_in_means
from fbcouple.postproc.papers.hamidouche2019.paper_beds import AS_PRINTED, look_up
from fbcouple.postproc.papers.hamidouche2019.paper_runs import (
    SHORTEST_WINDOW,
    averaged_time,
    explain_short,
    explain_strange,
    identify,
    rank,
    sort_runs,
)
from fbcouple.postproc.papers.hamidouche2019.registry import CLAIMS
from fbcouple.results.reader import Results


@dataclass(frozen=True)
class Use:
    """A run, the beds that it is of, those that it counts for, and if none why; rival: the run that counts instead."""

    run: Results
    beds: tuple[str, ...]
    counts_for: tuple[str, ...]
    why_not: str = ""
    rival: Results | None = None

    @property
    def words(self) -> str:
        """For a cell of a table."""
        return ", ".join(self.counts_for) or f"none: {self.why_not}"

    def tell(self) -> str:
        """A sentence on a run that counts for no bed."""
        of = f" ({', '.join(self.beds)})" if self.beds else ""
        return f"{name_run(self.run)}{of} is not used: {self.why_not}."


def name_run(run: Results) -> str:
    """A run by its label, a file of means by the file's name, as far as that tells it from others."""
    return run.path.name if run.label == run.path.stem else run.label


def list_uses(runs: Sequence[Results]) -> list[Use]:
    """The use of each run, in their order."""
    chosen = sort_runs(runs)[0]
    return [_find_use(run, chosen) for run in runs]


def _find_use(run: Results, chosen: dict[str, dict[str, Results]]) -> Use:
    contacts, names = identify(run)
    if not names:
        near, why = explain_strange(run)
        return Use(run, (), (), f"{why}, else {', '.join(near)}" if near else "none of the paper's beds")
    if averaged_time(run) < SHORTEST_WINDOW:
        return Use(run, tuple(names), (), explain_short(run), chosen[contacts].get(names[0]))
    counts_for = tuple(name for name in names if chosen[contacts][name] is run)
    if counts_for:
        return Use(run, tuple(names), counts_for)
    rival = chosen[contacts][names[0]]
    return Use(run, tuple(names), (), _compare(run, rival), rival)


def _compare(run: Results, rival: Results) -> str:
    """Why `rival` counts in place of `run`."""
    (own_model, own_steady, own), (model, steady, other) = rank(run), rank(rival)
    if own_model != model:
        return f"gas.turbulence = {look_up(run.case, 'gas.turbulence')} is not the paper's; {name_run(rival)} counts"
    mark = find_start_up_in_means(run)
    if own_steady != steady and mark:
        return f"{mark.brief} in its means; {name_run(rival)} counts"
    return f"averaged {own:.3g} s; {name_run(rival)}, which averaged {other:.3g} s, counts"


def tell_choices(uses: Sequence[Use]) -> list[str]:
    """A sentence on each run in whose place another run of its bed counts."""
    return [use.tell() for use in uses if use.rival is not None]


def tell_idle(uses: Sequence[Use]) -> list[str]:
    """A sentence on each other run that is not used, or whose bed no claim speaks of."""
    spoken = {bed for claim in CLAIMS.values() for beds in (claim.needs, *claim.also) for bed in beds}
    told = []
    for use in uses:
        if not use.counts_for and use.rival is None:
            told.append(use.tell())
        elif use.counts_for and not spoken & set(use.counts_for):
            told.append(f"{name_run(use.run)} is {', '.join(use.counts_for)}, a bed that no statement speaks of.")
    return told


def name_chosen(uses: Sequence[Use]) -> dict[str, str]:
    """Beds with the paper's contacts -> their names in captions, each with its run where it has several."""
    mine = [use for use in uses if use.beds and identify(use.run)[0] == AS_PRINTED]
    several = {bed for use in mine for bed in use.beds if sum(bed in other.beds for other in mine) > 1}
    return {bed: f"{bed} ({name_run(use.run)})" if bed in several else bed for use in mine for bed in use.counts_for}
