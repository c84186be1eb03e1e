"""Whether the kinds of particles that a case names fit together, before anything is calculated from them."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from fbcouple.case.bed.particle_types import count_kinds, cut_spread, list_kinds, word_one
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.particles import Particles
from fbcouple.case.schema.sections import Case

_SPREAD_KEYS = ("deviation", "smallest", "largest")
_SIZE_KEYS = ("diameter", "density", "mixture", "fractions", "spread", "classes", "sizes", *_SPREAD_KEYS)
KEYS = tuple(f"particles.{key}" for key in _SIZE_KEYS)


def find_unsound(particles: Particles, spoiled: Collection[str]) -> tuple[list[Problem], bool]:
    """What makes it impossible to list the kinds, and whether they can be listed: not if a key is `spoiled`."""
    if any(key in spoiled for key in KEYS):
        return [], False
    problems = [*_check_fractions(particles), *_check_spread(particles), *_check_sizes(particles)]
    return problems, not problems


def _check_fractions(particles: Particles) -> Iterator[Problem]:
    total = sum(fraction for *_, fraction in particles.mixture)
    if total >= 1.0 - 1e-9:
        text = f"the fractions add up to {total:g} and leave nothing for species 1, below 1 is allowed"
        yield Problem("particles.mixture", f"{text}; leave one species out of the rows: diameter and density say it.")


def _check_spread(particles: Particles) -> Iterator[Problem]:
    for key in _SPREAD_KEYS:
        given = getattr(particles, key)
        if particles.spread is None and given is not None:
            yield Problem(f"particles.{key}", f"{given:g} is given and no spread; give the spread, or remove this.")
        elif particles.spread is not None and given is None:
            text = f"nothing is given and spread = {show(particles.spread)} needs it; give it in m."
            yield Problem(f"particles.{key}", text)
    if particles.spread is None or particles.smallest is None or particles.largest is None:
        return
    if not particles.smallest < particles.diameter < particles.largest:
        text = f"{particles.smallest:g} to {particles.largest:g} m does not hold the diameter {particles.diameter:g} m"
        yield Problem("particles.smallest", f"{text}; fix one of the three.")
        return
    if particles.deviation is not None:
        try:
            cut_spread(particles)
        except OverflowError:
            text = f"{particles.deviation:g} m is given; with it no diameters of the classes can be calculated"
            yield Problem("particles.deviation", f"{text}; give it, and the diameters, in m.")


def _check_sizes(particles: Particles) -> Iterator[Problem]:
    if not particles.sizes:
        return
    others = [key for key in ("mixture", "spread") if getattr(particles, key)]
    if others:
        text = f"{show(particles.sizes)} is given and {' and '.join(others)} too"
        yield Problem("particles.sizes", f"{text}; remove it, or them.")
    elif particles.positions is None:
        text = f"{show(particles.sizes)} is given and no positions, whose file says the size of each particle"
        yield Problem("particles.sizes", f"{text}; give mixture or spread in place of it.")


def check_counts(case: Case) -> Iterator[Problem]:
    """Each kind of a mixture has at least one particle."""
    assert case.particles is not None
    kinds, counts = list_kinds(case.particles), count_kinds(case.particles)
    for kind, count in zip(kinds, counts, strict=True):
        if count < 1 < len(kinds) and any(counts):
            what = f"{word_one(case.particles)} of {kind.diameter:g} m and {kind.density:g} kg m-3"
            text = f"the bed holds less than one {what}"
            yield Problem(
                "particles.mixture", f"{text}; give it a larger fraction, the bed more, or spread fewer classes."
            )
            return


def check_species(case: Case) -> Iterator[Problem]:
    """The rows of [contact] name species that are there, each pair once."""
    assert case.particles is not None and case.contact is not None
    most, seen = 1 + len(case.particles.mixture), set()
    rows = [("pairs", row[:2]) for row in case.contact.pairs] + [("walls", row[:1]) for row in case.contact.walls]
    for key, species in rows:
        told = " and ".join(map(str, species))
        if max(species) > most:
            yield Problem(f"contact.{key}", f"species {told} is given, 1 to {most} are there; number them from 1.")
        elif (key, frozenset(species)) in seen:
            yield Problem(f"contact.{key}", f"species {told} is given twice; give one row for it.")
        seen.add((key, frozenset(species)))
