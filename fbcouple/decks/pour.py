"""Pour the particles of a case: they rain in at random places and settle by the contacts of the case.

What does not find room at once is poured onto what has settled before. The places are random, of the start's seed; the
settling is LIGGGHTS' own on one rank: the same case gives the same bed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

import numpy as np

from fbcouple.case.bed.derived import dem_step, wraps
from fbcouple.case.bed.particle_types import draw_kinds, list_kinds, word_one
from fbcouple.case.bed.region import Region, find_region, read_mesh
from fbcouple.case.schema.particles import Start
from fbcouple.case.schema.sections import Case
from fbcouple.decks.alone import Particles, Rest, settle
from fbcouple.errors import CaseError
from fbcouple.geometry.insertion import Clear, insert

VERSION = 2
"""Of what is done here: a change of the bed that comes out is another one."""
LOOSE = 0.2
"""Solids fraction of the rain."""
_REST = 0.01
"""Speed of particles at rest over sqrt(g d)."""
_EVERY = 30.0
_LOOK = 0.5
"""Time between two looks at the speeds over sqrt(d/g)."""


@dataclass(frozen=True)
class Poured:
    """A bed at rest: particles, time [s] that it took to settle, speed [m/s] at its end, parts poured."""

    particles: Particles
    time: float
    speed: float
    parts: int


def find_rest_speed(case: Case, start: Start) -> float:
    """Speed [m/s], by the root mean square, below which the particles are at rest."""
    assert case.particles is not None
    smallest = min(kind.diameter for kind in list_kinds(case.particles))
    return start.rest_speed or _REST * math.sqrt(case.gravity * smallest)


def pour(case: Case, folder: Path, say: Callable[[str], None] = lambda text: None) -> Poured:
    """Pour the particles of a case whose own files lie in `folder`; `say` is told now and then how far they are.

    Where the last of them find no room under the lid of a box they are poured without it; whether the bed fits under
    it in the end is for the checks of start positions to say.

    Raises: CaseError (one text) if there is no room for them, or they do not come to rest within `start.settle_limit`;
    SolverError if LIGGGHTS fails.
    """
    particles, start, contact = case.particles, case.start, case.contact
    assert particles is not None and start is not None and contact is not None
    generator = np.random.default_rng([start.seed, VERSION])
    rain, step, is_open = _Rain(case, folder, generator), dem_step(contact, particles), False
    smallest = min(kind.diameter for kind in list_kinds(particles))
    every = max(1, math.ceil(_LOOK * math.sqrt(smallest / case.gravity) / step))
    rest = Rest(find_rest_speed(case, start), math.ceil(start.settle_limit / step), every)
    bed = Particles(np.empty((0, 3)), np.empty((0, 6)), np.empty(0, int))
    waiting, time, speed, parts = draw_kinds(particles, start.seed), 0.0, 0.0, 0
    while len(waiting):
        fallen = rain.fall(bed, waiting)
        if fallen is None and case.domain.shape == "box" and not is_open:
            case, is_open = _lift_lid(case), True
            rain = _Rain(case, folder, generator)
            fallen = rain.fall(bed, waiting)
        if fallen is None:
            what = f"{word_one(particles)}s"
            text = f"{len(waiting)} {what} find no room above the {len(bed.positions)} that have settled"
            raise CaseError([f"start.method: {text}; give fewer, or a higher box."])
        placed, waiting = fallen
        outcome = settle(case, folder, _join(bed, placed), rest, _Teller(say, len(waiting), step, rest.speed))
        bed, parts = outcome.particles, parts + 1
        time, speed = time + outcome.steps * step, outcome.speed
        if speed >= rest.speed:
            text = f"the bed is not at rest after {start.settle_limit:g} s: its particles have {speed:.3g} m/s"
            mend = "give it longer, or a higher start.rest_speed; without friction that remembers, a bed creeps"
            raise CaseError([f"start.settle_limit: {text}, below {rest.speed:.3g} m/s is at rest; {mend}."])
    still = Particles(bed.positions, np.zeros_like(bed.motion), bed.kinds)
    return Poured(still, time, speed, parts)


def _lift_lid(case: Case) -> Case:
    """The case in a box twice as high."""
    width, depth, height = case.domain.size
    domain = case.domain.model_copy(update={"size": (width, depth, 2.0 * height)})
    return case.model_copy(update={"domain": domain})


class _Teller:
    """Says every `_EVERY` seconds of wall time how far a bed has settled."""

    def __init__(self, say: Callable[[str], None], waiting: int, step: float, wanted: float) -> None:
        self._say, self._step, self._last = say, step, monotonic()
        self._rest = f"below {wanted:.2g} m/s is at rest" + (f"; {waiting} particles to come" if waiting else "")

    def __call__(self, steps: int, speed: float) -> None:
        if monotonic() - self._last > _EVERY:
            self._last = monotonic()
            self._say(f"start: settled for {steps * self._step:.3g} s, speed {speed:.2g} m/s ({self._rest})")


def _join(bed: Particles, placed: Particles) -> Particles:
    pairs = zip((bed.positions, bed.motion, bed.kinds), (placed.positions, placed.motion, placed.kinds), strict=True)
    return Particles(*(np.concatenate(pair) for pair in pairs))


class _Rain:
    """Particles at random places above a bed, in the order in which they wait."""

    def __init__(self, case: Case, folder: Path, generator: np.random.Generator) -> None:
        assert case.particles is not None
        self._region: Region = find_region(case, folder)
        kinds = list_kinds(case.particles)
        self._radii = np.array([kind.diameter / 2.0 for kind in kinds])
        self._period = np.where(wraps(case.domain), case.domain.size, 0.0)
        self._clear, self._bounds = _find_walls(case, folder)
        self._generator = generator

    def fall(self, bed: Particles, waiting: np.ndarray) -> tuple[Particles, np.ndarray] | None:
        """Those of the kinds `waiting` that find room above `bed`, and the kinds that go on waiting; None if none finds
        room."""
        low, high = self._bounds
        radii = self._radii[waiting]
        floor = float((bed.positions[:, 2] + self._radii[bed.kinds]).max(initial=low[2]))
        volumes = np.cumsum(4.0 / 3.0 * math.pi * radii**3)
        room = LOOSE * self._region.volume * max(0.0, 1.0 - (floor - low[2]) / (high[2] - low[2]))
        count = max(1, int(np.searchsorted(volumes, room, "right")))
        top = high[2]
        if not len(bed.positions) and count >= len(waiting):  # no higher than the rain is loose
            top = min(top, low[2] + self._region.find_level(volumes[-1] / LOOSE))
        top = min(high[2], max(top, floor + 4.0 * self._radii.max()))
        bounds = np.array([[low[0], low[1], floor], [high[0], high[1], top]])
        positions = insert(radii[:count], bounds, self._period, self._clear, self._generator)
        found = ~np.isnan(positions[:, 0])
        if not found.any():
            return None
        motion = np.zeros((int(found.sum()), 6))
        rest = np.concatenate([waiting[:count][~found], waiting[count:]])
        return Particles(positions[found], motion, waiting[:count][found]), rest


def _find_walls(case: Case, folder: Path) -> tuple[Clear, np.ndarray]:
    """What tells which spheres are clear of walls, and the box around the region [m], (2, 3)."""
    if case.domain.shape == "box":
        everywhere: Clear = lambda positions, radii: np.ones(len(positions), bool)  # noqa: E731  (the box itself is the wall)
        return everywhere, np.array([[0.0, 0.0, 0.0], case.domain.size])
    from fbcouple.case.bed.region_lattice import Inside  # noqa: PLC0415  (loads numba)

    mesh = read_mesh(case, folder)
    inside = Inside(mesh)
    return _ask(inside.is_clear), np.array([mesh.low, mesh.high])


def _ask(is_clear: Callable[[np.ndarray, float], np.ndarray]) -> Clear:
    """Ask for the spheres of each radius at once."""

    def clear(positions: np.ndarray, radii: np.ndarray) -> np.ndarray:
        found = np.zeros(len(positions), bool)
        for radius in np.unique(radii):
            rows = np.flatnonzero(radii == radius)
            found[rows] = is_clear(positions[rows], float(radius))
        return found

    return clear
