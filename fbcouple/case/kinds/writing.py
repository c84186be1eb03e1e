"""What the kinds of new cases have in common: how their text looks, and numbers that are chosen alike."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence

from fbcouple.case.bed.adopt_inlets import adopt_inlets
from fbcouple.case.bed.speeds import SETTLED
from fbcouple.case.kinds.registry import Wanted
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

HEAD = """\
# `fbcouple options` lists every option, `fbcouple options gas.walls` one of them.
# For completion in an editor with Taplo, write the schema beside this file with
# `fbcouple options --schema > fbcouple.schema.json` and make this the first line: #:schema ./fbcouple.schema.json
"""
TIMES = """\
end_time = 2.0                  # s; try the case first with --set end_time=0.1
accuracy = "standard"           # steps and tolerances: "draft" is faster, "reference" finer
"""
AIR = """\
[gas]                           # air at 20 degrees Celsius and 1 bar
density = 1.2                   # kg m-3
viscosity = 1.8e-5              # Pa s
"""
MATERIAL = """
[particles]
diameter = {diameter:.6g}               # m
density = {density:.6g}                  # kg m-3, of the material
"""
PARTICLES = """\
# Mass for a bed at rest that is {bed:.4g} m high, at a solids fraction of {settled:g}.
mass = {mass:.4g}               # kg
rotation = true
"""
CONTACT = """
[contact]
# The normal spring is the one by which two particles overlap so far, in diameters, at the fastest speed that they
# can have (`fbcouple check` gives both): a softer one takes longer steps.
max_overlap = {overlap:g}
restitution = 0.9
wall_restitution = 0.9
friction = 0.3
wall_friction = 0.3
"""
START = """
[start]                         # a loose lattice, shifted at random; it settles in the first 0.2 s
"""
OUTPUT = """
[exchange]
drag = "huilin-gidaspow"
filter_passes = 1               # smooths what particles give to cells that are less than 3 diameters wide

[averages]
start = 0.5                     # s: what happens before is the start-up

[output]
record_every = 0.01             # s, between rows of the history: bed height, pressure drop ...
"""
BED = MATERIAL + PARTICLES + CONTACT + START + OUTPUT
"""From the particles to the output, the same for all kinds of beds that start at rest."""
OVERLAP = 0.03
"""Overlap of a contact in diameters."""
COLUMN = 32
"""Column of the comments behind values."""
HIGHEST = 0.8
"""Most of the height of the box that a bed at rest may fill."""


def align(text: str) -> str:
    """Put the comments behind values into their column."""
    return "\n".join(map(_align_line, text.split("\n")))


def _align_line(line: str) -> str:
    value, mark, comment = line.partition("  #")
    return f"{value.rstrip() + '  ':<{COLUMN}}# {comment.strip()}" if mark and not line.startswith("#") else line


def read(text: str) -> Case:
    """The case that a text describes."""
    return adopt_inlets(Case.model_validate(tomllib.loads(text)))


def write_vector(values: Sequence[float]) -> str:
    """Lengths as a case file has them."""
    return f"[{', '.join(f'{value:.6g}' for value in values)}]"


def round_to(value: float, digits: int = 2) -> float:
    """To so many digits that tell."""
    return float(f"{value:.{digits}g}")


def choose_size(wanted: Wanted, edges: Sequence[float], filled: float) -> tuple[float, ...]:
    """Edges of the box [m]: those that are wanted, else so many diameters, and high enough for the wanted bed to fill
    the part `filled` of it."""
    if wanted.size is not None:
        return wanted.size
    width, depth, height = (edge * wanted.diameter for edge in edges)
    if wanted.bed_height is not None:
        height = max(height, wanted.bed_height / filled)
    return tuple(round_to(edge, 3) for edge in (width, depth, height))


def choose_bed(wanted: Wanted, size: Sequence[float], filled: float) -> float:
    """Height [m] of the bed at rest: the one that is wanted, else the part `filled` of the box.

    Raises: CaseError if it leaves too little room above itself.
    """
    bed, highest = wanted.bed_height or filled * size[2], HIGHEST * size[2]
    if bed > highest:
        text = f"--bed-height: {bed:g} m is given, at most {highest:g} m is allowed in a box {size[2]:g} m high"
        raise CaseError([f"init: {text}; a bed needs room above it: give a lower bed or a higher box."])
    return bed


def fill_bed(wanted: Wanted, bed: float, floor: float) -> dict[str, float]:
    """What `BED` asks for, of a bed of the height `bed` [m] at rest on a `floor` [m2]."""
    return {
        "diameter": wanted.diameter,
        "density": wanted.density,
        "bed": bed,
        "settled": SETTLED,
        "mass": wanted.density * SETTLED * bed * floor,
        "overlap": OVERLAP,
    }


def choose_cells(size: Sequence[float], least: float) -> list[int]:
    """As many cells along each edge as are at least `least` [m] wide."""
    return [max(1, math.floor(edge / least + 1e-6)) for edge in size]
