"""Whether the gas that came in passes every height, less what the particles made room for."""

from __future__ import annotations

from typing import Any

import numpy as np

from fbcouple.case.bed.derived import fastest_inlet
from fbcouple.case.bed.streams import has_side_openings
from fbcouple.simulation.simulation import Simulation


def has_height_flux(sim: Simulation) -> bool:
    """Do inflow and voidage say what passes every height: in cells with layers, by the floor alone, and at a constant
    density?"""
    expands = sim.case.heat is not None and sim.case.heat.has_ideal_gas
    return sim.has_gas and sim.cells.has_layers and not has_side_openings(sim.case) and not expands


class HeightFlux:
    """In a box, the gas flux of each layer against inflow and change of the voidage below it, for chosen steps.

    A cell's eps u_z is the mean of what its lower and upper face carry, so a layer's flux is known to the accuracy of
    the pressure solve: q_0 A - sum of d(eps)/dt V below - half of the layer's own.
    """

    def __init__(self) -> None:
        self._before, self._step = np.empty(0), -1

    def prepare(self, sim: Simulation) -> None:
        """Remember the voidage of the gas step just taken, if a checkpoint has not, for the next (collective)."""
        if self._step == sim.clock.steps + 1 or not has_height_flux(sim):
            return
        before = sim.cells.add_layers(sim.comm, sim.gas.voidage)
        assert before is not None, "cells with layers add them up"
        self._before, self._step = before, sim.clock.steps + 1

    def save(self) -> dict[str, Any]:
        """What `load` needs to go on from here."""
        return {"before": self._before.tolist(), "step": self._step}

    def load(self, state: dict[str, Any]) -> None:
        """Go on from `state`."""
        self._before, self._step = np.array(state["before"]), state["step"]

    def measure(self, sim: Simulation) -> dict[str, Any]:
        """Largest error over the fastest inflow, and its height [m]; nothing where there is no inflow or the step was
        not prepared for (collective)."""
        gas, grid = sim.case.gas, sim.grid
        if sim.gas_report is None or self._step != sim.clock.steps or gas is None or fastest_inlet(gas) == 0.0:
            return {}
        voidage = sim.gas.voidage
        solids, flux = (
            sim.cells.add_layers(sim.comm, values) for values in (voidage, voidage * sim.gas.velocity[:, 2])
        )
        assert solids is not None and flux is not None, "only cells with layers were prepared for"
        change = solids - self._before
        floor = grid.size[0] * grid.size[1]
        change *= grid.cell_volume / sim.moved / floor
        flux *= grid.cell_volume / grid.spacing[2] / floor
        inflow = sim.gas_report.inflow / floor
        errors = np.abs(flux - (inflow - np.cumsum(change) + change / 2)) / fastest_inlet(gas)
        worst = int(errors.argmax())
        return {"gas_flux_error": float(errors[worst]), "gas_flux_height": float(grid.centres(2)[worst])}
