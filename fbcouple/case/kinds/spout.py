"""A spouted bed: a flat box with a slot across the middle of its floor, and a jet that carries the bed up there."""

from __future__ import annotations

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

SIZE = (60.0, 8.0, 200.0)
"""Width, depth and height of the box, in diameters, where none are given."""
SLOT = 0.13
"""Width of the slot over that of the box."""
FILLED = 0.2
"""Height of the bed at rest over that of the box."""
CELL = 2.0
"""Width of a cell that is aimed at, in diameters."""
EXCESS = 1.3
"""Superficial velocity in the column over U_mf, where no velocity of the jet is given."""

TEXT = """\
# A spouted bed, written by `fbcouple init`. All values are in SI units.
"""
TEXT += HEAD
TEXT += """
title = "Spouted bed: {diameter_mm:.4g} mm, {density:.4g} kg/m3, jet at {velocity:.4g} m/s"
"""
TEXT += (
    TIMES
    + """
[domain]
size = {size}     # m: width, depth and height; z is up
# As many cells along each edge as are at least {cell:g} diameters ({cell:g} x {diameter:.4g} m) wide.
cells = {cells}

"""
)
TEXT += (
    AIR
    + """
# The jet: a slot right across the middle of the floor. It need not follow the cells; all else of the floor is wall.
# Another table [[gas.inlets]] adds an inlet; one that lies on another has its place.
[[gas.inlets]]
rectangle = [[{left:.6g}, 0.0], [{right:.6g}, {depth:.6g}]]     # m: x and y of two corners
# Times and superficial velocities over the slot. {velocity_words}
ramp = [[0.0, 0.0], [0.05, {velocity:.4g}]]     # s, m s-1
"""
)
TEXT += BED
TEXT += """\
snapshots_every = 0.01          # s, of the voidage
particles_every = 0.25          # s, of all particles, for pictures
"""


@kind("spout")
def write_spout(wanted: Wanted) -> str:
    """Return the text of a case file of a spouted bed; `wanted.velocity` is that of the jet."""
    onset = minimum_fluidization(read(_fill(wanted, wanted.velocity or 1.0, "")))
    velocity = wanted.velocity or round_to(EXCESS * onset / SLOT)
    words = f"In the column the last is {velocity * SLOT / onset:.3g} U_mf; U_mf is {onset:.3g} m s-1."
    return _fill(wanted, velocity, words)


def _fill(wanted: Wanted, velocity: float, words: str) -> str:
    size = choose_size(wanted, SIZE, FILLED)
    bed = choose_bed(wanted, size, FILLED)
    width, depth, _ = size
    text = TEXT.format(
        diameter_mm=1e3 * wanted.diameter,
        size=write_vector(size),
        cells=choose_cells(size, CELL * wanted.diameter),
        cell=CELL,
        left=0.5 * width * (1.0 - SLOT),
        right=0.5 * width * (1.0 + SLOT),
        depth=depth,
        velocity=velocity,
        velocity_words=words,
        **fill_bed(wanted, bed, width * depth),
    )
    return align(text)
