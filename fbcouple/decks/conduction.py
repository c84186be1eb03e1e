"""What LIGGGHTS is told of heat that contacts conduct.

LIGGGHTS has one law, 2 k A^(1/2) with the area A = pi a^2 of the circle in which spheres overlap. Whatever else a case
wants is a factor of that, which the conductivity in the deck has: the law's own, and that of the radius that the
material would have in place of the one that soft springs make.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from fbcouple.case.bed.derived import find_spring
from fbcouple.case.bed.particle_types import largest_diameter, list_kinds, mean_kind
from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.rest_overlap import find_rest_force
from fbcouple.case.schema.heat import Heat
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.sides import SIDES
from fbcouple.physics.heat.contact_conduction import CONDUCTION_LAWS, find_hertz_radius, find_overlap_radius

POISSON_RATIO = 0.3
"""Poisson's ratio of the material where the contact model has none; the radius of a contact goes with (1 - nu^2)^(1/3),
which is within 3 % of it for any material from 0.15 to 0.4."""
_ENDS = "lo", "hi"


def describe_conduction(case: Case, folder: Path) -> dict[str, Any]:
    """Numbers of the templates for a case of which contacts conduct, whose own files lie in `folder`."""
    heat, particles, contact = case.heat, case.particles, case.contact
    assert heat is not None and particles is not None and contact is not None
    types = len(list_kinds(particles)) + 1
    assert heat.particle_conductivity is not None and heat.particle_specific_heat is not None
    told: dict[str, Any] = {
        "conductivities": [find_conductivity(case, folder)] * types,
        "specific_heats": [heat.particle_specific_heat] * types,
        "true_moduli": [],
        "wall_temperatures": list_wall_temperatures(heat),
    }
    if heat.conduction_modulus is not None and contact.model == "hertz":
        told["true_moduli"] = [heat.conduction_modulus] * types
    return told


def find_conductivity(case: Case, folder: Path) -> float:
    """Conductivity [W/(m K)] that LIGGGHTS has to have so that its law gives that of the case."""
    heat, contact = case.heat, case.contact
    assert heat is not None and contact is not None and heat.particle_conductivity is not None
    factor = CONDUCTION_LAWS[heat.contact_conduction] / math.sqrt(math.pi)
    if heat.conduction_modulus is not None:
        # Of a Hertz contact LIGGGHTS corrects the overlap itself (area_correction); what is left is Hertz's radius.
        factor *= math.sqrt(0.5) if contact.model == "hertz" else find_radius_factor(case, folder)
    return factor * heat.particle_conductivity


def find_radius_factor(case: Case, folder: Path) -> float:
    """Radius of a contact in the material over that of the linear spring, at the force amid a bed at rest.

    The one goes with the cube root of the force, the other with its square root, so that they agree at one force: half
    of that at the bottom, between the largest particles.
    """
    heat, contact, particles = case.heat, case.contact, case.particles
    assert heat is not None and contact is not None and particles is not None and heat.conduction_modulus is not None
    force = 0.5 * find_rest_force(case, find_region(case, folder))
    radius = largest_diameter(particles) / 4.0
    modulus = heat.conduction_modulus / (2.0 * (1.0 - POISSON_RATIO**2))
    made = find_overlap_radius(radius, force / find_spring(contact, mean_kind(particles)))
    return find_hertz_radius(force, radius, modulus) / made


def list_wall_temperatures(heat: Heat) -> dict[str, float]:
    """Temperature [K] of each wall that has one, by its name in the decks: planes of a box, plates with openings that
    take their place, and the surface of a region that is no box."""
    planes = {f"{'xyz'[axis]}{_ENDS[end]}": heat.find_wall(side)[0] for side, (axis, end) in SIDES.items()}
    plates = {f"{plane}Plate": temperature for plane, temperature in planes.items()}
    found = planes | plates | {"surface": heat.wall_temperature}
    return {name: temperature for name, temperature in found.items() if temperature is not None}
