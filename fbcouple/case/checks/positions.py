"""Whether a file of start positions fits its case: as many particles, of its kinds, inside and clear of each other."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fbcouple.case.bed.derived import wraps
from fbcouple.case.bed.particle_types import (
    count_kinds,
    find_ratio,
    grains_per_parcel,
    largest_diameter,
    list_kinds,
    particle_count,
    word_one,
)
from fbcouple.case.bed.passing import find_in_openings
from fbcouple.case.bed.positions import bring_in, start_kinds
from fbcouple.case.bed.region import read_mesh
from fbcouple.case.bed.start_file import ENDINGS, StartFile, read_start
from fbcouple.case.bed.start_sizes import (
    Sizes,
    SizesError,
    find_only_ratio,
    find_sizes,
    is_coarse,
    match_kinds,
    says_sizes,
    tell_ratios,
)
from fbcouple.case.checks.bed import try_region
from fbcouple.case.checks.mixture import KEYS
from fbcouple.case.checks.registry import BED, check, has_bed
from fbcouple.case.companions import find_companion
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.input_files.units import guess_frame

WALL_OVERLAP = START_OVERLAP = 0.1
"""Part of a diameter by which a start position may press into a wall or another one (resting contacts do, a little)."""
_KEY = "particles.positions"


@check(_KEY, "domain.periodic", "domain.shape", *BED, *KEYS)
def check_positions(case: Case, folder: Path) -> Iterator[Problem]:
    """The positions file lies beside the case and holds every particle, inside the region and clear of the others."""
    if case.particles is None:
        return
    if case.particles.positions is None:
        if case.particles.positions_step is not None:
            yield Problem(f"{_KEY}_step", "a time step is given and no positions; remove it, or name the dump.")
        if case.particles.positions_seed is not None and not (case.start and case.start.is_made):
            text = "a seed is given and no positions; remove it, or give start.seed, which a lattice is shifted by."
            yield Problem(f"{_KEY}_seed", text)
        return
    try:
        name = case.particles.positions
        path = find_companion(case.find_folder(folder, name), name, ENDINGS)
        start = read_start(path, case.particles.positions_step)
        problems = [] if says_sizes(case.particles, start) else [_tell_sizes(case, find_sizes(case.particles, start))]
    except CaseError as error:
        yield from (Problem(_KEY, problem) for problem in error.problems)
        return
    try:
        numbers = list(_check_number(case, start))
        _check_ratio(case, start, bool(numbers))
        problems += [*numbers, *_check_kinds(case, start)]
    except SizesError as error:  # how many there are is another question
        problems += [Problem(_KEY, f"{case.particles.positions}: {problem}") for problem in error.problems]
    yield from problems
    if problems or not has_bed(case):
        return
    diameters = np.array([kind.diameter for kind in list_kinds(case.particles)])[start_kinds(case, folder)]
    positions = bring_in(case, start.positions)
    outside = list(_find_outside(case, folder, positions, diameters))
    yield from outside or _find_overlap(case, positions, diameters)


def _tell_sizes(case: Case, sizes: Sizes) -> Problem:
    """`particles.sizes` is not what the file says, and is not left to it."""
    assert case.particles is not None
    given, found = (show(rows) if rows else "nothing" for rows in (case.particles.sizes, sizes))
    text = f"{given} is given and {case.particles.positions} says {found}"
    return Problem("particles.sizes", f"{text}; remove it (it follows from the file), or fix the file.")


def _check_ratio(case: Case, start: StartFile, is_number_wrong: bool) -> None:
    """A file that gives one size for all does not hold the particles of a coarse-grained bed in place of its parcels.
    Raises: SizesError if it does, or where the number is wrong those of another ratio."""
    assert case.particles is not None
    theirs, ours = find_only_ratio(case.particles, start), find_ratio(case.particles)
    if not is_coarse(ours) or theirs is None or not is_coarse(theirs / ours):
        return
    if is_number_wrong or not is_coarse(theirs):
        raise SizesError([tell_ratios(theirs, ours)])


def _check_number(case: Case, start: StartFile) -> Iterator[Problem]:
    """The file has as many particles as the case, or as much mass."""
    particles, held = case.particles, len(start.positions)
    assert particles is not None
    if not has_bed(case):
        return
    grains, what = grains_per_parcel(particles), f"{word_one(particles)}s"
    mend = f"give particles.count = {round(held * grains)} (in place of mass) or fix the file."
    if particles.count is None and particles.sizes:
        mass = sum(kind.mass * count for kind, count in zip(list_kinds(particles), count_kinds(particles), strict=True))
        assert particles.mass is not None
        if abs(mass - particles.mass) > 0.5 * mass / held:
            text = f"{particles.positions} holds {held} {what} of {mass:.6g} kg and the case {particles.mass:g} kg"
            yield Problem(_KEY, f"{text}; {mend}")
    elif held != (wanted := particle_count(particles) if particles.count is None else round(particles.count / grains)):
        yield Problem(_KEY, f"{particles.positions} holds {held} {what} and the case {wanted}; {mend}")


def _check_kinds(case: Case, start: StartFile) -> Iterator[Problem]:
    """Each particle is of a kind of the case, and there are as many of each. Raises: SizesError if one is of none."""
    particles = case.particles
    assert particles is not None
    try:
        found = match_kinds(particles, start)
    except SizesError:
        raise
    except CaseError as error:
        yield from (Problem(_KEY, f"{particles.positions}: {problem}") for problem in error.problems)
        return
    if found is None or not has_bed(case):
        return
    counts = count_kinds(particles)
    held = np.bincount(found, minlength=len(counts)).tolist()
    if len(found) == sum(counts) and held != counts:
        what = f"{word_one(particles)}s of each kind"
        text = f"{particles.positions} holds {show(held)} {what} and the case {show(counts)}"
        yield Problem(_KEY, f"{text}; fix the fractions of the mixture, or fix the file.")


def _find_outside(case: Case, folder: Path, positions: np.ndarray, diameters: np.ndarray) -> Iterator[Problem]:
    """Particles that are not inside the region, or press into a wall."""
    margins = (0.5 - WALL_OVERLAP) * diameters
    size = np.array(case.domain.size)
    if case.domain.shape == "box":
        walls = np.where(wraps(case.domain), 0.0, margins[:, None])
        outside = np.flatnonzero(((positions < walls) | (positions > size - walls)).any(axis=1))
    elif try_region(case, folder) is None:
        return  # told by check_mesh
    else:
        outside = _find_outside_mesh(case, folder, positions, margins)
    outside = outside[~find_in_openings(case, folder, positions[outside], margins[outside])]
    if not outside.size:
        return
    assert case.particles is not None
    row = int(outside[0])
    region = "box" if case.domain.shape == "box" else "mesh" if case.domain.shape == "file" else case.domain.shape
    text = f"{case.particles.positions}: {outside.size} particles are not inside the {region}"
    end = f"its centre may come as near as {margins[row]:g} m to a wall"
    if any(wraps(case.domain)):
        end += f", and lie up to {largest_diameter(case.particles):g} m over a periodic side"
    end += ", coordinates are in m"
    guess = guess_frame(positions.min(axis=0).tolist(), positions.max(axis=0).tolist(), size.tolist())
    if find_in_openings(case, folder, positions[outside], margins[outside], math.inf).all():
        guess = "; they are in an opening that is shut at first: give its row of particles.outlets start = 0"
    yield Problem(_KEY, f"{text}, first is {_format_particle(positions, row)}; {end}{guess}.")


def _find_outside_mesh(case: Case, folder: Path, positions: np.ndarray, margins: np.ndarray) -> np.ndarray:
    from fbcouple.case.bed.region_lattice import Inside  # noqa: PLC0415  (loads numba)

    inside = Inside(read_mesh(case, folder))
    clear = np.zeros(len(positions), bool)
    for margin in np.unique(margins):
        rows = np.flatnonzero(margins == margin)
        clear[rows] = inside.is_clear(positions[rows], float(margin))
    return np.flatnonzero(~clear)


def _find_overlap(case: Case, positions: np.ndarray, diameters: np.ndarray) -> Iterator[Problem]:
    """Particles that press into each other, across a periodic side too, fly apart in the first step."""
    from fbcouple.geometry.overlap import add_images, find_worst_overlap  # noqa: PLC0415  (loads numba)

    assert case.particles is not None
    period = np.where(wraps(case.domain), case.domain.size, 0.0)
    points, rows = add_images(positions, period, float(diameters.max()))
    overlap, one, other = find_worst_overlap(points, diameters[rows] / 2, len(positions))
    if overlap <= START_OVERLAP:
        return
    across = " across a periodic side" if max(one, other) >= len(positions) else ""
    words = " and ".join(_format_particle(positions, int(row)) for row in sorted((rows[one], rows[other])))
    told = f"overlap{across} by {overlap:.3g} of their mean diameter, at most {START_OVERLAP} is allowed"
    if overlap == 1.0:
        told = f"are at one place{across}"
    text = f"{case.particles.positions}: {words} {told}"
    yield Problem(_KEY, f"{text}; move them apart (coordinates in m), or remove one.")


def _format_particle(positions: np.ndarray, row: int) -> str:
    return f"particle {row + 1} at ({', '.join(f'{x:g}' for x in positions[row])}) m"
