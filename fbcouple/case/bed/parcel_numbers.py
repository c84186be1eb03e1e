"""Pre-flight numbers of a coarse-grained bed: how far its parcels are from the grains that they stand for."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fbcouple.case.bed.contact_coefficients import find_largest_ratio, find_least_restitution, scale_restitution
from fbcouple.case.bed.number import Number, judge
from fbcouple.case.bed.particle_types import find_ratio, largest_diameter, particle_count, solids_volume
from fbcouple.case.bed.region import Region
from fbcouple.case.bed.speeds import SETTLED
from fbcouple.case.schema.gas import Domain
from fbcouple.case.schema.sections import Case

FEWEST_ACROSS, FEWEST_DEEP = 5.0, 10.0
"""Parcels between two walls, and in the height of the bed at rest, below which walls and surface order most of them."""
FEWEST_IN_BUBBLE = 9.0
"""Parcels across a bubble below which a bed that was measured no longer turned over as that of its grains did."""


def describe_parcels(case: Case, region: Region) -> Iterator[Number]:
    """Number of parcels, their ratio against what restitution allows, and how many the bed is wide, deep and high;
    nothing of a bed that is not coarse-grained."""
    particles, contact = case.particles, case.contact
    assert particles is not None
    if particles.coarse_graining is None:
        return
    ratio, diameter = find_ratio(particles), largest_diameter(particles)
    meaning = "What LIGGGHTS has; the largest is {:.4g} m."
    yield Number("parcels", particle_count(particles), "1", None, None, meaning.format(diameter))
    if contact and contact.scale_restitution and ratio > 1.0:
        limit = find_largest_ratio(contact, particles)
        meaning = "Length ratio l: from 1/(1 - e^2) on parcels cannot lose as much as their grains do."
        wanted = f"below {limit:.4g}" if np.isfinite(limit) else None
        yield Number("coarse graining", ratio, "1", wanted, judge(ratio <= limit) if wanted else None, meaning)
        least = scale_restitution(find_least_restitution(contact, particles), ratio)
        meaning = "Restitution of parcels, e_l^2 = 1 - l (1 - e^2), the least; low ones want more DEM steps a contact."
        yield Number("parcel restitution", least, "1", None, None, meaning)
    elif contact:
        meaning = "Length ratio l, with the restitution of grains"
        meaning += ": the bed loses l times less than it should." if ratio > 1.0 else "."
        yield Number("coarse graining", ratio, "1", None, None, meaning)
    yield from _measure_bed(case, region, diameter)


def measure_bubbles(case: Case, region: Region, excess: float) -> Iterator[Number]:
    """Parcels across a bubble at the surface of the bed at rest, where gas comes `excess` [m/s] faster than it needs to
    fluidize a coarse-grained bed.

    Its equivalent diameter is 0.54 (U - U_mf)^0.4 h^0.8 g^-0.2 over a porous floor (Darton et al. 1977).
    """
    particles = case.particles
    if particles is None or particles.coarse_graining is None or excess <= 0.0:
        return
    if solids := solids_volume(particles):
        height = region.find_level(solids / SETTLED)
        bubble = 0.54 * excess**0.4 * height**0.8 / case.gravity**0.2
        count = bubble / largest_diameter(particles)
        wanted, fits = f"at least {FEWEST_IN_BUBBLE:g}", judge(count >= FEWEST_IN_BUBBLE)
        meaning = f"Of bubbles of {bubble:.3g} m at the bed's surface (Darton et al. 1977): below it the bed's turning "
        meaning += "dies away, as measured in one bed (study coarse-graining)."
        yield Number("parcels in a bubble", count, "1", wanted, fits, meaning)


def find_width(domain: Domain) -> float:
    """Distance [m] of the nearest walls across the bed, infinite where it repeats itself along both axes."""
    sizes = zip("xy", domain.size, strict=False)
    return min((size for axis, size in sizes if axis not in domain.periodic), default=math.inf)


def _measure_bed(case: Case, region: Region, diameter: float) -> Iterator[Number]:
    assert case.particles is not None
    if math.isfinite(width := find_width(case.domain)):
        count = width / diameter
        meaning = "Parcels between the nearest walls: next to a wall they lie in layers, two diameters deep at each."
        fits = judge(count >= FEWEST_ACROSS)
        yield Number("parcels across", float(count), "1", f"at least {FEWEST_ACROSS:g}", fits, meaning)
    if solids := solids_volume(case.particles):
        count = region.find_level(solids / SETTLED) / diameter
        meaning = "Parcels in the height of the bed at rest; bubbles are made of many, and the surface is one thick."
        fits = judge(count >= FEWEST_DEEP)
        yield Number("parcels deep", float(count), "1", f"at least {FEWEST_DEEP:g}", fits, meaning)
