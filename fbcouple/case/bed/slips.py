"""The fastest slips that particles of a case can have, and whether its drag law was made for them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from fbcouple.case.bed.derived import open_velocity
from fbcouple.case.bed.drag_balance import find_balance
from fbcouple.case.bed.number import Law, Number, judge
from fbcouple.case.bed.particle_types import Kind, list_kinds
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import OWN
from fbcouple.errors import CaseError

SLIP = "slip Reynolds number"


@dataclass(frozen=True)
class Slips:
    """The fastest superficial slips [m/s] of particles of a kind: at rest before the gas of the fastest inlet, and as
    they fall through gas, or are fed into it."""

    kind: Kind
    by_gas: float
    by_fall: float

    @property
    def fastest(self) -> float:
        """The larger of both."""
        return max(self.by_gas, self.by_fall)


def list_slips(case: Case, law: Law | None = None) -> list[Slips]:
    """The fastest slips of each kind of a case with gas; none falls faster than drag that is known allows, nor than
    from the top of the region.

    law: the case's own drag law.
    """
    gas, particles = case.gas, case.particles
    assert gas is not None and particles is not None
    by_gas = open_velocity(case)
    found = []
    for kind in list_kinds(particles):
        weight = case.gravity * abs(1.0 - gas.density / kind.density)
        fall = math.sqrt(2.0 * weight * case.domain.size[2])
        if case.exchange is not None and (law is not None or case.exchange.drag != OWN):
            fall = min(fall, _find_terminal(case, law, kind))
        fed = [math.hypot(*feed.velocity) for feed in particles.feeds if feed.species == kind.species]
        found.append(Slips(kind, by_gas, max(fall, *fed, 0.0)))
    return found


def find_reynolds(case: Case, kind: Kind, slip: float) -> float:
    """Reynolds number of a superficial `slip` [m/s], by the diameter of grains."""
    assert case.gas is not None
    return case.gas.density * slip * kind.grain_diameter / case.gas.viscosity


def compare_slips(case: Case, law: Law | None) -> Iterator[Number]:
    """Of a law of the registry with a range: does the fastest slip of the case lie in it?"""
    from fbcouple.case.user_laws import DRAG_LAWS  # noqa: PLC0415  (loads numba)

    assert case.exchange is not None
    if law is not None or case.exchange.drag not in DRAG_LAWS:
        return
    most = DRAG_LAWS[case.exchange.drag].most
    if most is None:
        return
    slips = max(list_slips(case), key=lambda one: find_reynolds(case, one.kind, one.fastest))
    reynolds = find_reynolds(case, slips.kind, slips.fastest)
    why = "the gas at the inlet" if slips.by_gas >= slips.by_fall else "a fall, or a feed"
    meaning = f"Of the fastest slip, {slips.fastest:.3g} m/s, superficial, by {why}; beyond its range "
    meaning += f"`{case.exchange.drag}` is a guess."
    yield Number(SLIP, reynolds, "1", f"up to {most:g} (exchange.drag)", judge(reynolds <= most), meaning)


def _find_terminal(case: Case, law: Law | None, kind: Kind) -> float:
    try:
        return find_balance(case, 1.0, law, kind)
    except CaseError:
        return math.inf
