"""How thin the thinnest cell of a mesh from a file is: the Courant number there holds the step of all of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fbcouple.case.bed.number import Number, judge
from fbcouple.case.bed.region import read_mesh
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.quality import measure_widths

THIN = 0.15
"""Width over the median below which a cell is a sliver; a good mesh of tetrahedra has none below 0.2."""


def tell_thin_cells(case: Case, folder: Path, velocity: float) -> Iterator[Number]:
    """Of a mesh from a file: the least width of a cell along z over the median of all, with the step that gas at
    `velocity` [m/s] may take through it."""
    assert case.gas is not None
    if case.domain.shape != "file":
        return
    widths = measure_widths(read_mesh(case, folder))[:, 2]
    usual = float(np.median(widths))
    share, thin = float(widths.min()) / usual, int((widths < THIN * usual).sum())
    meaning = "Least width of a cell along z over the median of all cells"
    if velocity > 0.0:
        step = case.gas.max_courant * float(widths.min()) / velocity
        meaning = f"{meaning}; gas at {velocity:.3g} m/s passes the thinnest in steps of {step:.2g} s"
    if thin:
        cells = f"{thin} of {len(widths)} cells are" if thin > 1 else f"one of {len(widths)} cells is"
        meaning = f"{meaning}. {cells} thinner; without slivers steps are longer (gmsh: Mesh.OptimizeNetgen = 1)"
    yield Number("thinnest cell", share, "1", f"above {THIN:g}", judge(share >= THIN), f"{meaning}.")
