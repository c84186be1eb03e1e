"""A riser: an empty shaft, fed at its bottom, whose gas carries all particles out of the top."""

from __future__ import annotations

from fbcouple.case.bed.drag_balance import terminal_velocity
from fbcouple.case.kinds.registry import Wanted, kind
from fbcouple.case.kinds.writing import (
    AIR,
    CONTACT,
    HEAD,
    MATERIAL,
    OUTPUT,
    OVERLAP,
    TIMES,
    align,
    choose_cells,
    choose_size,
    read,
    round_to,
    write_vector,
)
from fbcouple.errors import CaseError

SIZE = (20.0, 20.0, 200.0)
"""Width, depth and height of the shaft, in diameters, where none are given."""
CELL = 2.5
"""Width of a cell that is aimed at, in diameters."""
EXCESS = 1.5
"""Gas velocity over the terminal velocity of a particle, where none is given."""
SOLIDS = 0.02
"""Mean solids fraction that the feed is chosen for."""
FED = 0.05
"""Height of the box that is fed over that of the shaft."""

TEXT = """\
# A riser, written by `fbcouple init`. All values are in SI units.
"""
TEXT += HEAD
TEXT += """
title = "Riser: {diameter_mm:.4g} mm, {density:.4g} kg/m3, gas at {velocity:.4g} m/s"
"""
TEXT += (
    TIMES
    + """
[domain]
size = {size}     # m: width, depth and height; z is up
# As many cells along each edge as are at least {cell:g} diameters ({cell:g} x {diameter:.4g} m) wide.
cells = {cells}
# periodic = ["x", "y"]         # in place of the walls: a part of a wide riser

"""
)
TEXT += (
    AIR
    + """\
# Superficial velocity over the whole floor. {velocity_words}
inlet_velocity = {velocity:.4g}       # m s-1
"""
)
TEXT += (
    MATERIAL
    + """\
count = 0                       # an empty start
rotation = true

# Particles appear at random places of this box. Another table [[particles.feeds]] feeds elsewhere, or another species.
[[particles.feeds]]
low = [0.0, 0.0, 0.0]           # m
high = {fed}      # m
# For a solids fraction of {solids:g} at the gas velocity less the terminal velocity.
mass_flow = {flow:.4g}          # kg s-1
velocity = [0.0, 0.0, {rise:.3g}]    # m s-1

[[particles.outlets]]
face = "top"                    # all that reach the open top leave
"""
)
TEXT += CONTACT
TEXT += """
[start]
"""
TEXT += OUTPUT
TEXT += """\
particles_every = 0.05          # s, of all particles, for pictures
"""


@kind("riser")
def write_riser(wanted: Wanted) -> str:
    """Return the text of a case file of a riser; `wanted.velocity` is that of the gas.

    Raises: CaseError if a height of a bed is wanted, which a riser has not, or if the gas carries no particle up.
    """
    if wanted.bed_height is not None:
        raise CaseError(["init: --bed-height: a riser starts empty; leave it out, or choose another --kind."])
    settling = terminal_velocity(read(_fill(wanted, 1.0, 1.0, "")))
    velocity = wanted.velocity or round_to(EXCESS * settling)
    if velocity <= settling:
        text = f"--velocity: {velocity:g} m s-1 is given, more than {settling:.4g} m s-1 is allowed"
        raise CaseError([f"init: {text}, the terminal velocity of a particle; give a faster gas or smaller particles."])
    words = f"This is {velocity / settling:.3g} times the terminal velocity, {settling:.3g} m s-1."
    rise = velocity - settling
    return _fill(wanted, velocity, rise, words)


def _fill(wanted: Wanted, velocity: float, rise: float, words: str) -> str:
    size = choose_size(wanted, SIZE, 1.0)
    width, depth, height = size
    text = TEXT.format(
        diameter=wanted.diameter,
        diameter_mm=1e3 * wanted.diameter,
        density=wanted.density,
        size=write_vector(size),
        cells=choose_cells(size, CELL * wanted.diameter),
        cell=CELL,
        velocity=velocity,
        velocity_words=words,
        fed=write_vector((width, depth, max(FED * height, 2.0 * wanted.diameter))),
        solids=SOLIDS,
        flow=wanted.density * SOLIDS * rise * width * depth,
        rise=rise,
        overlap=OVERLAP,
    )
    return align(text)
