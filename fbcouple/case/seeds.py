"""The seeds of a case: what makes one bed another one of the same kind."""

from __future__ import annotations

from fbcouple.case.bed.lattice import is_layered
from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.schema.particles import Particles, Start
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

SEEDS = ("start.seed", "particles.positions_seed", "particles.feeds")
"""Options in which replicas of a case may differ; of feeds their seeds alone."""
_LARGEST = 2**63


def change_seeds(case: Case, by: int) -> Case:
    """The case with every seed that it has raised by `by`: that of its lattice or of its start positions, and those of
    its feeds.

    Raises: CaseError (one text, without a place) if no seed changes anything of it.
    """
    particles, start = case.particles, case.start
    if particles is None:
        raise CaseError(["no seed changes it, as it has no particles; replicas of it would be one and the same run."])
    if start is not None and not particles.feeds and not _is_random(case):
        text = "no seed changes it: its particles start on a lattice without jitter"
        raise CaseError([f"{text}; give start.jitter above 0 (0.5 is the default)."])
    feeds = tuple(feed.model_copy(update={"seed": (feed.seed + by) % _LARGEST}) for feed in particles.feeds)
    changes: dict[str, Particles | Start] = {"particles": _change(particles, by).model_copy(update={"feeds": feeds})}
    if start is not None:
        changes["start"] = start.model_copy(update={"seed": (start.seed + by) % _LARGEST})
    changed = case.model_copy(update=changes)
    changed.remember_bases(case.base_folders)
    changed.remember_origin(*case.origin)
    return changed


def _is_random(case: Case) -> bool:
    """Does its lattice follow from a seed?"""
    assert case.particles is not None and case.start is not None
    mixed = len(list_kinds(case.particles)) > 1 and not (case.domain.shape == "box" and is_layered(case))
    return case.start.jitter > 0.0 or mixed


def _change(particles: Particles, by: int) -> Particles:
    """A start that no seed has shifted yet is shifted by seed `by`, and stays as it is for 0."""
    if particles.positions is None or (not by and particles.positions_seed is None):
        return particles
    return particles.model_copy(update={"positions_seed": ((particles.positions_seed or 0) + by) % _LARGEST})
