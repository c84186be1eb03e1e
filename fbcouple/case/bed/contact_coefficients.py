"""Contact coefficients of two species, or of one and a wall: the rows of [contact] over its common values."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

from fbcouple.case.bed.particle_types import Kind
from fbcouple.case.schema.particles import Contact, Particles

LEAST_OF_PARCELS = {"hooke": 0.01, "hertz": 0.0501}
"""Contact model -> least restitution of parcels: of hooke the steps of a contact grow without end below, of hertz
LIGGGHTS refuses it."""


@dataclass(frozen=True)
class Coefficients:
    """Of one kind of contact."""

    restitution: float
    friction: float


def find_pair(contact: Contact, one: Kind, other: Kind) -> Coefficients:
    """Coefficients between two kinds: the row of their species in `contact.pairs`, else the common ones, of parcels
    scaled."""
    return _scale(contact, one, _find_grains(contact, one.species, other.species))


def find_wall(contact: Contact, kind: Kind) -> Coefficients:
    """Coefficients between a kind and the walls: the row of its species in `contact.walls`, else the common ones, of
    parcels scaled."""
    return _scale(contact, kind, _find_grains_at_wall(contact, kind.species))


def _find_grains(contact: Contact, one: int, other: int) -> Coefficients:
    for first, second, restitution, friction in contact.pairs:
        if {first, second} == {one, other}:
            return Coefficients(restitution, friction)
    return Coefficients(contact.restitution, contact.friction)


def _find_grains_at_wall(contact: Contact, one: int) -> Coefficients:
    for species, restitution, friction in contact.walls:
        if species == one:
            return Coefficients(restitution, friction)
    return Coefficients(contact.wall_restitution, contact.wall_friction)


def _scale(contact: Contact, kind: Kind, grains: Coefficients) -> Coefficients:
    """The coefficients of parcels by those of their grains."""
    if kind.ratio == 1.0 or not contact.scale_restitution:
        return grains
    return Coefficients(scale_restitution(grains.restitution, kind.ratio), grains.friction)


def scale_restitution(restitution: float, ratio: float) -> float:
    """Restitution of parcels `ratio` times as large as their grains: e_l^2 = 1 - l (1 - e^2) (Lu et al. 2017).

    Collisions of spheres of d at one granular temperature take (1 - e^2)/d of it in a time: with l d as much is taken
    if 1 - e_l^2 is l times as much. Raises: ValueError if nothing above 0 does that, from l = 1/(1 - e^2) on.
    """
    square = 1.0 - ratio * (1.0 - restitution**2)
    if square <= 0.0:
        raise ValueError(f"no restitution of parcels: ratio {ratio:g}, restitution {restitution:g}")
    return math.sqrt(square)


def find_least_restitution(contact: Contact, particles: Particles) -> float:
    """Of all contacts that a bed can have, between its species and of each with a wall, as grains."""
    species = range(1, 2 + len(particles.mixture))
    pairs = [_find_grains(contact, *pair) for pair in itertools.combinations_with_replacement(species, 2)]
    return min(one.restitution for one in [*pairs, *(_find_grains_at_wall(contact, one) for one in species)])


def find_largest_ratio(contact: Contact, particles: Particles) -> float:
    """The ratio of parcels to grains at which the least elastic contact of a bed has `LEAST_OF_PARCELS`."""
    least = find_least_restitution(contact, particles)
    return (1.0 - LEAST_OF_PARCELS[contact.model] ** 2) / (1.0 - least**2) if least < 1.0 else math.inf


def list_coefficients(contact: Contact) -> tuple[list[Coefficients], list[Coefficients]]:
    """All coefficients that the case names, of grains: between particles, and against walls."""
    pairs = [Coefficients(contact.restitution, contact.friction)]
    walls = [Coefficients(contact.wall_restitution, contact.wall_friction)]
    pairs += [Coefficients(restitution, friction) for *_, restitution, friction in contact.pairs]
    return pairs, walls + [Coefficients(restitution, friction) for _, restitution, friction in contact.walls]
