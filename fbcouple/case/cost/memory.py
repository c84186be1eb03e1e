"""Memory of a run: the one estimate that checks, predictions and batch jobs have."""

from __future__ import annotations

from pathlib import Path

from fbcouple.case.bed.feeds import count_fed
from fbcouple.case.bed.particle_types import particle_count
from fbcouple.case.bed.region import find_region
from fbcouple.case.cost.coefficients import SHIPPED, Coefficients
from fbcouple.case.schema.sections import Case

FACTOR = 1.2
"""Factor that the memory is within."""


def find_memory(case: Case, folder: Path = Path(), ranks: int = 1, found: Coefficients = SHIPPED) -> float:
    """Memory [bytes] of all `ranks` of a run of `case`, whose own files lie in `folder`: each with both solvers, cells,
    and particles, all that are fed among them."""
    particles = particle_count(case.particles) + count_fed(case) if case.particles else 0.0
    cells = find_region(case, folder).cells if case.gas else 0
    return found.rank_memory * ranks + found.particle_memory * particles + found.cell_memory * cells
