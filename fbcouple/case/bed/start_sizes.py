"""Sizes and densities that a file of start positions gives each particle, and the kinds that they make."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fbcouple.case.bed.particle_types import find_ratio, list_kinds
from fbcouple.case.bed.start_file import ENDINGS, SAME_SIZE, StartFile, read_start
from fbcouple.case.companions import find_companion
from fbcouple.case.schema.particles import Particles
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

MOST_SIZES = 50
"""Each is a type of LIGGGHTS with a damping of its own towards every other."""

Sizes = tuple[tuple[float, float, int], ...]


class SizesError(CaseError):
    """Particles of a start have sizes or densities that no kind of the case has."""


def adopt_sizes(case: Case, folder: Path) -> Case:
    """The case with `particles.sizes` as its positions file, which lies in `folder`, says them.

    A case that says them already, or whose file cannot be read, stays as it is: the checks tell.
    """
    particles = case.particles
    if particles is None or particles.positions is None or particles.sizes:
        return case
    try:
        base_folder = case.find_folder(folder, particles.positions)
        start = read_start(find_companion(base_folder, particles.positions, ENDINGS), particles.positions_step)
        sizes = find_sizes(particles, start)
    except CaseError:
        return case  # told by check_positions
    return case.model_copy(update={"particles": particles.model_copy(update={"sizes": sizes})}) if sizes else case


def find_sizes(particles: Particles, start: StartFile) -> Sizes:
    """Diameters [m], densities [kg m-3] and numbers of the particles in a positions file, from small to large; those
    that rounding alone parts, by SAME_SIZE at most, are one.

    Empty where the file says nothing else than the case: it gives no sizes, all are the case's own, or the case has
    several kinds, one of which each particle is (match_kinds).
    Raises: CaseError (one text, without the key) if there are more sizes than kinds can be.
    """
    if (start.diameters is None and start.densities is None) or particles.mixture or particles.spread:
        return ()
    groups = _group(*(_merge(values) for values in _list_values(particles, start)))
    if len(groups.rows) > MOST_SIZES:
        text = f"the file gives {len(groups.rows)} different sizes or densities, at most {MOST_SIZES} are allowed"
        raise CaseError([f"{text} (each is a type of LIGGGHTS with its own damping); round them to that many."])
    if len(groups.rows) == 1 and np.allclose(groups.rows[0], _say_own(particles), rtol=1e-9, atol=0.0):
        return ()
    return groups.list_sizes()


def says_sizes(particles: Particles, start: StartFile) -> bool:
    """Is `particles.sizes` what a positions file says, or, as in run folders that were set up before sizes were merged,
    every different number of it? Raises: CaseError as `find_sizes`."""
    if particles.sizes == find_sizes(particles, start):
        return True
    if not particles.sizes or particles.mixture or particles.spread:
        return False
    return particles.sizes == _group(*_list_values(particles, start)).list_sizes()


def match_kinds(particles: Particles, start: StartFile) -> np.ndarray | None:
    """The kind of each particle of a positions file, int (n,) from 0; None if the file says nothing of it.

    LIGGGHTS' type says it where sizes and densities leave it open. Raises: CaseError (one text, without the key) if a
    particle is none of the case's kinds, could be several, or is not what the column `kind` says.
    """
    said = None if start.kinds is None else start.kinds - 1
    if start.diameters is None and start.densities is None:
        return _number_types(particles, start) if said is None else said
    groups = _group(*_list_values(particles, start))
    if len(groups.rows) > MOST_SIZES:
        groups = _group(*(_merge(values) for values in _list_values(particles, start)))
    rows, which = groups.rows, groups.which
    known = np.array([(kind.diameter, kind.density) for kind in list_kinds(particles)])
    columns = [start.diameters is not None, start.densities is not None]
    apart = np.abs(rows[:, None, columns] / known[None][:, :, columns] - 1.0).max(axis=2)
    best = apart.argmin(axis=1)
    if said is not None:
        best_of_all = np.minimum(said, len(known) - 1)
        wrong = np.flatnonzero((said >= len(known)) | (apart[which, best_of_all] > SAME_SIZE))
        if wrong.size:
            _refuse_ratio(particles, start, rows)
            text = f"{_word(start, int(wrong[0]))}, which kind {said[wrong[0]] + 1} of the case is not"
            raise CaseError([f"{text} ({_list_known(known)}); fix the column `kind`, or the size."])
        return said
    found = best[which]
    for row in range(len(rows)):
        first = int(groups.first[row])
        if apart[row, best[row]] > SAME_SIZE:
            _refuse_ratio(particles, start, rows)
            text = f"{_word(start, first)}, which no kind of the case has"
            raise SizesError([f"{text} ({_list_known(known)}); fix the file, or diameter, mixture and spread."])
        alike = np.flatnonzero(apart[row] == apart[row, best[row]])
        if len(alike) > 1:
            types = _number_types(particles, start)
            if types is None or not np.isin(types[which == row], alike).all():
                text = f"{_word(start, first)}, which several kinds of the case have"
                raise CaseError([f"{text} ({_list_known(known)}); add a column `kind`, numbered from 1 in this order."])
            found[which == row] = types[which == row]
    return found


def find_only_ratio(particles: Particles, start: StartFile) -> float | None:
    """Diameter of the particles of a file, all of one, over that of the case; None where nothing tells it."""
    if start.diameters is None or particles.mixture or particles.spread:
        return None
    smallest, largest = float(start.diameters.min()), float(start.diameters.max())
    return smallest / particles.diameter if largest <= smallest * (1.0 + SAME_SIZE) else None


def tell_ratios(theirs: float, ours: float) -> str:
    """That a start has particles of another coarse graining than the case, and what to do."""
    ratios = theirs, ours
    held, own = (f"parcels of l = {one:.4g}" if is_coarse(one) else "particles (l = 1)" for one in ratios)
    text = f"it holds {held} and the case has {own} (particles.coarse_graining)"
    return f'{text}; start from a run or file of the same ratio, or pour (start.method = "pour").'


def is_coarse(ratio: float) -> bool:
    """Are parcels of this `ratio` other than particles, rounding apart?"""
    return abs(ratio - 1.0) > SAME_SIZE


def _refuse_ratio(particles: Particles, start: StartFile, rows: np.ndarray) -> None:
    """Raise SizesError if `rows` (k, 2) of a file are the kinds of a coarse-grained bed, by another ratio."""
    ours = find_ratio(particles)
    if start.diameters is None or not is_coarse(ours):
        return
    known = np.array([(kind.grain_diameter, kind.density) for kind in list_kinds(particles)])
    columns = [True, start.densities is not None]
    for ratio in rows[0, 0] / known[:, 0]:
        scaled = known * (ratio, 1.0)
        apart = np.abs(rows[:, None, columns] / scaled[None][:, :, columns] - 1.0).max(axis=2).min(axis=1)
        if is_coarse(ratio / ours) and (apart <= SAME_SIZE).all():
            raise SizesError([tell_ratios(float(ratio), ours)])


def _number_types(particles: Particles, start: StartFile) -> np.ndarray | None:
    """LIGGGHTS' types as kinds from 0: type 1 is the first kind; of one kind alone they may be called anything."""
    if start.types is None:
        return None
    alone = len(list_kinds(particles)) == 1 and (start.types == start.types[0]).all()
    return np.zeros(len(start.types), int) if alone else start.types - 1


def _say_own(particles: Particles) -> tuple[float, float]:
    """Diameter [m], of parcels theirs, and density [kg m-3] that the case gives."""
    return find_ratio(particles) * particles.diameter, particles.density


def _list_values(particles: Particles, start: StartFile) -> tuple[np.ndarray, np.ndarray]:
    """Diameter [m] and density [kg m-3] of each particle, (n,): those of the case where the file does not say them."""
    count = len(start.positions)
    diameters = np.full(count, _say_own(particles)[0]) if start.diameters is None else start.diameters
    return diameters, np.full(count, particles.density) if start.densities is None else start.densities


def _merge(values: np.ndarray) -> np.ndarray:
    """The values with those that lie within SAME_SIZE of each other, and apart from all others, replaced by their
    mean."""
    known, which, counts = np.unique(values, return_inverse=True, return_counts=True)
    cuts = np.flatnonzero(np.diff(known) > SAME_SIZE * known[:-1]) + 1
    merged = known.copy()
    for first, last in zip([0, *cuts], [*cuts, len(known)], strict=True):
        if last - first > 1 and known[last - 1] <= known[first] * (1.0 + SAME_SIZE):
            merged[first:last] = np.average(known[first:last], weights=counts[first:last])
    return merged[which.ravel()]


@dataclass(frozen=True)
class Groups:
    """Different pairs of diameter [m] and density [kg m-3], from small to large: `rows` (k, 2), how many particles have
    each, `counts` (k,), the first that has it, `first` (k,), and the pair of each particle, `which` (n,)."""

    rows: np.ndarray
    counts: np.ndarray
    first: np.ndarray
    which: np.ndarray

    def list_sizes(self) -> Sizes:
        """Diameter, density and number of each pair."""
        rows = zip(self.rows.tolist(), self.counts.tolist(), strict=True)
        return tuple((diameter, density, count) for (diameter, density), count in rows)


def _group(diameters: np.ndarray, densities: np.ndarray) -> Groups:
    pairs, first, which, counts = np.unique(
        np.stack([diameters, densities], axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    return Groups(pairs, counts, first, which.ravel())


def _word(start: StartFile, row: int) -> str:
    diameter = "" if start.diameters is None else f"{start.diameters[row]:g} m"
    density = "" if start.densities is None else f"{start.densities[row]:g} kg m-3"
    return f"particle {row + 1} has {' and '.join(filter(None, (diameter, density)))}"


def _list_known(known: np.ndarray) -> str:
    shown = ", ".join(f"{n}: {d:g} m and {density:g} kg m-3" for n, (d, density) in enumerate(known[:8], start=1))
    return f"{shown}, ..." if len(known) > 8 else shown
