"""Contact coefficients of two species, or of one and a wall: the rows of [contact] over its common values."""

from __future__ import annotations

from dataclasses import dataclass

from fbcouple.case.bed.particle_types import Kind
from fbcouple.case.schema.particles import Contact


@dataclass(frozen=True)
class Coefficients:
    """Of one kind of contact."""

    restitution: float
    friction: float


def find_pair(contact: Contact, one: Kind, other: Kind) -> Coefficients:
    """Coefficients between two kinds: the row of their species in `contact.pairs`, else the common ones."""
    for first, second, restitution, friction in contact.pairs:
        if {first, second} == {one.species, other.species}:
            return Coefficients(restitution, friction)
    return Coefficients(contact.restitution, contact.friction)


def find_wall(contact: Contact, kind: Kind) -> Coefficients:
    """Coefficients between a kind and the walls: the row of its species in `contact.walls`, else the common ones."""
    for species, restitution, friction in contact.walls:
        if species == kind.species:
            return Coefficients(restitution, friction)
    return Coefficients(contact.wall_restitution, contact.wall_friction)


def list_coefficients(contact: Contact) -> tuple[list[Coefficients], list[Coefficients]]:
    """All coefficients that the case names: between particles, and against walls."""
    pairs = [Coefficients(contact.restitution, contact.friction)]
    walls = [Coefficients(contact.wall_restitution, contact.wall_friction)]
    pairs += [Coefficients(restitution, friction) for *_, restitution, friction in contact.pairs]
    return pairs, walls + [Coefficients(restitution, friction) for _, restitution, friction in contact.walls]
