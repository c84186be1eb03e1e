"""The overlap of contacts under the weight of the bed."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fbcouple.case.bed.derived import find_spring, hertz_modulus
from fbcouple.case.bed.number import Number, judge
from fbcouple.case.bed.particle_types import largest_diameter, mean_density, mean_kind, solids_volume
from fbcouple.case.bed.region import Region
from fbcouple.case.bed.speeds import FIT_OVERLAP, SETTLED
from fbcouple.case.schema.sections import Case

CONTACTS = 6.0
"""Contacts of a particle in a packed bed."""


def estimate_rest_overlap(case: Case, region: Region) -> Iterator[Number]:
    """How deep the lowest particles of a bed at rest are in each other."""
    assert case.particles is not None
    if not solids_volume(case.particles):
        return  # feeds fill it, and nobody knows how far
    overlap = find_rest_overlap(case, region)
    meaning = "Overlap over diameter at the bottom of the bed at rest, under the weight of it all; as above."
    yield Number("overlap at rest", overlap, "d", f"at most {FIT_OVERLAP:g}", judge(overlap <= FIT_OVERLAP), meaning)


def find_rest_overlap(case: Case, region: Region) -> float:
    """Overlap over diameter of the mean contact at the bottom of a bed at rest that no wall carries.

    Its force is that of `find_rest_force`; the springs are eq. 17 of the paper, or Hertz's.
    """
    assert case.particles is not None and case.contact is not None
    diameter, force = largest_diameter(case.particles), find_rest_force(case, region)
    if case.contact.model == "hooke":
        return force / find_spring(case.contact, mean_kind(case.particles)) / diameter
    radius = diameter / 4.0
    return float((0.75 * force / (hertz_modulus(case.contact) * math.sqrt(radius))) ** (2.0 / 3.0) / diameter)


def find_rest_force(case: Case, region: Region) -> float:
    """Force [N] of the mean contact at the bottom of a bed at rest that no wall carries.

    It is pi d^2 p/(phi Z), p the weight less buoyancy over the cross-section, of phi = 0.60 and Z = 6 contacts a
    particle (Rumpf 1958, Chem. Ing. Tech. 30:144, with p for the strength).
    """
    assert case.particles is not None
    height = region.find_level(solids_volume(case.particles) / SETTLED)
    heavier = mean_density(case.particles) - (case.gas.density if case.gas else 0.0)
    return math.pi * largest_diameter(case.particles) ** 2 * height * abs(heavier) * case.gravity / CONTACTS
