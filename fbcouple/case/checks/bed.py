"""Whether the particles of a case, their sizes and their start fit into its box, and the run into this machine."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from fbcouple.case.bed.lattice import find_start_box, is_layered, lattice_height, lay_out, mixed_height
from fbcouple.case.bed.particle_types import (
    find_ratio,
    grains_per_parcel,
    largest_diameter,
    mean_density,
    mean_volume,
    particle_count,
    word_count,
    word_one,
)
from fbcouple.case.bed.region import Region, find_region
from fbcouple.case.checks.mixture import check_counts, check_species
from fbcouple.case.checks.registry import (
    BED,
    MOST,
    check,
    has_bed,
    machine_memory,
)
from fbcouple.case.cost.coefficients import SHIPPED
from fbcouple.case.cost.memory import find_memory
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

RANDOM_PACKING = 0.64
"""Solids fraction of a random close packing of equal spheres: no start can hold more."""
_SLACK = 1e-9
LEAST_PERIOD = 2.5
"""Diameters along a periodic axis: below 2 a particle could touch another one and its image at once, whose contacts
would be one to LIGGGHTS, which knows them by the particles' numbers."""


def try_region(case: Case, folder: Path) -> Region | None:
    """The region of the case; None if its mesh cannot be read, which is told elsewhere."""
    try:
        return find_region(case, folder)
    except CaseError:
        return None


def _find_volume(case: Case, folder: Path) -> float:
    """Volume [m3] that particles may fill; it asks for no cells."""
    if case.domain.shape == "file":
        region = try_region(case, folder)
        return region.volume if region else math.inf
    return math.prod(case.domain.size) * (math.pi / 4.0 if case.domain.shape == "cylinder" else 1.0)


@check("particles.diameter", "domain.size")
def check_diameter(case: Case, folder: Path) -> Iterator[Problem]:
    """The box is at least one diameter wide in every direction."""
    if case.particles is None:
        return
    size, axis = min(zip(case.domain.size, "xyz", strict=True))
    if (diameter := largest_diameter(case.particles)) > size * (1 + 1e-9):
        key, text = "particles.diameter", f"{diameter:g} m is given"
        mend = "give a smaller particle (in m: 1 mm is 1e-3) or a larger box."
        if (ratio := find_ratio(case.particles)) != 1.0:
            key, text = "particles.coarse_graining", f"{ratio:g} is given, so that a parcel has {diameter:g} m"
            mend = "give a smaller one, or a larger box."
        where = f"the box is {size:g} m along {axis} (domain.size)"
        yield Problem(key, f"{text}, but {where}, at most that is allowed; {mend}")


@check("particles.diameter", "domain.size", "domain.periodic")
def check_periodic(case: Case, folder: Path) -> Iterator[Problem]:
    """An axis is periodic once, and so long that no particle meets another one and its image."""
    key, axes = "domain.periodic", case.domain.periodic
    if len(set(axes)) < len(axes):
        yield Problem(key, f"{show(axes)} is given; name each axis once.")
    if case.particles is None:
        return
    for axis in dict.fromkeys(axes):
        size, least = case.domain.size["xyz".index(axis)], LEAST_PERIOD * largest_diameter(case.particles)
        if size < least * (1 - 1e-9):
            text = f"{axis} is given, and the box is {size:g} m along it, at least {least:g} m is allowed"
            yield Problem(key, f"{text} ({LEAST_PERIOD} diameters); enlarge domain.size or leave walls there.")


@check("domain.shape", *BED)
def check_packing(case: Case, folder: Path) -> Iterator[Problem]:
    """At least one particle, and not more than a random packing of the box holds."""
    if not has_bed(case):
        return
    assert case.particles is not None
    key = "particles.mass" if case.particles.count is None else "particles.count"
    count = particle_count(case.particles)
    most = RANDOM_PACKING * _find_volume(case, folder) / mean_volume(case.particles)
    if count < 1 and not case.particles.feeds:
        given = f"the mass is less than that of half a {word_one(case.particles)}; give the mass of the bed in kg"
        if case.particles.count is not None:
            few = f"{case.particles.count:g} is given"
            if case.particles.count:
                few = f"{few}, less than half a parcel of {grains_per_parcel(case.particles):g} particles,"
            given = f"{few} and no particles.feeds, by which some would come; give a number, or a feed, or for gas "
            given += "alone leave [particles] and what goes with them out"
        yield Problem(key, f"{given}.")
    elif count > most:
        heaviest = most * mean_volume(case.particles) * mean_density(case.particles)
        held = math.floor(most)
        parcels = "" if case.particles.coarse_graining is None else f"{held:.6g} parcels, "
        text = f"{word_count(case.particles, count)} do not fit into the box: {RANDOM_PACKING} of its volume holds "
        text += f"{held * grains_per_parcel(case.particles):.6g} ({parcels}{heaviest:.4g} kg)"
        larger = "enlarge domain.size"
        if case.domain.shape == "file":
            larger = "take a larger mesh (domain.scale if it is in another unit)"
        yield Problem(key, f"{text}; give less, in kg or particles, or {larger}.")


@check(*BED)
def check_mixture(case: Case, folder: Path) -> Iterator[Problem]:
    """No kind of particle is so rare that there is none."""
    if has_bed(case) and not next(check_packing(case, folder), None):
        yield from check_counts(case)


@check("contact.pairs", "contact.walls", "particles.mixture")
def check_rows(case: Case, folder: Path) -> Iterator[Problem]:
    """The rows of [contact] name species that are there."""
    if case.contact is not None and case.particles is not None:
        yield from check_species(case)


@check(*BED, "domain", "start.region")
def check_start_region(case: Case, folder: Path) -> Iterator[Problem]:
    """What the start fills lies in the bed, and a particle fits into it."""
    if case.start is None or case.start.region is None or case.particles is None:
        return
    region, diameter = try_region(case, folder), largest_diameter(case.particles)
    corner = region.corner if region else (0.0, 0.0, 0.0)
    for axis, (low, high), first, size in zip("xyz", case.start.region, corner, case.domain.size, strict=True):
        last = first + size
        if high - low < diameter * (1 - 1e-9):
            text = f"{low:g} to {high:g} m is given along {axis}, the largest particle is {diameter:g} m wide"
            yield Problem("start.region", f"{text}; give the lower end first, and room for a particle.")
        elif low < first - _SLACK * size or high > last + _SLACK * size:
            text = f"{low:g} to {high:g} m is given along {axis}, {first:g} to {last:g} m is allowed"
            yield Problem("start.region", f"{text}; give a part of the bed, in m.")


@check(*BED, "start.spacing", "start.region", "particles.positions")
def check_lattice(case: Case, folder: Path) -> Iterator[Problem]:
    """The start lattice is not higher than the box; in another region `setup` looks for its sites."""
    if case.domain.shape != "box" or not has_bed(case) or case.start is None or case.start.is_made:
        return
    if next(check_packing(case, folder), None):
        return
    height, top = lattice_height(case), float(find_start_box(case)[1][2])
    layout = lay_out(case)
    if height > top * (1 + 1e-9):
        lattice = f"the lattice of {layout.columns} x {layout.rows} sites is {height:.4g} m high"
        if is_layered(case):
            lattice = f"the lattice of layers of one kind each is {height:.4g} m high (one that mixes the kinds "
            lattice += f"{mixed_height(case):.4g} m)"
        room, larger = ("the box", "domain.size") if case.start.region is None else ("start.region", "start.region")
        text = f"{case.start.spacing:g} is given; {lattice} and {room} {top:g} m"
        yield Problem("start.spacing", f"{text}; lower the spacing (above 1) or the bed, or raise {larger}.")
    elif layout.columns * layout.rows > 2**62:
        yield Problem("domain.size", "the floor holds more lattice sites than can be counted; give sizes in m.")


@check("domain.cells", "domain.shape", *BED)
def check_size(case: Case, folder: Path) -> Iterator[Problem]:
    """Cells can be numbered, and the run fits into the memory of this machine."""
    region = try_region(case, folder)
    if region is None:
        return
    cells = region.cells
    if cells > MOST:
        text = f"{cells:.3g} cells are given ({SHIPPED.cell_memory * cells / 1e9:.3g} GB)"
        text = f"{text}, at most {MOST:.1g} are allowed"
        yield Problem("domain.cells", f"{text}; give fewer.")
    if case.particles is not None and (not has_bed(case) or next(check_packing(case, folder), None)):
        return
    count = particle_count(case.particles) if case.particles else 0
    if count > MOST:
        assert case.particles is not None
        key = "particles.mass" if case.particles.count is None else "particles.count"
        text = f"{word_count(case.particles, count, 3)} need about {SHIPPED.particle_memory * count / 1e9:.3g} GB"
        what = word_one(case.particles)
        yield Problem(key, f"{text}, at most {MOST:.1g} {what}s are allowed; give fewer, or a larger diameter.")
    needed, held = find_memory(case, folder), machine_memory()
    if needed > held and max(cells, count) <= MOST:
        key = "domain.cells" if cells * SHIPPED.cell_memory > count * SHIPPED.particle_memory else "particles"
        counted = word_count(case.particles, count, 3) if case.particles else "0 particles"
        text = f"{cells:.3g} cells and {counted} need about {needed / 1e9:.3g} GB"
        yield Problem(key, f"{text}, this machine has {held / 1e9:.3g} GB; give fewer or take a larger machine.")
