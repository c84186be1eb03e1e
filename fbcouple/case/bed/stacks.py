"""Columns of the start lattice, which friction holds upright where particles cannot turn."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fbcouple.case.bed.drag_balance import minimum_fluidization
from fbcouple.case.bed.lattice import lay_out
from fbcouple.case.bed.number import Law, Number, judge
from fbcouple.case.bed.particle_types import mean_volume, particle_count
from fbcouple.case.schema.sections import Case

LIFTED, LOOSE = "start lifted", "start voidage"
_DENSE = 0.45
"""Voidage up to which a bed that stands as it starts is one at rest all the same."""
_MEND = 'set particles.rotation = true, or start.method = "pour".'


def stands_in_columns(case: Case) -> bool:
    """Does the bed begin as upright columns of particles that can neither turn nor, by their friction, slip?"""
    if case.particles is None or case.contact is None or case.start is None or case.gravity == 0.0:
        return False
    if case.particles.rotation or case.particles.positions or case.start.is_made:
        return False
    frictions = [case.contact.friction, *(row[-1] for row in case.contact.pairs)]
    return max(frictions) > 0.0 and particle_count(case.particles) > 1 and lay_out(case).layers > 1


def watch_columns(case: Case, speed: float | None, law: Law | None = None) -> Iterator[Number]:
    """What breaks such columns up: gas of `speed` [m/s], superficial, that lifts them; None: none does."""
    if not stands_in_columns(case):
        return
    assert case.particles is not None
    voidage = 1.0 - mean_volume(case.particles) / math.prod(lay_out(case).spacing)
    meaning = "columns of the start lattice stand as friction holds particles that do not turn: " + _MEND
    if speed is None:
        yield Number(LOOSE, voidage, "1", f"below {_DENSE:g}", judge(voidage < _DENSE), f"Dry, the {meaning}")
        return
    onset = minimum_fluidization(case, voidage, law)
    meaning = f"U_mf at the voidage {voidage:.2g} of the start; below it the {meaning}"
    yield Number(LIFTED, onset, "m s-1", f"below U_f = {speed:g}", judge(onset < speed), meaning)
