"""Whether the options of [start] fit together."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from fbcouple.case.checks.registry import check
from fbcouple.case.problems import Problem
from fbcouple.case.schema.sections import Case


@check("start", "gravity")
def check_start(case: Case, folder: Path) -> Iterator[Problem]:
    """Particles come from one place; pouring needs gravity."""
    start = case.start
    if start is None:
        return
    if start.run is not None and start.method != "lattice":
        yield Problem("start.method", f'"{start.method}" is given and start.run too; remove one of them.')
    if start.time is not None and start.run is None:
        yield Problem("start.time", f"{start.time:g} s is given and no start.run; remove it, or name the run folder.")
    if start.region is not None and start.is_made:
        text = "is given, which the lattice alone fills, and particles are poured or taken of a run"
        yield Problem("start.region", f"{text}; remove it, or start on the lattice.")
    if start.method == "pour" and case.gravity == 0.0:
        yield Problem("start.method", '"pour" is given and gravity is 0: nothing falls; give gravity, or "lattice".')
