"""How thin and how small the least cell of a mesh is that is no plain box: the Courant number there holds the step of
all, and what is smaller than a particle can be more than full."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np

from fbcouple.case.bed.derived import cell_size
from fbcouple.case.bed.number import Number, judge
from fbcouple.case.bed.particle_types import largest_diameter
from fbcouple.case.bed.region import TETRAHEDRA, find_imported
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.extrusion import PER_PRISM
from fbcouple.geometry.imported import ImportedMesh
from fbcouple.geometry.polyhedra import find_centres
from fbcouple.geometry.quality import measure_cells, measure_widths

ALONG = 2
"""The axis that the gas goes along."""
THIN = 0.15
"""Width over the median below which a cell is a sliver; a good mesh of tetrahedra has none below 0.2."""


def find_widths(case: Case, folder: Path) -> np.ndarray | None:
    """Width [m] of each cell along z of a mesh from a file, (cells,); None where all cells of a case are alike."""
    if case.domain.shape != "file":
        return None
    return _measure_once(find_imported(case.domain, case.find_folder(folder, case.domain.mesh)))


@lru_cache(maxsize=2)
def _measure_once(found: ImportedMesh) -> np.ndarray:
    return measure_widths(found.mesh)[:, ALONG]


@lru_cache(maxsize=2)
def _measure_volumes(found: ImportedMesh) -> np.ndarray:
    return measure_cells(found.mesh, find_centres(found.mesh))[0]


def find_thinnest(case: Case, folder: Path) -> float | None:
    """The least of `find_widths`; of a mesh that is made here, the part of a cell's height that its elements have."""
    widths = find_widths(case, folder)
    if widths is not None:
        return float(widths.min())
    if case.domain.is_plain_box:
        return None
    return float(cell_size(case)[ALONG]) / PER_PRISM[case.domain.elements or TETRAHEDRA]


def look_for_slivers(case: Case, widths: np.ndarray, folder: Path) -> Iterator[Number]:
    """How thin the thinnest cell is of a mesh from a file, whose cells are of `widths` (cells,) [m], and with particles
    how small the smallest is."""
    yield from _tell_thin_cells(widths)
    if case.particles:
        yield from _tell_small_cells(case, folder)


def _tell_small_cells(case: Case, folder: Path) -> Iterator[Number]:
    """Volume of the smallest cell of a mesh from a file, over that of the largest particle (of a coarse-grained bed
    parcel)."""
    assert case.particles is not None
    volumes = _measure_volumes(find_imported(case.domain, case.find_folder(folder, case.domain.mesh)))
    particle = math.pi / 6.0 * largest_diameter(case.particles) ** 3
    share, small = float(volumes.min()) / particle, int((volumes < particle).sum())
    meaning = "Volume of the smallest cell over that of the largest particle"
    if small:
        cells = f"{small} of {len(volumes)} cells are" if small > 1 else f"one of {len(volumes)} cells is"
        meaning = (
            f"{meaning}. {cells} smaller: averages count a particle where its centre is, so that the solids fraction "
            "of such cells is above 1 at times (the voidage that the gas has is spread)"
        )
    yield Number("smallest cell", share, "1", "at least 1", judge(share >= 1.0), f"{meaning}.")


def _tell_thin_cells(widths: np.ndarray) -> Iterator[Number]:
    """The least of `widths` (cells,) [m] over their median."""
    usual = float(np.median(widths))
    share, thin = float(widths.min()) / usual, int((widths < THIN * usual).sum())
    meaning = "Least width of a cell along z over the median of all cells; it holds the fluid step"
    if thin:
        cells = f"{thin} of {len(widths)} cells are" if thin > 1 else f"one of {len(widths)} cells is"
        meaning = f"{meaning}. {cells} thinner; without slivers it is longer (gmsh: Mesh.OptimizeNetgen = 1)"
    yield Number("thinnest cell", share, "1", f"above {THIN:g}", judge(share >= THIN), f"{meaning}.")
