"""Whether the contacts of a coarse-grained bed can be those of its grains, before anything is calculated from them."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from fbcouple.case.bed.contact_coefficients import find_largest_ratio, find_least_restitution
from fbcouple.case.bed.particle_types import find_ratio
from fbcouple.case.problems import Problem
from fbcouple.case.schema.particles import Contact, Particles
from fbcouple.case.schema.sections import Case

RATIO = "particles.coarse_graining"
_KEYS = ("restitution", "wall_restitution", "pairs", "walls", "scale_restitution")


def find_beyond(case: Case, spoiled: Collection[str]) -> list[Problem]:
    """What makes it impossible to scale the restitution of parcels; none where a key that it needs is `spoiled`."""
    if case.particles is None or case.contact is None or RATIO in spoiled or "contact" in spoiled:
        return []
    if any(f"contact.{key}" in spoiled for key in _KEYS):
        return []
    return list(_check_ratio(case.contact, case.particles))


def _check_ratio(contact: Contact, particles: Particles) -> Iterator[Problem]:
    ratio = find_ratio(particles)
    if ratio == 1.0 or not contact.scale_restitution:
        return
    if ratio > (limit := find_largest_ratio(contact, particles)):
        least = find_least_restitution(contact, particles)
        text = f"{ratio:.6g} is given; grains of restitution {least:g} lose more in their collisions than parcels can "
        text += f"from 1/(1 - e^2) on, at most {limit:.4g} is allowed"
        mend = "give less, or contact.scale_restitution = false, by which the bed loses less than it should."
        yield Problem(RATIO, f"{text}; {mend}")
