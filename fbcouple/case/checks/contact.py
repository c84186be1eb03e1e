"""Whether the options of [contact] fit together: what each contact model needs, and what it would never look at."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations_with_replacement
from pathlib import Path

from fbcouple.case.alternatives import word_removal
from fbcouple.case.bed.adopt_spring import SPRINGS, has_spring
from fbcouple.case.bed.contact_coefficients import find_pair, find_wall, list_coefficients
from fbcouple.case.bed.derived import ROLLING_FACTOR, dem_step, find_spring, tangential_damping, tangential_law
from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.checks.registry import COEFFICIENTS, check
from fbcouple.case.problems import Problem
from fbcouple.case.schema.particles import Contact
from fbcouple.case.schema.sections import Case
from fbcouple.physics.contact import normal_damping

HERTZ_KEYS = ("youngs_modulus", "poisson_ratio", "impact_speed")
SPRING_KEYS = ("tangential_stiffness", "tangential_damping")
LEAST_HERTZ_RESTITUTION = 0.05
"""LIGGGHTS refuses a smaller one."""
MOST_TANGENTIAL_DAMPING = 1.0
"""Part of its slip that a contact may lose in one DEM step to the dashpot beside the tangential spring."""


@check("contact.model", *(f"contact.{key}" for key in HERTZ_KEYS))
def check_model(case: Case, folder: Path) -> Iterator[Problem]:
    """Hertz has its moduli and its impact speed, and hooke has none of them."""
    if case.contact is None:
        return
    chosen = ("youngs_modulus", "impact_speed") if case.contact.max_overlap is not None else ()
    for key in HERTZ_KEYS:
        given = getattr(case.contact, key)
        if case.contact.model == "hertz" and given is None and key not in chosen:
            text = 'nothing is given and model = "hertz" needs it; give it in SI units, or take model = "hooke".'
            yield Problem(f"contact.{key}", text)
        elif case.contact.model == "hooke" and given is not None:
            text = f'{given:g} is given and model = "hooke" does not look at it; remove it, or take model = "hertz".'
            yield Problem(f"contact.{key}", text)


@check("contact.max_overlap", "contact.model", "contact.stiffness", "contact.youngs_modulus")
def check_max_overlap(case: Case, folder: Path) -> Iterator[Problem]:
    """A case that says what its spring is to do gives no spring."""
    if case.contact is None or case.contact.max_overlap is None or not has_spring(case):
        return
    name = SPRINGS[case.contact.model][0]
    text = f"{case.contact.max_overlap:g} is given, and {name} = {getattr(case.contact, name):g} too"
    removal = word_removal(case, ("contact.max_overlap", f"contact.{name}"))
    yield Problem("contact.max_overlap", f"{text}, which says it already; {removal}.")


def is_hertz(contact: Contact) -> bool:
    """Tell whether the contact is a Hertz contact with all that this needs."""
    return contact.model == "hertz" and all(getattr(contact, key) is not None for key in HERTZ_KEYS)


@check("contact.model", *COEFFICIENTS)
def check_hertz_restitution(case: Case, folder: Path) -> Iterator[Problem]:
    """LIGGGHTS takes no Hertz restitution as low as 0.05."""
    if case.contact is None or case.contact.model != "hertz":
        return
    pairs, walls = list_coefficients(case.contact)
    for key, rows, found in (("restitution", "pairs", pairs), ("wall_restitution", "walls", walls)):
        for number, one in enumerate(found):
            if one.restitution <= LEAST_HERTZ_RESTITUTION:
                given = f"{one.restitution:g} is given{f' in row {number}' if number else ''}"
                text = f'{given}, above {LEAST_HERTZ_RESTITUTION:g} is allowed with model = "hertz"; raise it.'
                yield Problem(f"contact.{rows if number else key}", text)


@check("contact", "end_time", *COEFFICIENTS, "particles.diameter", "particles.density")
def check_hertz_step(case: Case, folder: Path) -> Iterator[Problem]:
    """The DEM step of a Hertz contact is a number that time can advance by."""
    if case.contact is None or case.particles is None or not is_hertz(case.contact):
        return
    step = dem_step(case.contact, case.particles)
    if not (math.isfinite(step) and case.end_time + step > case.end_time):
        text = f"{case.contact.youngs_modulus:g} Pa at {case.contact.impact_speed:g} m/s gives a DEM step of {step:g} s"
        mend = "give modulus, impact_speed and particle in SI units."
        yield Problem("contact.youngs_modulus", f"{text}, which time cannot advance by; {mend}")


@check("contact.tangential", "contact.model", *COEFFICIENTS)
def check_tangential(case: Case, folder: Path) -> Iterator[Problem]:
    """A tangential spring needs friction to load it, and friction between Hertz contacts needs the spring."""
    if case.contact is None:
        return
    pairs, walls = list_coefficients(case.contact)
    slides = any(coefficients.friction > 0.0 for coefficients in pairs + walls)
    if case.contact.tangential == "history" and not slides:
        text = '"history" is given and friction and wall_friction are 0, so that there is no tangential force'
        yield Problem("contact.tangential", f'{text}; give a friction above 0, or take "no-history".')
    if case.contact.tangential == "no-history" and slides and case.contact.model == "hertz":
        text = '"no-history" is given; with model = "hertz" LIGGGHTS has no viscous limit that would hold a contact'
        yield Problem("contact.tangential", f'{text}; take "history", or set friction and wall_friction to 0.')


@check("contact.tangential", "contact.model", *COEFFICIENTS, *(f"contact.{key}" for key in SPRING_KEYS))
def check_tangential_spring(case: Case, folder: Path) -> Iterator[Problem]:
    """The numbers of the tangential spring stand only where there is one that they can change."""
    if case.contact is None or (case.contact.model == "hooke" and tangential_law(case.contact) == "history"):
        return
    for key in SPRING_KEYS:
        given = getattr(case.contact, key)
        if given is not None:
            text = f'{given:g} is given, which only model = "hooke" with tangential = "history" looks at; remove it.'
            yield Problem(f"contact.{key}", text)


@check("contact", *COEFFICIENTS, "particles.diameter", "particles.density", "particles.rotation")
def check_tangential_damping(case: Case, folder: Path) -> Iterator[Problem]:
    """The explicit dashpot beside the tangential spring takes no more than the slip that there is."""
    contact, particles = case.contact, case.particles
    if contact is None or particles is None or contact.model == "hertz" or tangential_law(contact) == "no-history":
        return
    kinds = list_kinds(particles)
    lightest = min(kinds, key=lambda kind: kind.mass)
    coefficients = [find_pair(contact, one, other) for one, other in combinations_with_replacement(kinds, 2)]
    restitution = min(one.restitution for one in coefficients + [find_wall(contact, kind) for kind in kinds])
    rate = 2.0 * normal_damping(find_spring(contact, lightest), lightest.mass / 2.0, restitution)
    taken = tangential_damping(contact) * rate * dem_step(contact, particles)
    taken *= ROLLING_FACTOR if particles.rotation else 1.0
    if taken > MOST_TANGENTIAL_DAMPING:
        most = tangential_damping(contact) * MOST_TANGENTIAL_DAMPING / taken
        text = f"{tangential_damping(contact):g} times the normal damping would take {taken:.3g} of the slip in a step"
        mend = f"give at most {most:.3g}, or more steps_per_contact."
        yield Problem("contact.tangential_damping", f"{text}, at most {MOST_TANGENTIAL_DAMPING:g} is allowed; {mend}")


@check("contact.rolling_friction", "particles.rotation")
def check_rolling(case: Case, folder: Path) -> Iterator[Problem]:
    """Rolling resistance needs particles that rotate."""
    if case.contact is None or case.particles is None:
        return
    if case.contact.rolling_friction > 0.0 and not case.particles.rotation:
        text = f"{case.contact.rolling_friction:g} is given and the particles do not rotate"
        yield Problem("contact.rolling_friction", f"{text}; set particles.rotation = true, or this to 0.")
