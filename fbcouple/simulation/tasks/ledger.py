"""Particles that came and went: in checkpoints, and those that left, with when they had come in, in results.nc."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fbcouple.results.variables import EXITS
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.diagnostics import as_grains
from fbcouple.simulation.tasks.limits import Numbers
from fbcouple.simulation.tasks.task import Saved, Task
from fbcouple.simulation.traffic import Traffic

_FILE = "exits.npz"


class LedgerKeeper(Task):
    """Saves what the feeds and outlets of a run go on from."""

    def __init__(self, traffic: Traffic) -> None:
        self._traffic = traffic

    @property
    def exits(self) -> dict[str, np.ndarray]:
        """Name of EXITS -> its values (exits,)."""
        return dict(zip(EXITS, self._traffic.exits.T, strict=True))

    def save(self, sim: Simulation, folder: Path) -> Saved:
        """The ledger, what feeds have fed, and who left in a file of its own."""
        if sim.comm.rank == 0:
            np.savez(folder / _FILE, exits=self._traffic.exits)
        return Saved(self._traffic.save(), files=[_FILE])

    def load(self, sim: Simulation, saved: Saved, folder: Path) -> None:
        """Go on from `saved`."""
        exits = np.load(folder / _FILE)["exits"].reshape(-1, len(EXITS))
        if len(exits) != saved.numbers["ledger"]["removed"]["count"]:
            raise ValueError(f"{len(exits)} particles in {_FILE} that left, and the ledger has another number")
        self._traffic.load(saved.numbers, exits)


def measure_traffic(sim: Simulation) -> Numbers:
    """What came in and went out up to now, who waits, and how far the ledger is from what there is (collective)."""
    traffic = sim.traffic
    if not traffic:
        return {}
    ledger = traffic.ledger
    heats = {"heat_fed": ledger.fed.heat, "heat_removed": ledger.removed.heat} if sim.case.heat else {}
    return heats | {
        "particles_fed": as_grains(sim, ledger.fed.count),
        "particles_removed": as_grains(sim, ledger.removed.count),
        "particles_owed": as_grains(sim, traffic.count_owed(sim.time)),
        "mass_fed": ledger.fed.mass,
        "mass_removed": ledger.removed.mass,
        "momentum_fed": list(ledger.fed.momentum),
        "momentum_removed": list(ledger.removed.momentum),
        "ledger_error": traffic.hold(),
    }
