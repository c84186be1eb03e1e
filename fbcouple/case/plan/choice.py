"""The plan of a case: of all candidates those on the front of error against cost, and the one that is wanted."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fbcouple.case.cost.coefficients import Coefficients, load_coefficients
from fbcouple.case.cost.means import START_UP, predict_means
from fbcouple.case.cost.work import RESTING, count_work
from fbcouple.case.load import load_case
from fbcouple.case.plan.candidates import Candidate, Member, Pricing, list_averages, list_splits, make_member
from fbcouple.case.plan.case_file import write_case_file
from fbcouple.case.plan.knobs import list_numerics
from fbcouple.case.plan.measured_errors import FACTOR
from fbcouple.case.preflight import require_fit
from fbcouple.case.problems import show
from fbcouple.case.schema.output import AUTO, find_first_sample, name_map
from fbcouple.case.schema.sections import Case
from fbcouple.case.source import find_case
from fbcouple.errors import CaseError

QUANTITY = "solids_flux"
"""The mean map that errors and times of averaging were measured of."""
LADDER = (4.0, 2.8, 2.0, 1.4, 1.0, 0.7, 0.5)
"""Errors over the wanted one at which the front is told."""
WORST = 0.9
"""Largest error of the front."""
_USUAL = 0.1
"""Statistical error at which numerics are compared."""
_FOUND = ("end_time", "averages.until_error")
_KNOWN = f"errors of the mean map of {QUANTITY} are known of beds that gas moves and that keep their particles"


@dataclass(frozen=True)
class Plan:
    """What is wanted of the case `name` with `sets` on top, and the ways there.

    error: of the mean map of solids flux, over the map; within: wall time [s], or None; ranks: cores for all replicas
    together; chosen: reaches it, or None where nothing does; best: then the least error that can be had; front: the
    cheapest at each of a ladder of errors; curves: those of each numerics that any of them has; left_out: numerics that
    are no case, and why; measured: whose costs of a step, "" of the shipped ones.
    """

    name: str
    sets: tuple[str, ...]
    error: float
    within: float | None
    ranks: int
    chosen: Candidate | None
    best: Candidate | None
    front: tuple[Candidate, ...]
    curves: tuple[tuple[Candidate, ...], ...]
    left_out: tuple[str, ...]
    measured: str

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Write a case file that stands on the case and reaches the error, and load it.

        Returns: the file. Raises: CaseError if nothing reaches the error, there is such a file, or it lies where it
        cannot stand on the case.
        """
        if self.chosen is None:
            raise CaseError([f"plan: {self.tell_miss()}"])
        return write_case_file(Path(path), self.name, self.sets, self.chosen.list_settings(), self._note())

    def _note(self) -> list[str]:
        one = self.chosen
        assert one is not None
        told = f"Planned by fbcouple for an error of {self.error:g} of the mean map of {QUANTITY}: numerical "
        told += f"{one.numerics.error:.2g} (within a factor of {FACTOR:g}) and statistical {one.statistical:.2g}."
        whole = f"{one.core_hours:.2g} core-hours, within a factor of {one.factor:.2g}"
        return [told, f"Told: {one.format_split()} up to about {one.means.end:.3g} s, {whole}."]

    def tell_miss(self) -> str:
        """Why nothing is chosen, and what comes nearest."""
        limits = "" if self.within is None else f" within {self.within:g} s"
        ranks = f"{self.ranks} rank{'s' if self.ranks > 1 else ''}"
        text = f"an error of {self.error:g} is not reached{limits} on {ranks}"
        if self.best is None:
            return f"{text}, and no run that has means ends by then; give more time, or more ranks."
        least = f"{self.best.error:.2g} ({self.best.numerics.format()})"
        if self.within is None:
            return f"{text} by any numerics that were measured; the least is about {least}."
        return f"{text}; the least error is {least}; give more time, more ranks, or a larger error."

    def describe(self) -> dict[str, Any]:
        """The numbers as files have them."""
        return {
            "case": self.name,
            "settings": list(self.sets),
            "quantity": QUANTITY,
            "error": self.error,
            "within_seconds": self.within,
            "ranks": self.ranks,
            "numerical_factor": FACTOR,
            "coefficients": self.measured or "shipped",
            "chosen": self.chosen.describe() if self.chosen else None,
            "best": self.best.describe() if self.best else None,
            "front": [candidate.describe() for candidate in self.front],
            "curves": [[candidate.describe() for candidate in curve] for curve in self.curves],
            "left_out": list(self.left_out),
        }


def make_plan(
    name: str,
    error: float,
    within: float | None = None,
    ranks: int = 1,
    sets: Sequence[str] = (),
    found: Coefficients | None = None,
) -> Plan:
    """Find what reaches `error`, numerical and statistical in squares, of the mean map of solids flux at least cost.

    name, sets: as `load_case`; what `sets` give is held. within: wall time [s] in which it is to end; of those that do
    the one of least core-hours is chosen, without it the one that ends first. ranks: cores for all replicas together.
    found: what a step costs; by default this machine's.

    Raises: CaseError if nothing is known of the error of such a case, or a value is out of range.
    """
    _require_range(error, within)
    found, folder = found or load_coefficients(), find_case(name).parent
    held = [setting.partition("=")[0].strip() for setting in sets]
    case = load_case(name, sets)
    _require_bed(case, held)
    sets = (*sets, *list_averages(case, held))
    case = load_case(name, sets)
    load_case(name, [*sets, f"averages.until_error={WORST:g}"])  # what a plan ends its runs by, which asks for more
    _require_known(case, folder)
    members, left_out = _make_members(name, sets, case, folder, held)
    pricing, splits = Pricing(found, folder), list(list_splits(case, ranks, folder))
    members = _drop_dominated(pricing, members)
    order = _order_by_time if within is None else _order_by_cost
    steps = [step * error for step in LADDER if step * error <= WORST]
    table = [[_choose(pricing, member, splits, step, within) for member in members] for step in steps]
    front = [min(filter(None, row), key=order, default=None) for row in table]
    chosen = front[steps.index(error)]
    best = None if chosen else _find_best(pricing, members, splits, within)
    curves = [_keep_different(column) for column in zip(*table, strict=True)]
    return Plan(
        name=name,
        sets=tuple(sets),
        error=error,
        within=within,
        ranks=ranks,
        chosen=chosen,
        best=best,
        front=_keep_different(front),
        curves=tuple(curve for curve in curves if curve),
        left_out=tuple(left_out),
        measured=found.measured,
    )


def _order_by_time(one: Candidate) -> tuple[float, float]:
    return one.wall, one.core_hours


def _order_by_cost(one: Candidate) -> tuple[float, float]:
    return one.core_hours, one.wall


def _keep_different(found: Iterable[Candidate | None]) -> tuple[Candidate, ...]:
    """The candidates, the last of those that are one and the same run."""
    kept = {(one.numerics.format(), one.replicas, one.ranks, one.means.end): one for one in found if one}
    return tuple(kept.values())


def _require_range(error: float, within: float | None) -> None:
    problems = []
    if not 0.0 < error <= WORST:
        problems.append(f"--error: {error:g} is given, above 0 and at most {WORST:g} is allowed: it is over the map.")
    if within is not None and not 0.0 < within < math.inf:
        problems.append(f"--within: {within:g} s is given, a time above 0 is allowed.")
    if problems:
        raise CaseError(problems)


def _require_bed(case: Case, held: Collection[str]) -> None:
    """Raise CaseError if `case` is no bed that keeps its particles, or what a plan finds is given."""
    if case.particles is None or case.gas is None or case.exchange is None or case.gravity == 0.0:
        raise CaseError([f"case: no bed of particles under gas and gravity is given; {_KNOWN}."])
    if case.particles.feeds:
        raise CaseError([f"particles.feeds: particles are fed; {_KNOWN}."])
    if case.averages and (found := name_map(case.averages, True)) != QUANTITY:
        raise CaseError([f"averages.error_of: {show(found)} is given; {_KNOWN}: set it to {show(QUANTITY)}."])
    if given := [key for key in _FOUND if key in held]:
        raise CaseError([f"--set: {key} is given; it is what the plan finds: leave it out." for key in given])


def _require_known(case: Case, folder: Path) -> None:
    """Raise CaseError if nothing was measured of the means of such a bed."""
    if count_work(case, folder).contacts == RESTING:
        raise CaseError([f"gas: less comes in than fluidizes the bed, which rests; {_KNOWN}."])
    sure = predict_means(case, folder)
    if sure is None:
        raise CaseError([f"averages: their error cannot be told; {_KNOWN}."])
    _require_steady(case, START_UP * sure.period)


def _require_steady(case: Case, start_up: float) -> None:
    assert case.averages is not None and case.gas is not None
    begin = start_up if case.averages.start == AUTO else find_first_sample(case.averages)
    for ramp in [case.gas.inlet_ramp, *(inlet.ramp for inlet in case.gas.inlets)]:
        if ramp and ramp[-1][0] > begin:
            text = f"the gas is another up to {ramp[-1][0]:g} s, and the means begin at {begin:.3g} s"
            raise CaseError([f"gas: {text}; let it be steady before (averages.start)."])


def _make_members(
    name: str, sets: Sequence[str], case: Case, folder: Path, held: Collection[str]
) -> tuple[list[Member], list[str]]:
    members, left_out = [], []
    for numerics in list_numerics(case, folder, held):
        try:
            member = make_member(name, sets, numerics, folder)
            require_fit(member.case, None, folder)
        except CaseError as error:
            left_out.append(f"{numerics.format()}: {error}")
        else:
            members.append(member)
    if not members:
        raise CaseError([f"plan: none of the numerics that were measured is a case that is fit: {left_out[0]}"])
    return members, left_out


def _drop_dominated(pricing: Pricing, members: list[Member]) -> list[Member]:
    """Those that no other member beats in error at no more cost, on one rank and as long a run; the cheapest first."""
    costs = [pricing.make(member, 1, 1, _USUAL).core_hours for member in members]
    kept, least = [], math.inf
    for n in sorted(range(len(members)), key=lambda n: (costs[n], members[n].numerics.error)):
        if members[n].numerics.error < least:
            kept.append(members[n])
            least = members[n].numerics.error
    return kept


def _choose(
    pricing: Pricing, member: Member, splits: list[tuple[int, int]], error: float, within: float | None
) -> Candidate | None:
    """What reaches `error` by `member` at least cost, if anything does."""
    found = [pricing.reach(member, *split, error) for split in splits]
    fit = [one for one in found if one is not None and (within is None or one.wall <= within)]
    return min(fit, key=_order_by_time if within is None else _order_by_cost, default=None)


def _find_best(
    pricing: Pricing, members: list[Member], splits: list[tuple[int, int]], within: float | None
) -> Candidate | None:
    """The least error that can be had within the time; without one it is that of the finest numerics."""
    if within is None:
        finest = min(members, key=lambda member: member.numerics.error)
        return pricing.reach(finest, 1, splits[-1][1], 1.2 * finest.numerics.error)
    found = [pricing.reach_within(member, *split, within) for member in members for split in splits]
    return min((one for one in found if one is not None), key=lambda one: one.error, default=None)
