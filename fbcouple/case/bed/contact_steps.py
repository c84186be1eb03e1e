"""DEM steps that a contact must have for a packed bed to come to rest.

LIGGGHTS takes the velocities of a dashpot half a step late. A motion y against the spring (omega dt)^2 y and the
dashpot c dt then goes by y(n+1) - 2 y(n) + y(n-1) + c dt (y(n) - y(n-1)) + (omega dt)^2 y(n) = 0, which is stable as
long as (omega dt)^2 + 2 c dt <= 4. A particle of a packed bed has several contacts at once, and its stiffest motion
carries the sum of their loads (omega dt)^2 + 2 c dt. Where all particles spin the same way every contact slips twice,
and a sphere has 2/5 of the inertia: so the tangential dashpots are the limit long before the normal ones. Above the
limit a bed creeps and its kinetic energy never decays, at amplitudes that look like those of a quiet bed.

The sums, as multiples of the load of one contact, are the largest eigenvalues of the contact networks of settled beds
of 504 spheres. Settled dry beds with 3 to 20 steps and e from 0.1 to 0.97 come to rest, or do not, as this says to a
step and a half. Beds of low friction pack more densely and may be left with 0.2 mm/s.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

MOST_LOAD = 4.0
"""(omega dt)^2 + 2 c dt of a motion above which it grows."""
NORMAL = 3.7
"""Normal contacts of a bed without friction (7.6 contacts a particle; with friction 3.0)."""
SPINNING = 12.5
"""Tangential contacts of a bed whose particles spin the same way."""
SHEARING = 3.0
"""What tangential contacts add to the normal ones where particles do not rotate."""
WALL_NORMAL, WALL_SPINNING, WALL_SHEARING = 1.0, 7.0, 2.0
"""Contacts of a particle in an edge of the box with its walls, which take the place of half of the others."""


@dataclass(frozen=True)
class Oscillator:
    """A motion against contacts: spring (omega T_C)^2 and dashpot c T_C."""

    spring: float
    damping: float

    def __add__(self, other: Oscillator) -> Oscillator:
        return Oscillator(self.spring + other.spring, self.damping + other.damping)

    def __rmul__(self, factor: float) -> Oscillator:
        return Oscillator(factor * self.spring, factor * self.damping)

    @property
    def steps(self) -> float:
        """Steps n of T_C/n at which the motion stops being stable: spring/n^2 + 2 damping/n = 4."""
        return (self.damping + math.hypot(self.damping, math.sqrt(MOST_LOAD * self.spring))) / MOST_LOAD


FREE = Oscillator(0.0, 0.0)
"""No contact at all."""


@dataclass(frozen=True)
class Contacts:
    """The relative motion of two particles, or of one and a wall, along the normal and across it."""

    normal: Oscillator
    tangential: Oscillator = FREE


def count_steps(pairs: Iterable[Contacts], walls: Sequence[Contacts], rotates: bool) -> float:
    """Least number of steps in T_C with which a packed bed comes to rest.

    Each kind of pair is taken for all contacts of a particle, and beside each kind of wall for half of them.
    """
    load_pair, load_wall = (_spin_pair, _spin_wall) if rotates else (_shear_pair, _shear_wall)
    most = 0.0
    for pair in pairs:
        alone = load_pair(pair)
        at_walls = [0.5 * inner + outer for wall in walls for inner, outer in zip(alone, load_wall(wall), strict=True)]
        most = max(most, *(motion.steps for motion in (*alone, *at_walls)))
    return most


def _spin_pair(pair: Contacts) -> tuple[Oscillator, ...]:
    return NORMAL * pair.normal, SPINNING * pair.tangential


def _spin_wall(wall: Contacts) -> tuple[Oscillator, ...]:
    return WALL_NORMAL * wall.normal, WALL_SPINNING * wall.tangential


def _shear_pair(pair: Contacts) -> tuple[Oscillator, ...]:
    return (NORMAL * pair.normal + SHEARING * pair.tangential,)


def _shear_wall(wall: Contacts) -> tuple[Oscillator, ...]:
    return (WALL_NORMAL * wall.normal + WALL_SHEARING * wall.tangential,)
