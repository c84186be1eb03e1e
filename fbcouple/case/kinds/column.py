"""A bubbling bed in a round column, meshed with prisms, a quarter full and fluidized over its whole floor."""

from __future__ import annotations

import math

from fbcouple.case.kinds.bubbling import Shape, write_bed
from fbcouple.case.kinds.registry import Wanted, kind

SIZE = (20.0, 20.0, 100.0)
"""Diameter, twice, and height of the column, in diameters of a particle, where none are given."""
CELL = 2.5
"""Edge of a prism that is aimed at, in diameters: its volume is then that of a cube of 2."""

DOMAIN = """\
shape = "cylinder"              # upright; a mesh of your own: shape = "file"
elements = "prisms"             # rings of triangles, layer by layer; absent: tetrahedra
size = {size}     # m: diameter, twice, and height; z is up
# Cells across the diameter, an even number, twice, and up: prisms with edges of at least {cell:g} diameters
# ({cell:g} x {diameter:.4g} m), which are as large as cubes of 2.
cells = {cells}
"""


@kind("column")
def write_column(wanted: Wanted) -> str:
    """Return the text of a case file of a bubbling bed in a column."""
    return write_bed(wanted, Shape("bubbling bed in a column", SIZE, math.pi / 4.0, CELL, DOMAIN, _count_cells))


def _count_cells(size: tuple[float, ...], width: float) -> list[int]:
    across = 2 * max(1, math.floor(size[0] / (2.0 * width) + 1e-6))
    return [across, across, max(1, math.floor(size[2] / width + 1e-6))]
