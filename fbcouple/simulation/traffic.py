"""Particles that come and go between two coupling steps: outlets take, feeds give, and the ledger is kept.

LIGGGHTS makes and deletes them and is set up anew, on all ranks, in a step in which any of them came or went; in other
steps nothing is done. What is done does not depend on how many ranks there are.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.derived import wraps
from fbcouple.case.bed.outlets import find_thickness, list_stages
from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.bed.region import read_mesh
from fbcouple.case.schema.sections import Case
from fbcouple.decks.open_walls import name_opening
from fbcouple.errors import DivergedError
from fbcouple.geometry.grid import Grid
from fbcouple.geometry.sides import SIDES
from fbcouple.results.variables import EXITS
from fbcouple.simulation.clock import Clock
from fbcouple.simulation.exits import make_exits
from fbcouple.simulation.feed import FeedSource, FreeSpace
from fbcouple.simulation.ledger import Amount, Ledger, measure_held
from fbcouple.solvers.liggghts import Liggghts

if TYPE_CHECKING:
    from fbcouple.case.bed.region_lattice import Inside


class Newcomers(NamedTuple):
    """Particles that come in: kinds (n,) counted from 0, positions (n, 3) [m], velocities (n, 3) [m/s], and feeds (n,)
    counted from 1."""

    kinds: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray
    feeds: np.ndarray


class Traffic:
    """The feeds and outlets of a run, and what has come and gone so far."""

    def __init__(
        self, case: Case, run: Path, comm: MPI.Comm, grid: Grid, liggghts: Liggghts, accelerated: bool
    ) -> None:
        """The case's own files lie in `run`; `grid` has the extent of the region; `accelerated`: does LIGGGHTS keep the
        velocities that drag alone would give?"""
        assert case.particles is not None
        self._comm, self._liggghts, self._accelerated = comm, liggghts, accelerated
        self._kinds = list_kinds(case.particles)
        self._feeds = [FeedSource(case, number) for number in range(1, len(case.particles.feeds) + 1)]
        self._corners = np.array([grid.origin, np.add(grid.origin, grid.size)])
        self._period = np.where(wraps(case.domain), case.domain.size, 0.0)
        self._outlets, inside = case.particles.outlets, _read_inside(case, run)
        self._exits = make_exits(case, grid, run, inside)
        self._thickness = np.array([find_thickness(case, outlet) for outlet in self._outlets])
        self._specific_heat = case.heat.particle_specific_heat if case.heat else None
        self._stages, self._opened = list_stages(case), 0
        self._sides = {outlet.face for outlet in self._outlets if outlet.face}
        self._space = FreeSpace(case, comm, inside.is_clear if inside else None)
        self.ledger = Ledger()
        self.exits = np.empty((0, len(EXITS)))
        """Columns EXITS of each particle that left, in the order in which they left, on all ranks."""

    def prepare(self, clock: Clock) -> None:
        """Before LIGGGHTS is set up, at the start of a run and where one goes on: open the walls that are open then
        (collective)."""
        self._open_walls(clock.time)

    def number_start(self) -> None:
        """Number the particles of a start, once LIGGGHTS is set up, which clears their identities (collective)."""
        own = self._liggghts
        own.identity[:] = 0.0
        own.identity[:, 0] = own.tags
        held = measure_held(self._comm, own)
        self.ledger.start = Amount(held.count, held.mass, held.momentum.tolist())

    def exchange(self, clock: Clock) -> bool:
        """Take out who is in an outlet, and let in who is due and finds a place; returns whether anything was changed,
        after which LIGGGHTS is set up anew (collective)."""
        rows, outlets = self._find_leaving(clock.time)
        leaving = self._comm.allreduce(len(rows))
        coming = self._find_places(clock, rows)
        opened = self._open_walls(clock.time)
        if not (opened or leaving or len(coming.kinds)):
            return False
        own, removed, fed = self._liggghts, Amount(), Amount()
        before = measure_held(self._comm, own)
        if leaving or len(coming.kinds):
            self._take_out(clock, rows, outlets, removed)
            self._let_in(clock, coming, fed)
        own.advance(0, first=True)
        self.ledger.enter(fed, removed)
        self.ledger.error = measure_held(self._comm, own).find_error(before, fed, removed)
        return True

    def list_inside(self, positions: np.ndarray) -> np.ndarray | slice:
        """Rows of `positions` (n, 3) that are in the region, and not behind an open side of it on their way out."""
        inside = np.ones(len(positions), bool)
        for side in self._sides if self._opened else ():
            axis, end = SIDES[side]
            places, level = positions[:, axis], self._corners[end, axis]
            inside &= places <= level if end else places >= level
        return slice(None) if inside.all() else np.flatnonzero(inside)

    def hold(self) -> float:
        """Hold the ledger against all particles that there are; the larger of its error and that of the last step in
        which some came or went (collective)."""
        return max(self.ledger.error, self.ledger.close(measure_held(self._comm, self._liggghts)))

    def count_owed(self, time: float) -> int:
        """Particles that are due at `time` [s] and wait for a place."""
        return sum(feed.count_owed(time) for feed in self._feeds)

    def save(self) -> dict[str, Any]:
        """What `load` needs to go on, beside the exits."""
        return {"ledger": self.ledger.save(), "feeds": [feed.save() for feed in self._feeds]}

    def load(self, saved: dict[str, Any], exits: np.ndarray) -> None:
        """Go on from `saved` and the exits up to then."""
        self.ledger, self.exits = Ledger.load(saved["ledger"]), exits
        for feed, own in zip(self._feeds, saved["feeds"], strict=True):
            feed.load(own)

    def _open_walls(self, time: float) -> bool:
        """Open the walls that it is time to open; are there any?"""
        due = sum(time >= stage.start * (1.0 - 1e-9) for stage in self._stages)
        for number in range(self._opened + 1, due + 1):
            self._liggghts.read(Path(name_opening(number)))
        self._opened, before = max(self._opened, due), self._opened
        return self._opened > before

    def _find_leaving(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Rows of this rank's particles that are out, and by which outlet each is, the nearest, counted from 1."""
        positions = self._liggghts.positions
        wrapped = self._period > 0.0
        if self._exits and wrapped.any():
            positions = positions.copy()
            positions[:, wrapped] %= self._period[wrapped]
        nearest, outlets = np.full(len(positions), np.inf), np.zeros(len(positions), dtype=int)
        for number, (outlet, way) in enumerate(zip(self._outlets, self._exits, strict=True), start=1):
            if time >= outlet.start * (1.0 - 1e-9):
                distances = way.measure(positions)
                closer = distances < nearest
                nearest[closer], outlets[closer] = distances[closer], number
        rows = np.flatnonzero(outlets)
        return rows, outlets[rows]

    def _find_places(self, clock: Clock, leaving: np.ndarray) -> Newcomers:
        """Who comes in, and where, once those in the rows `leaving` are gone (collective)."""
        own = self._liggghts
        due = [feed.list_due(clock.time) for feed in self._feeds]
        found: list[Newcomers] = []
        taken: list[np.ndarray] = []
        for feed, first in zip(self._feeds, due, strict=True):
            kinds = first
            staying = np.delete(np.arange(own.count), leaving) if kinds else leaving
            while kinds:
                tried = feed.try_places(kinds, clock.steps)
                held = own.positions[staying], own.radii[staying]
                positions = self._space.choose(tried, feed.find_radii(kinds), *held, taken)
                chosen = feed.take(kinds[: len(positions)])
                velocities = np.broadcast_to(feed.velocity, positions.shape)
                found.append(Newcomers(chosen, positions, velocities, np.full(len(chosen), feed.number)))
                kinds = feed.list_due(clock.time) if len(chosen) == len(kinds) else []
        if not found:
            return Newcomers(np.empty(0, int), np.empty((0, 3)), np.empty((0, 3)), np.empty(0, int))
        return Newcomers(*(np.concatenate(column) for column in zip(*found, strict=True)))

    def _take_out(self, clock: Clock, rows: np.ndarray, outlets: np.ndarray, removed: Amount) -> None:
        """Delete the particles of `rows`, and write down who they were (collective)."""
        own = self._liggghts
        gone = np.column_stack(
            [own.identity[rows], np.full(len(rows), clock.time), outlets, own.own_masses[rows], own.velocities[rows]]
        )
        if self._specific_heat is not None:
            heat = self._specific_heat * float(own.own_masses[rows] @ own.temperatures[rows])
            removed.heat += self._comm.allreduce(heat)
        gone = np.concatenate(self._comm.allgather(gone))
        gone = gone[np.argsort(gone[:, 0])]
        if len(gone):
            self._require_slow(clock, gone)
            self.exits = np.concatenate([self.exits, gone[:, : len(EXITS)]])
            removed.add(gone[:, len(EXITS) - 1], gone[:, len(EXITS) :])
        own.remove(rows)

    def _require_slow(self, clock: Clock, gone: np.ndarray) -> None:
        """Raise DivergedError if a particle that leaves moved so far in the step that its like can miss the outlet."""
        travel = np.linalg.norm(gone[:, len(EXITS) :], axis=1) * clock.last_dt
        outlets = gone[:, list(EXITS).index("outlet")].astype(int)
        thickness = self._thickness[outlets - 1]
        worst = int((travel - thickness).argmax())
        if travel[worst] > thickness[worst]:
            raise DivergedError(
                f"at t = {clock.time:.6g} s particle {gone[worst, 0]:.0f} came to outlet {outlets[worst]} and moved "
                f"{travel[worst]:.3g} m in a coupling step, the outlet is {thickness[worst]:.3g} m thick: others may "
                "have passed it unseen; make it thicker (depth, or low and high), or the step shorter"
            )

    def _let_in(self, clock: Clock, coming: Newcomers, fed: Amount) -> None:
        """Make the particles that come in (collective)."""
        if not len(coming.kinds):
            return
        own = self._liggghts
        diameters, densities, masses = (
            np.array([getattr(self._kinds[kind], name) for kind in coming.kinds])
            for name in ("diameter", "density", "mass")
        )
        first = self.ledger.start.count + self.ledger.fed.count + 1
        mine, rows = own.create(coming.kinds + 1, coming.positions, diameters, densities)
        velocities = coming.velocities[mine]
        own.velocities[rows] = velocities
        if own.remembers:
            own.last_velocities[rows] = velocities
        if self._accelerated:
            own.drag_only_velocities[rows] = velocities
        own.identity[rows] = np.column_stack([first + mine, np.full(len(mine), clock.time), coming.feeds[mine]])
        fed.add(masses, coming.velocities)
        if self._specific_heat is not None:
            temperatures = np.array([self._feeds[feed - 1].temperature for feed in coming.feeds])
            own.temperatures[rows] = temperatures[mine]
            fed.heat += self._specific_heat * float(masses @ temperatures)


def _read_inside(case: Case, run: Path) -> Inside | None:
    """What tells where a mesh of polyhedra is, if feeds or outlets ask."""
    assert case.particles is not None
    by_patches = any(outlet.patches for outlet in case.particles.outlets)
    if not by_patches and (case.domain.shape == "box" or not case.particles.feeds):
        return None
    from fbcouple.case.bed.region_lattice import Inside  # noqa: PLC0415  (loads numba)

    return Inside(read_mesh(case, run))
