"""Pre-flight numbers of contacts: their time, their steps, and whether friction holds a bed at rest."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fbcouple.case.bed.contact_coefficients import list_coefficients
from fbcouple.case.bed.derived import (
    FEWEST_STEPS,
    dem_step,
    least_steps,
    pair_contact_time,
    steps_per_contact,
    tangential_law,
    viscous_limit,
)
from fbcouple.case.bed.number import Number, Verdict
from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.schema.sections import Case

SURELY_TOO_FEW = 0.9
"""Part of the steps that a packed bed needs below which it surely does not come to rest; above, some beds do."""


def time_contacts(case: Case) -> Iterator[Number]:
    """Contact time, DEM step, and the steps of a contact against those that let a packed bed come to rest."""
    assert case.particles is not None and case.contact is not None
    contact, particles = case.contact, case.particles
    meaning = "Duration of a contact between two particles, T_C."
    yield Number("contact time", pair_contact_time(contact, particles), "s", None, None, meaning)
    yield Number("DEM step", dem_step(contact, particles), "s", None, None, "Constant step of the particles.")
    steps, least = steps_per_contact(contact, particles), least_steps(contact, particles)
    wanted = max(FEWEST_STEPS, math.ceil(least))
    meaning = "Dashpots act half a step late: with fewer a packed bed of this restitution, contact model and friction "
    meaning += (
        "creeps and never comes to rest (contact.steps_per_contact). Six keep restitution 0.97 within 0.959-0.990."
    )
    too_few: Verdict = "unfit" if case.gravity > 0.0 and steps < SURELY_TOO_FEW * least else "warn"
    verdict = "fit" if steps >= wanted else too_few
    yield Number("DEM steps per contact", steps, "1", f"at least {wanted}", verdict, meaning)


def tell_creep(case: Case, rests: bool) -> Iterator[Number]:
    """Speed at which contacts without history slide under one particle's weight; a warning if the bed `rests`."""
    assert case.particles is not None and case.contact is not None
    pairs, walls = list_coefficients(case.contact)
    slides = any(coefficients.friction > 0.0 for coefficients in pairs + walls)
    if not slides or tangential_law(case.contact) == "history":
        return
    heaviest = max(list_kinds(case.particles), key=lambda kind: kind.mass)
    speed = case.gravity * heaviest.mass / (0.5 * heaviest.mass * viscous_limit(case.contact, case.particles))
    meaning = "Speed at which a contact slides under the weight of one particle: without history nothing sticks, and a "
    meaning += "bed at rest flows and packs: it costs 16-30 % too much pressure, a heap spreads."
    limit = '0 where the bed rests (contact.tangential = "history")' if rests else None
    yield Number("sliding at rest", speed, "m s-1", limit, "warn" if rests else None, meaning)
