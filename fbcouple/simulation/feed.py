"""A feed at work: how many particles are due, of which kind each is, and where there is free space for it.

All of it is the same on every rank, on any number of ranks, and after a restart: kinds and places are drawn by
counters (seed, feed, running number, step) and not by a generator that has a state.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy
from mpi4py import MPI

from fbcouple.case.bed.derived import wraps
from fbcouple.case.bed.feeds import find_inner_box, find_mean_mass, list_feed_kinds
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.overlap import add_images

_KIND, _PLACE = 0, 1
_TRIES = 16
"""Places that are tried for a particle in a step."""
_BATCH = 256
"""Particles whose places are tried at once."""
_ALMOST = 1.0 - 1e-12

IsClear = Callable[[np.ndarray, float], np.ndarray]
"""Is a sphere of a radius [m] about each of some points (n, 3) clear of the walls?"""


class FeedSource:
    """One of the feeds of a case, and what it has fed so far."""

    def __init__(self, case: Case, number: int) -> None:
        """`number` counts the feeds from 1."""
        assert case.particles is not None
        self._feed = case.particles.feeds[number - 1]
        self._key = np.array([self._feed.seed, number], dtype=np.uint64)
        self.number, self.velocity = number, np.array(self._feed.velocity)
        self.temperature = self._feed.temperature or (case.heat.particle_temperature if case.heat else None)
        """Temperature [K] of what it feeds; None in a case without heat."""
        self._kinds = [(kind, about) for kind, about, _ in list_feed_kinds(case.particles, self._feed)]
        self._shares = np.cumsum([share for *_, share in list_feed_kinds(case.particles, self._feed)])
        self._boxes = [find_inner_box(case, self._feed, 0.5 * about.diameter) for _, about in self._kinds]
        by_number = self._feed.rate is not None
        self._flow = (self._feed.rate if by_number else self._feed.mass_flow) or 0.0
        self._costs = [about.grains if by_number else about.mass for _, about in self._kinds]
        self._mean_cost = self._costs[0] if by_number else find_mean_mass(case.particles, self._feed)
        self.count, self._used = 0, 0.0

    def save(self) -> dict[str, Any]:
        """What `load` needs to go on."""
        return {"count": self.count, "used": self._used}

    def load(self, saved: dict[str, Any]) -> None:
        """Go on from `saved`."""
        self.count, self._used = saved["count"], saved["used"]

    def count_owed(self, time: float) -> int:
        """Particles that are due at `time` [s] and have not come in; of more than a batch the rest by their mean."""
        due = self.list_due(time)
        if len(due) < _BATCH:
            return len(due)
        used = self._used + sum(self._costs[kind] for kind in due)
        return len(due) + max(0, int((self._allow(time) / _ALMOST - used) / self._mean_cost))

    def list_due(self, time: float) -> list[int]:
        """Which of its kinds each particle is that is due at `time` [s]; of many the first, up to a batch."""
        due: list[int] = []
        used, allowed = self._used, self._allow(time)
        while len(due) < _BATCH:
            if (used + min(self._costs)) * _ALMOST > allowed:
                break
            kind = self._draw_kind(self.count + len(due))
            used += self._costs[kind]
            if used * _ALMOST > allowed:
                break
            due.append(kind)
        return due

    def try_places(self, kinds: list[int], step: int) -> np.ndarray:
        """Places [m], (n, tries, 3), for the next particles, of `kinds`, in the coupling step `step`."""
        positions = np.empty((len(kinds), _TRIES, 3))
        for n, kind in enumerate(kinds):
            low, high = self._boxes[kind]
            positions[n] = low + (high - low) * self._draw(self.count + n, step, _PLACE).random((_TRIES, 3))
        return positions

    def find_radii(self, kinds: list[int]) -> np.ndarray:
        """Radii [m] of particles of `kinds`."""
        return np.array([0.5 * self._kinds[kind][1].diameter for kind in kinds])

    def take(self, kinds: list[int]) -> np.ndarray:
        """The next particles, of `kinds`, come in; their kinds among those of the bed."""
        self.count += len(kinds)
        for kind in kinds:
            self._used += self._costs[kind]
        return np.array([self._kinds[kind][0] for kind in kinds], dtype=int)

    def _allow(self, time: float) -> float:
        """Particles (of parcels their grains), or mass [kg], that may have come in by `time` [s]."""
        end = time if self._feed.end is None else min(time, self._feed.end)
        return self._flow * max(0.0, end - self._feed.start)

    def _draw_kind(self, number: int) -> int:
        if len(self._kinds) == 1:
            return 0
        drawn = self._draw(number, 0, _KIND).random()
        return min(int(np.searchsorted(self._shares, drawn, side="right")), len(self._kinds) - 1)

    def _draw(self, number: int, step: int, what: int) -> np.random.Generator:
        counter = np.array([0, number, step, what], dtype=np.uint64)
        return np.random.Generator(np.random.Philox(counter=counter, key=self._key))


class FreeSpace:
    """Finds places that no particle of any rank is in the way of."""

    def __init__(self, case: Case, comm: MPI.Comm, is_clear: IsClear | None = None) -> None:
        """`is_clear`: which places are clear of walls, where feeds may come near some."""
        self._comm, self._is_clear = comm, is_clear
        self._period = np.where(wraps(case.domain), case.domain.size, 0.0)

    def choose(
        self, tried: np.ndarray, radii: np.ndarray, positions: np.ndarray, held: np.ndarray, taken: list[np.ndarray]
    ) -> np.ndarray:
        """Places (m, 3) [m] for the first m of the particles of `radii` (n,): one of the places `tried` (n, tries, 3)
        for each, up to the first for which none is free (collective).

        positions (particles, 3), held (particles,) [m]: this rank's particles and their radii; taken: places and radii
        (k, 4) that others got in this step.
        """
        blocked = self._find_blocked(tried, radii, positions, held)
        first = count = len(taken)
        others = np.concatenate([np.reshape(taken, (-1, 4)), np.empty((len(tried), 4))])
        for row, radius, ways in zip(tried, radii, blocked, strict=True):
            free = [n for n in np.flatnonzero(~ways) if self._is_apart(row[n], radius, others[:count])]
            if not free:
                break
            others[count] = *row[free[0]], radius
            count += 1
        taken += list(others[first:count])
        return others[first:count, :3]

    def _find_blocked(
        self, tried: np.ndarray, radii: np.ndarray, positions: np.ndarray, held: np.ndarray
    ) -> np.ndarray:
        blocked = np.zeros(tried.shape[:2], dtype=np.uint8)
        if len(positions):
            reach = float(radii.max() + held.max())
            low, high = tried.min(axis=(0, 1)) - reach, tried.max(axis=(0, 1)) + reach
            points, rows = add_images(positions, self._period, reach)
            near = ((points >= low) & (points <= high)).all(axis=1)
            for size in np.unique(held[rows[near]]):
                tree = scipy.spatial.cKDTree(points[near & (held[rows] == size)])
                distances = tree.query(tried.reshape(-1, 3))[0].reshape(blocked.shape)
                blocked |= (distances < radii[:, None] + size).astype(np.uint8)
        self._comm.Allreduce(MPI.IN_PLACE, blocked, MPI.MAX)
        if self._is_clear:
            for radius in np.unique(radii):
                rows = np.flatnonzero(radii == radius)
                clear = self._is_clear(tried[rows].reshape(-1, 3), float(radius)).reshape(len(rows), -1)
                blocked[rows] |= (~clear).astype(np.uint8)
        return blocked.astype(bool)

    def _is_apart(self, position: np.ndarray, radius: float, others: np.ndarray) -> bool:
        away = others[:, :3] - position
        wrapped = self._period > 0.0
        away[:, wrapped] -= self._period[wrapped] * np.round(away[:, wrapped] / self._period[wrapped])
        return bool((np.einsum("ij,ij->i", away, away) >= (others[:, 3] + radius) ** 2).all())
