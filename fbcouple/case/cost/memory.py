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
CYLINDER_CELL, MESH_CELL = 4300.0, 6400.0
"""Bytes of a cell of a cylinder, of hexahedra, and of a mesh from a file, of tetrahedra: measured with 675 000 and
119 000 cells. Hexahedra of a file take less."""
LAUNCHER, LAUNCHER_CELL = 240e6, 1500.0
"""Bytes of `fbcouple run` itself, which waits beside the ranks, and of each cell of a mesh that it has read."""


def find_memory(case: Case, folder: Path = Path(), ranks: int = 1, found: Coefficients = SHIPPED) -> float:
    """Memory [bytes] of all `ranks` of a run of `case`, whose own files lie in `folder`: each with both solvers, cells,
    and particles, all that are fed among them."""
    particles = particle_count(case.particles) + count_fed(case) if case.particles else 0.0
    cells = find_region(case, folder).cells if case.gas else 0
    cell = {"cylinder": CYLINDER_CELL, "file": MESH_CELL}.get(case.domain.shape, found.cell_memory)
    return found.rank_memory * ranks + found.particle_memory * particles + cell * cells


def find_job_memory(case: Case, folder: Path, ranks: int) -> float:
    """Memory [bytes] that a batch job of `case` holds: that of its ranks, and of `fbcouple run` beside them."""
    cells = 0 if case.domain.shape == "box" or not case.gas else find_region(case, folder).cells
    return find_memory(case, folder, ranks) + LAUNCHER + LAUNCHER_CELL * cells
