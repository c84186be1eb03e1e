"""What the mesh of a case holds the step of the gas by: how thin its cells are, how fast diffusion goes in them, and
how fast gas comes in by its faces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from fbcouple.case.bed.derived import cell_size, wraps
from fbcouple.case.bed.jets import find_jet_range
from fbcouple.case.bed.region import SHAPES, find_imported
from fbcouple.case.bed.thin_cells import find_thinnest
from fbcouple.case.schema.gas import Domain
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.diffusion import find_box_rate, measure_rates
from fbcouple.geometry.imported import ImportedMesh

_ALIKE = 3
"""Layers of a mesh that is made here: one at the bottom, one at the top, and one as all others."""


@dataclass(frozen=True)
class Limits:
    """Of the cells of a case: width [m] of the thinnest along z, None where all are bricks as `domain.cells` says; the
    largest diffusion rate [1/m2] (`measure_rates`); and the largest speed [m/s] of gas through a face of the inlet."""

    thinnest: float | None
    rate: float
    jet: float


def measure_limits(case: Case, folder: Path | None) -> Limits:
    """The limits by the cells of the gas of `case`, whose own files lie in `folder`; without a folder a mesh from a
    file is taken for bricks of its sampling grid, and some jets for as fast as the case says (`find_jet_range`).

    Raises: CaseError (one text, without the key) if the mesh cannot be read.
    """
    domain, jet = case.domain, max(map(abs, find_jet_range(case, folder)))
    if domain.is_plain_box or (domain.shape == "file" and folder is None):
        return Limits(None, find_box_rate(cell_size(case), domain.cells, wraps(domain)), jet)
    thinnest = find_thinnest(case, folder or Path())
    if domain.shape == "file":
        found = find_imported(domain, case.find_folder(folder or Path(), domain.mesh))
        return Limits(thinnest, _rate_imported(found), jet)
    return Limits(thinnest, _rate_made(domain), jet)


@lru_cache(maxsize=2)
def _rate_imported(found: ImportedMesh) -> float:
    return float(measure_rates(found.mesh).max())


@lru_cache(maxsize=8)
def _rate_made(domain: Domain) -> float:
    """Of a mesh that is made here, of no more layers than differ."""
    across, along, layers = domain.cells
    few = min(layers, _ALIKE)
    width, depth, height = domain.size
    part = {"cells": (across, along, few), "size": (width, depth, height * few / layers)}
    return float(measure_rates(SHAPES[domain.shape](domain.model_copy(update=part), Path())).max())
