"""The ratio of parcels that a case gives by their number, `particles.parcels`, filled in."""

from __future__ import annotations

from typing import Any

from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.problems import Problem
from fbcouple.case.schema.particles import Particles
from fbcouple.case.schema.sections import Case

RATIO, NUMBER = "coarse_graining", "parcels"


def adopt_parcels(case: Case) -> tuple[Case, list[Problem]]:
    """The case with the ratio l = (particles/parcels)^(1/3) in place of `particles.parcels`, where it gives that.

    With it what is wrong; then the case has neither.
    """
    particles = case.particles
    if particles is None or particles.parcels is None:
        return case, []
    plain = particles.model_copy(update={RATIO: None, NUMBER: None})
    without = case.model_copy(update={"particles": plain})
    if text := _find_fault(particles, plain):
        return without, [Problem(f"particles.{NUMBER}", f"{particles.parcels} is given and {text}")]
    count = _count_grains(plain)
    if count is None:
        return without, []  # told by other checks
    ratio = (count / particles.parcels) ** (1.0 / 3.0)
    return case.model_copy(update={"particles": plain.model_copy(update={RATIO: ratio})}), []


def _find_fault(particles: Particles, plain: Particles) -> str | None:
    """Why no ratio follows from the number of parcels that `particles` gives; `plain` has none of the two."""
    assert particles.parcels is not None
    if particles.coarse_graining is not None:
        return f"{RATIO} = {particles.coarse_graining:g} too; give one of them."
    if plain.sizes and plain.count is None:
        return f"the file of positions says how large each parcel is, so that no ratio follows; give {RATIO}, or count."
    count = _count_grains(plain)
    if count is not None and count < 1.0:
        return f"the bed has no particles at its start, so that no ratio follows; give {RATIO}."
    if count is not None and count < particles.parcels:
        return f"the bed has {count:.10g} particles; a parcel stands for one at least: give no more, or remove it."
    return None


def _count_grains(plain: Particles) -> float | None:
    """Particles of a bed that is not coarse-grained, unrounded; None where the case does not say it."""
    if (plain.mass is None) == (plain.count is None):
        return None
    if plain.count is not None:
        return float(plain.count)
    assert plain.mass is not None
    return plain.mass / sum(kind.share * kind.mass for kind in list_kinds(plain))


def keep_last_said(raw: dict[str, Any], set_keys: set[str]) -> None:
    """Of ratio and number in `raw`, a case file's content, leave what `--set` gives (`set_keys`) where the file gives
    the other one: a setting goes on top of the file."""
    particles = raw.get("particles")
    if not isinstance(particles, dict):
        return
    for said, other in ((RATIO, NUMBER), (NUMBER, RATIO)):
        if f"particles.{said}" in set_keys and f"particles.{other}" not in set_keys:
            particles.pop(other, None)
