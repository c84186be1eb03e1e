"""Whether the gas that the case asks for comes in by the inlet, and whether continuity keeps it, in every step."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.derived import fastest_inlet, inlet_range
from fbcouple.case.bed.particle_types import solids_volume
from fbcouple.case.bed.region import find_region
from fbcouple.case.schema.gas import Gas
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.gas_continuity import has_height_flux
from fbcouple.solvers.openfoam.gas import GasReport

_NEAR = 1e-9
"""Relative difference of two clocks that went the same steps: at a jump the gas may be on either side."""


class InletFlow:
    """Holds the gas of a step against the case: the superficial velocity of its inlet, times the inlet's area."""

    def __init__(self, sim: Simulation, run: Path) -> None:
        """The case's own files lie in `run` (collective)."""
        sizes = 0.0, 0.0
        if sim.has_gas and sim.comm.rank == 0:
            region = find_region(sim.case, run)
            sizes = region.inlet, region.volume
        self.area: float
        """Of the inlet [m2]."""
        self.area, volume = sim.comm.bcast(sizes)
        bed = sim.case.particles
        self._gas_volume = volume - (solids_volume(bed) if bed else 0.0)
        self._fastest = fastest_inlet(sim.case.gas) if sim.case.gas else 0.0

    def judge(self, gas: Gas, state: GasReport, time: float) -> dict[str, Any]:
        """The superficial velocity [m/s] that came in by the step's end at `time` [s], the one asked for, and their
        difference over the fastest of the run; any gas is infinitely much where the case asks for none."""
        found = state.inflow / self.area
        asked = float(np.clip(found, *inlet_range(gas, time * (1.0 - _NEAR), time * (1.0 + _NEAR))))
        error = abs(found - asked)
        error = error / self._fastest if self._fastest else math.inf if error else 0.0
        return {"inflow": found, "inflow_asked": asked, "inflow_error": error}

    def find_loss(self, state: GasReport, dt: float) -> float:
        """Gas volume that continuity lost in the step `dt` [s]: over what the fastest inlet velocity brings in that
        time or, where nothing ever comes in, over all the gas."""
        if self._fastest:
            return state.lost / (self._fastest * self.area)
        return state.lost * dt / self._gas_volume

    def measure_outlet(self, sim: Simulation) -> dict[str, Any]:
        """Where other heights cannot be told, the error of the gas flux at the one that patches tell: the outlet's."""
        if sim.gas_report is None or not self._fastest or has_height_flux(sim):
            return {}
        top = float(sim.grid.origin[2] + sim.grid.size[2])
        return {"gas_flux_error": self.find_loss(sim.gas_report, sim.dt), "gas_flux_height": top}
