"""Parts of a case: what is kept of a run."""

from __future__ import annotations

from fbcouple.case.schema.sections import Case
from fbcouple.decks.parts import Decision, register

OUTPUT: dict[str, Decision] = {}
_part = register(OUTPUT)


@_part
def _averages(case: Case) -> tuple[bool, str]:
    return case.averages is not None, "[averages] in the case" if case.averages else "no [averages]"


@_part
def _voidage_snapshots(case: Case) -> tuple[bool, str]:
    every = case.output.snapshots_every
    return every is not None, "no output.snapshots_every" if every is None else f"output.snapshots_every = {every}"


@_part
def _frames(case: Case) -> tuple[bool, str]:
    every = case.output.particles_every
    return every is not None, "no output.particles_every" if every is None else f"output.particles_every = {every}"


@_part
def _tracked_particles(case: Case) -> tuple[bool, str]:
    count = len(case.output.tracked)
    return count > 0, f"output.tracked has {count}" if count else "no output.tracked"


@_part
def _probes(case: Case) -> tuple[bool, str]:
    sets = case.output.probes
    return len(sets) > 0, f"output.probes has {len(sets)}" if sets else "no output.probes"
