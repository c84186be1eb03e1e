"""Whether the options of [start] fit together."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from fbcouple.case.bed.particle_types import particle_count
from fbcouple.case.checks.registry import BED, check, has_bed
from fbcouple.case.problems import Problem
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.input_files.companion_files import find_companion
from fbcouple.input_files.liggghts_files import RESTART


@check("start", "gravity")
def check_start(case: Case, folder: Path) -> Iterator[Problem]:
    """Particles come from one place, a restart file lies beside the case; pouring needs gravity."""
    start = case.start
    if start is None:
        return
    given = [f"start.{key}" for key in ("run", "restart") if getattr(start, key) is not None]
    if given and start.method != "lattice":
        yield Problem("start.method", f'"{start.method}" is given and {given[0]} too; remove one of them.')
    if len(given) > 1:
        yield Problem("start.restart", f'"{start.restart}" is given and start.run too; remove one of them.')
    if start.restart is not None:
        try:
            find_companion(case.find_folder(folder, start.restart), start.restart, RESTART)
        except CaseError as error:
            yield from (Problem("start.restart", problem) for problem in error.problems)
    if start.time is not None and start.run is None:
        yield Problem("start.time", f"{start.time:g} s is given and no start.run; remove it, or name the run folder.")
    if start.region is not None and start.is_made:
        text = "is given, which the lattice alone fills, and particles are poured, or taken of a run or restart file"
        yield Problem("start.region", f"{text}; remove it, or start on the lattice.")
    if start.method == "pour" and case.gravity == 0.0:
        yield Problem("start.method", '"pour" is given and gravity is 0: nothing falls; give gravity, or "lattice".')


@check("start", *BED)
def check_poured(case: Case, folder: Path) -> Iterator[Problem]:
    """Where particles are poured there are some."""
    if case.start is None or case.start.method != "pour" or case.particles is None or not has_bed(case):
        return
    if not particle_count(case.particles):
        text = '"pour" is given and the start is empty, so that nothing is poured; give particles, or "lattice".'
        yield Problem("start.method", text)
