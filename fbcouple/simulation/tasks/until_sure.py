"""Ends a run when the standard error of a mean map, or of the mean of a history, is as small as the case asks for."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from fbcouple.case.schema.output import Averages as Options
from fbcouple.case.schema.output import find_first_sample, name_map
from fbcouple.results.block_errors import compare_with_map, join_pairs, list_errors
from fbcouple.simulation.clock import ALMOST
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.growing_means import GrowingMeans
from fbcouple.simulation.tasks.means import QUANTITIES
from fbcouple.simulation.tasks.start_up import FEWEST_ROWS, Rows, StartUp, read_blocks

REACHED = "until_error"
LIMIT = "end_time"


class UntilSure:
    """The error that the means have reached, found where a block is full, and the run's end by it.

    Looks are seldom, every second block from `blocks` on, and the error has to hold by blocks of both lengths, as they
    are and joined in pairs, and these have to be long enough by a margin (`find_gain`): an error that is small by
    chance, or of blocks that are too short, ends no run.
    """

    _STATE = ("error", "expected_end", "ended_by")

    def __init__(
        self, sim: Simulation, options: Options, phases: Mapping[str, Any], start_up: StartUp | None = None
    ) -> None:
        """`start_up`: what finds where the window begins, if that is not given (collective)."""
        assert options.until_error is not None
        self._wanted, self._fewest, self._start_up = options.until_error, options.blocks, start_up
        self._given, self._earliest = find_first_sample(options), options.earliest_end or 0.0
        self.name = name_map(options, sim.has_particles)
        """The mean map whose error counts, of a vector its component along z, or history."""
        self._is_map = self.name in QUANTITIES
        self._means: GrowingMeans = phases[QUANTITIES[self.name].phase] if self._is_map else next(iter(phases.values()))
        self.read_rows: Callable[[], Rows] = list
        """Gives the rows of the history so far."""
        self.error = math.nan
        """Standard error of the map over the map, root mean square, or of the mean of the history over the mean, at the
        last look; nan before one is known."""
        self.expected_end = math.nan
        """When the run will end: the error as wanted, going down as one over the root of the window, and not before
        the earliest end [s]."""
        self.ended_by = ""
        sim.cells.prepare_samples(sim.comm)

    def judge(self, sim: Simulation) -> None:
        """After a sample: look at the error where one is due, and end the run if it is as wanted (collective)."""
        means, start_up = self._means, self._start_up
        if not means.is_look:
            return
        if start_up and (not start_up.is_over or means.full - means.first < self._fewest):
            self.error = self.expected_end = math.nan
            return
        self.error, upper = self._compare_maps(sim) if self._is_map else self._compare_history(sim)
        begin = start_up.begin if start_up else self._given
        sure_at = begin + (sim.time - begin) * (upper / self._wanted) ** 2
        self.expected_end = float(np.maximum(sure_at, self._earliest))
        if upper <= self._wanted and sim.time >= self._earliest * ALMOST:
            self._end(sim)

    def _compare_maps(self, sim: Simulation) -> tuple[float, float]:
        """The error, and the largest by blocks of both lengths; that is nan unless all are known (collective)."""
        parts = sim.comm.gather((sim.owned, self._means.judge(self.name, sim.comm.allreduce)))
        return sim.comm.bcast(None if parts is None else self._compare(sim, parts))

    def _compare_history(self, sim: Simulation) -> tuple[float, float]:
        """The same of the history, by its means over the blocks (collective)."""
        found = (math.nan, math.nan)
        if sim.comm.rank == 0 and len(rows := self.read_rows()) >= FEWEST_ROWS:
            means = self._means
            blocks = read_blocks(rows, self.name, np.append(means.begins, sim.time)[means.first :])
            errors = list_errors(blocks[..., None], join_pairs(blocks)[..., None])
            parts = [compare_with_map(blocks.mean(axis=0), error[:, 0]) for error in errors]
            found = parts[0], float(np.max(parts))
        return sim.comm.bcast(found)

    def _compare(self, sim: Simulation, parts: list[tuple[np.ndarray, tuple[np.ndarray, ...]]]) -> tuple[float, float]:
        maps = [sim.cells.sample([(owned, values[n]) for owned, values in parts]) for n in range(4)]
        mean, *errors = (_average_depth(values) for values in maps)
        found = [compare_with_map(mean, error) for error in errors]
        return found[0], float(np.max(found))

    def _end(self, sim: Simulation) -> None:
        self.ended_by = REACHED
        sim.clock.end_here()

    def describe(self, sim: Simulation) -> dict[str, Any]:
        """What results.nc says of it: the error, of which map or history, and why the run ended, if it has."""
        ended = self.ended_by or ("" if sim.clock.running else LIMIT)
        return {"averaging_error": self.error, "averaging_error_of": self.name, "ended_by": ended}

    def save(self) -> dict[str, Any]:
        """What `load` needs to go on from here."""
        return {name: getattr(self, name) for name in self._STATE}

    def load(self, sim: Simulation, state: dict[str, Any]) -> None:
        """Go on from `state`; a run that had ended by it has."""
        for name in self._STATE:
            setattr(self, name, state[name])
        if self.ended_by:
            self._end(sim)


def _average_depth(values: np.ndarray) -> np.ndarray:
    """The mean over y (z, x) of a map (z, y, x), or of the z component of one (component, z, y, x), of the places
    inside of the mesh."""
    field = (values if values.ndim == 3 else values[2]).astype(float)
    known = np.isfinite(field)
    count = known.sum(axis=1)
    return np.where(count > 0, np.where(known, field, 0.0).sum(axis=1) / np.maximum(count, 1), np.nan)
