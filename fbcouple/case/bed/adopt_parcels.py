"""The ratio of parcels that a case gives by their number, `particles.parcels`, filled in."""

from __future__ import annotations

from pathlib import Path

from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.bed.start_sizes import adopt_sizes
from fbcouple.case.checks.mixture import find_unsound
from fbcouple.case.problems import Problem
from fbcouple.case.schema.particles import Particles
from fbcouple.case.schema.sections import Case

RATIO, NUMBER = "coarse_graining", "parcels"
_SIZED = f"the file of positions says how large each parcel is, so that no ratio follows; give {RATIO}, or count."


def adopt_parcels(case: Case, folder: Path) -> tuple[Case, list[Problem]]:
    """The case with the ratio l = (particles/parcels)^(1/3) in place of `particles.parcels`, where it gives that.

    folder: where its positions file lies, which may say how large each parcel is. With it what is wrong; then the case
    has neither.
    """
    if case.particles is None or case.particles.parcels is None:
        return case, []
    particles, text = resolve_parcels(case.particles)
    adopted = case.model_copy(update={"particles": particles})
    adopted.remember_bases(case.base_folders, case.inherited)
    if not text and particles.count is None and (sized := adopt_sizes(adopted, folder).particles) and sized.sizes:
        particles, text = particles.model_copy(update={RATIO: None}), _SIZED
    problems = [Problem(f"particles.{NUMBER}", f"{case.particles.parcels} is given and {text}")] if text else []
    return case.model_copy(update={"particles": particles}), problems


def resolve_parcels(particles: Particles) -> tuple[Particles, str]:
    """The particles with a ratio in place of a number of parcels; with neither, and the reason, where none follows. The
    reason is empty where other checks tell it."""
    if particles.parcels is None:
        return particles, ""
    plain = particles.model_copy(update={RATIO: None, NUMBER: None})
    if particles.coarse_graining is not None:
        return plain, f"{RATIO} = {particles.coarse_graining:g} too; give one of them."
    if not find_unsound(plain, ())[1] or (plain.mass is None) == (plain.count is None):
        return plain, ""
    if plain.sizes and plain.count is None:
        return plain, _SIZED
    count = _count_grains(plain)
    if count < particles.parcels:
        text = f"the bed has {count:.10g} particles; a parcel stands for one at least: give no more"
        return plain, f"{text}, or {RATIO}." if count >= 1.0 else f"the bed starts with no particles; give {RATIO}."
    return plain.model_copy(update={RATIO: (count / particles.parcels) ** (1.0 / 3.0)}), ""


def _count_grains(plain: Particles) -> float:
    """Particles of a bed that is not coarse-grained, unrounded."""
    if plain.count is not None:
        return float(plain.count)
    assert plain.mass is not None
    return plain.mass / sum(kind.share * kind.mass for kind in list_kinds(plain))
