"""A bubbling bed: a narrow box, a quarter full, fluidized over its whole floor at twice U_mf."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fbcouple.case.bed.drag_balance import minimum_fluidization
from fbcouple.case.kinds.registry import Wanted, kind
from fbcouple.case.kinds.writing import (
    AIR,
    BED,
    HEAD,
    TIMES,
    align,
    choose_bed,
    choose_cells,
    choose_size,
    fill_bed,
    read,
    round_to,
    write_vector,
)

SIZE = (40.0, 8.0, 100.0)
"""Width, depth and height of the box, in diameters, where none are given."""
FILLED = 0.25
"""Height of the bed at rest over that of the box."""
CELL = 2.0
"""Width of a cell that is aimed at, in diameters."""
EXCESS = 2.0
"""Superficial velocity over U_mf, where none is given."""

TEXT = """\
# A {name}, written by `fbcouple init`. All values are in SI units.
"""
TEXT += HEAD
TEXT += """
title = "{title}: {diameter_mm:.4g} mm, {density:.4g} kg/m3, gas at {velocity:.4g} m/s"
"""
TEXT += (
    TIMES
    + """
[domain]
{domain}
"""
)
TEXT += (
    AIR
    + """\
# Superficial velocity over the whole floor. {velocity_words}
inlet_velocity = {velocity:.4g}       # m s-1
"""
)
TEXT += BED
TEXT += """\
snapshots_every = 0.01          # s, of the voidage, for bubbles
particles_every = 0.25          # s, of all particles, for pictures
"""


DOMAIN = """\
size = {size}     # m: width, depth and height; z is up
# As many cells along each edge as are at least {cell:g} diameters ({cell:g} x {diameter:.4g} m) wide:
# narrower ones hold too few particles for an average, wider ones do not resolve bubbles.
cells = {cells}
# periodic = ["y"]              # in place of the walls in front and behind
"""


@dataclass(frozen=True)
class Shape:
    """What a bubbling bed is in: its name, the size [diameters] where none is given, its floor over width times depth,
    the width [diameters] of a cell, the section [domain], and the cells of a size [m] for cells of a width [m]."""

    name: str
    size: tuple[float, float, float]
    floor: float
    cell: float
    domain: str
    count_cells: Callable[[tuple[float, ...], float], list[int]]


@kind("bubbling")
def write_bubbling(wanted: Wanted) -> str:
    """Return the text of a case file of a bubbling bed in a box."""
    return write_bed(wanted, Shape("bubbling bed", SIZE, 1.0, CELL, DOMAIN, choose_cells))


def write_bed(wanted: Wanted, shape: Shape) -> str:
    """Return the text of a case file of a bubbling bed; U_mf and the overlap are those that `fbcouple check` gives."""
    trial = wanted.velocity or 1.0
    case = read(_fill(wanted, shape, trial, ""))
    onset = minimum_fluidization(case)
    velocity = wanted.velocity or round_to(EXCESS * onset)
    words = f"U_mf is {onset:.3g} m s-1"
    words = f"This is {velocity / onset:.3g} U_mf; {words}." if wanted.velocity is None else f"{words}."
    return _fill(wanted, shape, velocity, words)


def _fill(wanted: Wanted, shape: Shape, velocity: float, words: str) -> str:
    size = choose_size(wanted, shape.size, FILLED)
    bed = choose_bed(wanted, size, FILLED)
    domain = shape.domain.format(
        diameter=wanted.diameter,
        size=write_vector(size),
        cells=shape.count_cells(size, shape.cell * wanted.diameter),
        cell=shape.cell,
    )
    text = TEXT.format(
        name=shape.name,
        title=shape.name.capitalize(),
        domain=domain,
        diameter_mm=1e3 * wanted.diameter,
        velocity=velocity,
        velocity_words=words,
        **fill_bed(wanted, bed, shape.floor * size[0] * size[1]),
    )
    return align(text)
