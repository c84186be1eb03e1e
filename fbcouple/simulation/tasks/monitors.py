"""Holds every step against the limits of [monitors], and the whole state before it is recorded or kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.diagnostics import measure_height, measure_particles, measure_species, measure_voidage
from fbcouple.simulation.tasks.gas_continuity import HeightFlux
from fbcouple.simulation.tasks.inlet_flow import InletFlow
from fbcouple.simulation.tasks.ledger import measure_traffic
from fbcouple.simulation.tasks.limits import Numbers, find_breaches, judge, require_finite, require_inside
from fbcouple.simulation.tasks.lost_particles import LostParticles
from fbcouple.simulation.tasks.outlet import Outlet
from fbcouple.simulation.tasks.task import Saved, Task


class Monitors(Task):
    """Ends the run with DivergedError where a limit is broken, with the worst cell or particle."""

    def __init__(self, sim: Simulation, run: Path) -> None:
        """The case's own files lie in `run` (collective)."""
        self._lost = LostParticles(sim)
        self._flux, self.inlet, self._outlet = HeightFlux(), InletFlow(sim, run), Outlet(sim, run)
        self._inspected: tuple[int, Numbers] = (-1, {})
        self.numbers: Numbers = {}
        """What the last step was held against."""

    def start(self, sim: Simulation) -> None:
        """Hold the start against the limits of a step (collective)."""
        self.after_step(sim)

    def after_step(self, sim: Simulation) -> None:
        """Raise DivergedError if a number of the step breaks its limit (collective)."""
        numbers: Numbers = {}
        if sim.gas_report and sim.case.gas:
            numbers = self.inlet.judge(sim.case.gas, sim.gas_report, sim.time)
            numbers["courant_ratio"] = sim.gas_report.courant / sim.case.gas.max_courant
        self._lost.require_all(sim)
        if sim.is_coupled:
            numbers |= {"momentum_error": sim.conservation.momentum_error, "substeps": sim.substeps}
        if sim.heat:
            numbers["heat_error"] = sim.heat.error
        if find_breaches(sim, numbers):
            self.inspect(sim)  # what is wrong with the state says more than what came of it
            judge(sim, numbers)
        self.numbers = numbers

    def inspect(self, sim: Simulation) -> dict[str, Any]:
        """Hold the state as it is against its limits; returns what was measured for it (collective).

        Raises DivergedError with the reason, and the cell or particle.
        """
        if self._inspected[0] == sim.clock.steps:
            return self._inspected[1]
        numbers: Numbers = {}
        require_finite(sim)
        if sim.has_particles:
            require_inside(sim)
            numbers |= measure_particles(sim) | measure_species(sim) | measure_height(sim)
            numbers |= self._outlet.measure(sim) | measure_traffic(sim)
        if sim.is_coupled:
            numbers |= measure_voidage(sim)
        if sim.has_gas:
            numbers |= self._flux.measure(sim) | self.inlet.measure_outlet(sim)
        judge(sim, numbers)
        self._inspected = sim.clock.steps, numbers
        if sim.has_particles:
            self._lost.take(sim)
        return numbers

    def prepare(self, sim: Simulation) -> None:
        """The next step will be inspected: remember what its gas flux is measured against (collective)."""
        self._flux.prepare(sim)

    def save(self, sim: Simulation, folder: Path) -> Saved:
        """What the next step is measured against."""
        return Saved({"flux": self._flux.save()})

    def load(self, sim: Simulation, saved: Saved, folder: Path) -> None:
        """Go on from `saved`."""
        self._flux.load(saved.numbers["flux"])
