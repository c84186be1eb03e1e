"""Finds while the run goes on where its start-up ends, and lets the means begin there."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from fbcouple.results.start_up import Start, average_rows, find_start
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.growing_means import GrowingMeans
from fbcouple.simulation.tasks.means import QUANTITIES

MAPS = {"solids": ("solids_flux", "solids_fraction"), "gas": ("gas_velocity",)}
"""Depth-averaged maps that are looked at, by phase; those of the gas where there are no particles."""
HISTORIES = ("bed_height", "solids_centre_z", "pressure_drop", "particles")
"""Histories that are looked at, where the run has them."""
FEWEST_ROWS = 8
"""Rows of the history below which nothing is told."""

Rows = list[dict[str, Any]]


class StartUp:
    """Where the start-up ends, by all blocks from the start of the run on, looked at as seldom as `GrowingMeans` says.

    Each look judges anew: a start-up that seemed to be over may turn out not to be, and begins later then.
    """

    _STATE = ("is_over", "drift")

    def __init__(self, sim: Simulation, phases: Mapping[str, Any]) -> None:
        """`phases`: the means whose window it moves, by name (collective)."""
        self._means: dict[str, GrowingMeans] = dict(phases)
        self.is_over = False
        """Was the start-up over at the last look? While it is not, the window begins where there is the least drift."""
        self.drift = math.nan
        """The largest at that look, see `measure_drift`; nan before it is known."""
        self.read_rows: Callable[[], Rows] = list
        """Gives the rows of the history so far."""
        self._depth = sim.cells.open_depth_mean(sim.comm)

    @property
    def begin(self) -> float:
        """Where the window begins [s]; nan before there is a sample."""
        means = next(iter(self._means.values()))
        return means.begins[means.first] if means.begins else math.nan

    def judge(self, sim: Simulation) -> None:
        """After a sample: look where the start-up ends, if it is time for a look (collective)."""
        means = next(iter(self._means.values()))
        if not means.is_look:
            return
        maps = self._average_maps()
        found = sim.comm.bcast(self._find(maps, np.append(means.begins, sim.time)) if sim.comm.rank == 0 else None)
        self.is_over, self.drift = found.is_over, found.drift
        for each in self._means.values():
            each.first = found.block

    def _average_maps(self) -> list[np.ndarray]:
        """Each map averaged over the depth (blocks, places), on rank 0 (collective)."""
        phase = "solids" if "solids" in self._means else "gas"
        found = []
        for name in MAPS[phase]:
            means = self._means[QUANTITIES[name].phase]
            blocks = [self._depth.find(values) for values in means.list_blocks(name)]
            if blocks[0] is not None:
                flat = np.array(blocks).reshape(len(blocks), -1)
                found.append(flat[:, np.isfinite(flat).all(axis=0)])
        return found

    def _find(self, maps: list[np.ndarray], edges: np.ndarray) -> Start:
        rows = self.read_rows()
        if len(rows) < FEWEST_ROWS:
            return Start(0, False, math.nan)
        return find_start(maps, [read_blocks(rows, name, edges) for name in HISTORIES if name in rows[0]])

    def describe(self) -> dict[str, Any]:
        """What results.nc says of it."""
        return {"start_up_over": int(self.is_over), "start_up_drift": self.drift}

    def save(self) -> dict[str, Any]:
        """What `load` needs to go on from here, beside the means."""
        return {name: getattr(self, name) for name in self._STATE}

    def load(self, state: dict[str, Any]) -> None:
        """Go on from `state`."""
        for name in self._STATE:
            setattr(self, name, state[name])


def read_blocks(rows: Rows, name: str, edges: np.ndarray) -> np.ndarray:
    """Means (blocks, 1) of the history `name` between `edges` [s]."""
    times, values = (np.array([row[key] for row in rows], dtype=float) for key in ("time", name))
    return average_rows(times, values, edges)
