"""What a bed is made of: kinds of particles, each of one diameter and one material, and how many of each.

`diameter` and `density` of [particles] are the first species; `spread` cuts it into classes of diameters. Each row of
`mixture` is a further species. Where a positions file gives each particle its size, `sizes` holds the kinds, all of
species 1. A kind is a LIGGGHTS type of its own, because the damping that meets a restitution
depends on the masses of both partners (eq. 18): so each pair of kinds meets its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fbcouple.case.schema.particles import Particles

_POINTS = 20_001
"""Diameters on which a distribution is integrated: those of 8 classes are then right to some 1e-4."""
_REACH = 8.0
"""Deviations beyond which a distribution has nothing, 1e-15 of it."""
_BELOW = 1.0 - 1e-9
_ROUNDING = 1e-12


@dataclass(frozen=True)
class Kind:
    """Particles of one diameter [m] and one density [kg m-3]; `species` counts materials from 1, `share` is its part
    of the number of particles.

    Of a coarse-grained bed it is a kind of parcels, and `ratio` their diameter over that of the grains they stand for.
    """

    diameter: float
    density: float
    species: int
    share: float
    ratio: float = 1.0

    @property
    def grain_diameter(self) -> float:
        """Of the grains of a parcel, which drag goes by; else the diameter [m]."""
        return self.diameter / self.ratio

    @property
    def grains(self) -> float:
        """Grains of one particle: 1, or of a parcel the cube of its ratio."""
        return count_grains(self.ratio)

    @property
    def volume(self) -> float:
        """Of one particle [m3]."""
        return math.pi / 6.0 * self.diameter**3

    @property
    def mass(self) -> float:
        """Of one particle [kg]."""
        return self.density * self.volume


def count_grains(ratio: float) -> float:
    """Grains of a parcel: ratio^3, a whole number where it is one to rounding."""
    grains = ratio**3
    return float(round(grains)) if math.isclose(grains, round(grains), rel_tol=_ROUNDING) else grains


def grains_per_parcel(particles: Particles) -> float:
    """How many particles as the case has them each one of LIGGGHTS stands for: 1 without coarse graining."""
    return count_grains(find_ratio(particles))


def find_ratio(particles: Particles) -> float:
    """Diameter of a parcel over that of its grains: 1 without coarse graining."""
    return particles.coarse_graining or 1.0


def list_kinds(particles: Particles) -> list[Kind]:
    """The kinds of a bed: the first species' classes from small to large, then the rows of the mixture.

    They are what LIGGGHTS has: of a coarse-grained bed parcels.
    """
    ratio = find_ratio(particles)
    if particles.sizes:  # of what the file has
        total = sum(count for *_, count in particles.sizes)
        return [Kind(diameter, density, 1, count / total, ratio) for diameter, density, count in particles.sizes]
    rest = 1.0 - sum(fraction for _, _, fraction in particles.mixture)
    rows = [(d, particles.density, 1, share * rest) for d, share in cut_spread(particles)]
    rows += [(d, density, n, fraction) for n, (d, density, fraction) in enumerate(particles.mixture, start=2)]
    if len(rows) == 1:
        return [_make_kind(*rows[0], ratio)]
    shares = np.array([fraction for *_, fraction in rows])
    if particles.fractions == "mass":
        shares /= [d**3 * density for d, density, *_ in rows]
    shares /= shares.sum()
    return [_make_kind(*row[:3], share, ratio) for row, share in zip(rows, shares.tolist(), strict=True)]


def _make_kind(diameter: float, density: float, species: int, share: float, ratio: float) -> Kind:
    return Kind(ratio * diameter, density, species, share, ratio)


def list_species(particles: Particles) -> list[int]:
    """The species of each kind, counted from 1, in the order of `list_kinds`."""
    classes = len(particles.sizes) or (1 if particles.spread is None else particles.classes)
    return [1] * classes + list(range(2, 2 + len(particles.mixture)))


def count_kinds(particles: Particles) -> list[int]:
    """Number of particles of each kind: they add up to the bed's, and each is within one of its share.

    Of a coarse-grained bed parcels, rounded.
    """
    if particles.sizes:
        return [count for *_, count in particles.sizes]
    kinds = list_kinds(particles)
    if particles.count is None:
        assert particles.mass is not None, "the schema's checks ask for count or mass"
        return _share_out(round(particles.mass / sum(kind.share * kind.mass for kind in kinds)), kinds)
    if particles.coarse_graining is None:
        return _share_out(particles.count, kinds)
    return _share_out(round(particles.count / grains_per_parcel(particles)), kinds)


def _share_out(total: int, kinds: list[Kind]) -> list[int]:
    """Whole numbers that add up to `total`: each share rounded down, the largest remainders rounded up."""
    if len(kinds) == 1:
        return [total]
    wanted = np.array([kind.share for kind in kinds]) * total
    counts = np.floor(wanted).astype(np.int64)
    most = np.argsort(counts - wanted, kind="stable")
    counts[most[: total - int(counts.sum())]] += 1
    return counts.tolist()


def cut_spread(particles: Particles) -> list[tuple[float, float]]:
    """Diameters [m] of the first species and their shares: classes that hold the same part of the distribution.

    The diameter of a class is that of its mean volume, so that count and mass of the bed fit each other.
    Raises: OverflowError if a class has no diameter that could be calculated with.
    """
    if particles.spread is None:
        return [(particles.diameter, 1.0)]
    assert particles.deviation is not None and particles.smallest is not None and particles.largest is not None
    between = particles.smallest, particles.largest
    with np.errstate(all="ignore"):
        d, density = SPREADS[particles.spread](particles.diameter, particles.deviation, between)
        part = density / density.sum()
        by_number = part / d**3 if particles.fractions == "mass" else part
        edges = np.searchsorted(np.cumsum(part), np.arange(1, particles.classes) / particles.classes)
        pairs = zip(np.split(by_number * d**3, edges), np.split(by_number, edges), strict=True)
        diameters = [float((v.sum() / n.sum()) ** (1 / 3)) for v, n in pairs]
    if not all(particles.smallest * _BELOW <= d <= particles.largest / _BELOW for d in diameters):  # nan neither
        raise OverflowError
    return [(diameter, 1.0 / particles.classes) for diameter in diameters]


Points = tuple[np.ndarray, np.ndarray]


def _spread_normally(mean: float, deviation: float, between: tuple[float, float]) -> Points:
    room = _REACH * deviation
    d = np.linspace(max(between[0], mean - room), min(between[1], mean + room), _POINTS)
    return d, np.exp(-0.5 * ((d - mean) / deviation) ** 2)


def _spread_lognormally(median: float, deviation: float, between: tuple[float, float]) -> Points:
    """On equal steps of ln d; d^3 of a number, or d^-3 of a mass, moves the distribution by 3 s^2 of ln d."""
    s = math.log1p(deviation / median)
    room = _REACH * s + 3.0 * s * s
    low, high = (math.log(end / median) for end in between)
    logs = np.linspace(max(low, -room), min(high, room), _POINTS)
    return median * np.exp(logs), np.exp(-0.5 * (logs / s) ** 2)


SPREADS: dict[str, Callable[[float, float, tuple[float, float]], Points]] = {
    "normal": _spread_normally,
    "lognormal": _spread_lognormally,
}
"""Diameters [m] at equal steps of the diameter, or of its logarithm, and the parts of a distribution up to a factor: of
mean or median, deviation, smallest and largest [m]."""


def largest_diameter(particles: Particles) -> float:
    """Of all kinds [m]; of a coarse-grained bed of its parcels."""
    return max(kind.diameter for kind in list_kinds(particles))


def particle_count(particles: Particles) -> int:
    """Number of particles: as given, or the bed's mass over the mean mass of one, rounded; of a coarse-grained bed
    parcels."""
    return sum(count_kinds(particles))


def grain_count(particles: Particles) -> float:
    """Number of particles as the case has them: of a coarse-grained bed those that its parcels stand for."""
    count = particle_count(particles)
    return count if particles.coarse_graining is None else count * grains_per_parcel(particles)


def word_count(particles: Particles, count: float, digits: int = 6) -> str:
    """`count` of what LIGGGHTS has, in words: particles, of a coarse-grained bed those of the case and the parcels."""
    if particles.coarse_graining is None:
        return f"{count:.{digits}g} particles"
    return f"{count * grains_per_parcel(particles):.{digits}g} particles ({count:.{digits}g} parcels)"


def word_one(particles: Particles) -> str:
    """What LIGGGHTS has one of: "particle" or "parcel"."""
    return "particle" if particles.coarse_graining is None else "parcel"


def mean_volume(particles: Particles) -> float:
    """Mean volume of a particle [m3]."""
    return sum(kind.share * kind.volume for kind in list_kinds(particles))


def mean_density(particles: Particles) -> float:
    """Mass of the bed over its solids volume [kg m-3]."""
    kinds = list_kinds(particles)
    if len(kinds) == 1:
        return kinds[0].density
    return sum(kind.share * kind.mass for kind in kinds) / mean_volume(particles)


def mean_kind(particles: Particles) -> Kind:
    """Equal spheres with the volume, surface and mass of the bed: diameter sum d^3/sum d^2 (Sauter), its density."""
    kinds = list_kinds(particles)
    if len(kinds) == 1:
        return kinds[0]
    sauter = sum(k.share * k.diameter**3 for k in kinds) / sum(k.share * k.diameter**2 for k in kinds)
    return Kind(sauter, mean_density(particles), 0, 1.0, kinds[0].ratio)


def solids_volume(particles: Particles) -> float:
    """Volume of all particles [m3]."""
    counts = count_kinds(particles)
    return sum(count * kind.volume for count, kind in zip(counts, list_kinds(particles), strict=True))


def draw_kinds(particles: Particles, seed: int) -> np.ndarray:
    """Kind of each particle, int (n,), counted from 0: as many as `count_kinds` says, in random order."""
    counts = count_kinds(particles)
    kinds = np.repeat(np.arange(len(counts)), counts)
    return kinds if len(counts) == 1 else np.random.default_rng([seed, len(kinds)]).permutation(kinds)
