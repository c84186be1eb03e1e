"""Heat in a run: the temperature of the gas, what it gives the particles, and the ledger of both, step by step."""

from __future__ import annotations

import math

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.gas_heat import TURBULENT_PRANDTL, find_capacity, has_hot_walls, list_walls
from fbcouple.case.schema.sections import Case
from fbcouple.coupling.coupling import Coupling
from fbcouple.coupling.heat import CellConductivity, add_up_heat
from fbcouple.coupling.particles import Particles
from fbcouple.errors import DivergedError
from fbcouple.solvers.liggghts import Liggghts
from fbcouple.solvers.openfoam.gas import Gas
from fbcouple.solvers.openfoam.heat import GasHeat

FLOWS = ("heat_by_walls", "heat_by_inlets", "heat_by_outlets", "heat_by_continuity", "heat_by_contacts", "heat_given")
"""Heat that came in by a step: to the gas by walls, inlets, outlets, and errors of continuity; to the particles by
contacts with walls; and from the gas to the particles, which is none of the ledger's."""
_NEGLIGIBLE = 1e-3
"""Part of the reference temperature: a bed that is nearer to it is taken to be as far off, as rounding is of the
temperature itself."""


class Heat:
    """The heat of this rank's gas and particles, where the case has them; methods are collective."""

    def __init__(
        self, case: Case, comm: MPI.Comm, gas: Gas | None, liggghts: Liggghts | None, coupling: Coupling | None
    ) -> None:
        assert case.heat is not None
        heat = case.heat
        self._comm, self._liggghts, self._coupling = comm, liggghts, coupling
        self._specific_heat = heat.particle_specific_heat or 0.0
        self._reference = heat.gas_temperature or heat.particle_temperature or 0.0
        self._expands = heat.has_ideal_gas
        self._walls_conduct = heat.contact_conduction != "none" and has_hot_walls(heat)
        self.gas: GasHeat | None = None
        """Temperatures of the gas; None in a case without gas."""
        self._volumes = np.empty(0)
        if gas and case.gas:
            prandtl = TURBULENT_PRANDTL if case.gas.turbulence != "none" else 0.0
            self._capacity = find_capacity(heat, case.gas)
            self._volumes = gas.volumes
            walls = list_walls(heat), heat.wall_area == "gas"
            self.gas = GasHeat(len(gas.volumes), self._capacity, self._reference, prandtl, *walls)
            if self._expands:
                gas.expand(self._reference, case.gravity)
            self._conductivity = CellConductivity(case)
            self._no_sums = np.zeros((len(gas.volumes), 2))
        self._totals = np.zeros(len(_TOTALS))
        self.flows = dict.fromkeys(FLOWS, 0.0)
        """Heat [J] that came in by the last step, of all ranks."""
        self.error = 0.0
        """How far the ledger of the last step was from closing, over the heat of gas and particles."""

    @property
    def masses(self) -> np.ndarray:
        """Masses [kg] of this rank's particles, (n,), without gas that they carry along."""
        assert self._liggghts is not None
        return self._liggghts.own_masses

    @property
    def densities(self) -> np.ndarray | None:
        """Density of the gas in this rank's cells, (cells,), over that of the case; None where it is that."""
        if not (self.gas and self._expands):
            return None
        return self._reference / self.gas.temperatures

    def step_gas(self, time: float, voidage: np.ndarray) -> None:
        """The temperatures of the step that the gas has taken from `time` [s], of `voidage` (cells,)."""
        assert self.gas is not None
        sums = self._coupling.heat_sums if self._coupling else self._no_sums
        amounts = self.gas.step(self._conductivity.find(voidage), sums)
        if not math.isfinite(amounts.after):
            row = int(np.flatnonzero(~np.isfinite(self.gas.temperatures))[0])
            words = f"the gas temperature is not finite: cell {row} of rank {self._comm.rank}"
            raise DivergedError(f"after the step from t = {time:.6g} s {words}")
        self._totals[:8] = (
            *(amounts.before, amounts.after, amounts.by_walls, amounts.by_inlets, amounts.by_outlets),
            *(amounts.by_continuity, amounts.by_particles, amounts.magnitude),
        )

    def give(self) -> None:
        """The particles get what the gas lost to them in the step, at once; without particles its ledger is closed."""
        held = self._measure_held()
        given = 0.0
        if self._coupling and self.gas:
            own = self.masses, self._liggghts_temperatures
            given = self._coupling.give_heat(self.gas.temperatures, own)
        self._totals[8:11] = held, given, self._measure_held()
        if not self._liggghts:
            self.close_ledger()

    def close_ledger(self) -> None:
        """The particles have moved, and contacts may have changed their temperatures: close the ledger of the step."""
        magnitude = 0.0
        if self._liggghts:
            sums = np.array(add_up_heat(self.masses, self._liggghts_temperatures, self._reference))
            self._totals[11], magnitude, capacity = self._specific_heat * sums
            magnitude = max(magnitude, _NEGLIGIBLE * self._reference * capacity)
        self._totals[12] = magnitude
        if self.gas:
            floor = _NEGLIGIBLE * self._reference * self._capacity * float(self._volumes.sum())
            self._totals[7] = max(self._totals[7], floor)
        totals = dict(zip(_TOTALS, self._comm.allreduce(self._totals).tolist(), strict=True))
        self._close(totals)

    def _close(self, totals: dict[str, float]) -> None:
        inflow = sum(totals[name] for name in ("walls", "inlets", "outlets", "continuity"))
        contacts = totals["solids_moved"] - totals["solids_given"]
        held_before = totals["gas_before"] + totals["solids_before"]
        held_after = totals["gas_after"] + totals["solids_given"]
        off = abs(held_after - held_before - inflow) + (0.0 if self._walls_conduct else abs(contacts))
        self.error = off / ((totals["gas_scale"] + totals["solids_scale"]) or 1.0)
        names = ("walls", "inlets", "outlets", "continuity")
        self.flows = {f"heat_by_{name}": totals[name] for name in names}
        self.flows |= {"heat_by_contacts": contacts if self._walls_conduct else 0.0, "heat_given": totals["given"]}

    def deposit(self, particles: Particles, dt: float) -> None:
        """The exchange of the next gas step, averaged over `dt` [s]."""
        if self._coupling:
            self._coupling.deposit_heat(particles, (self.masses, self._liggghts_temperatures), dt)

    def measure(self, voidage: np.ndarray | None) -> dict[str, float]:
        """Mean temperatures [K] of gas, over its volume in cells of `voidage` (cells,), and of particles, over their
        mass; the least and the largest of a cell or particle; nan of what is not there."""
        sums = np.zeros(4)
        if self.gas and voidage is not None:
            volumes = voidage * self._volumes
            sums[:2] = volumes.sum(), volumes @ (self.gas.temperatures - self._reference)
        if self._liggghts:
            heat, _, mass = add_up_heat(self.masses, self._liggghts_temperatures, self._reference)
            sums[2:] = mass, heat
        gas, gas_heat, solids, solids_heat = self._comm.allreduce(sums).tolist()
        found = {}
        if self.gas:
            found["mean_gas_temperature"] = self._reference + gas_heat / gas
        if self._liggghts:
            found["mean_particle_temperature"] = self._reference + solids_heat / solids if solids else math.nan
        return found | self._find_extremes()

    def _find_extremes(self) -> dict[str, float]:
        own = [self.gas.temperatures] if self.gas else []
        own += [self._liggghts_temperatures] if self._liggghts else []
        bounds = np.full(2, math.inf)
        for values in own:
            if len(values):
                bounds = np.minimum(bounds, (values.min(), -values.max()))
        self._comm.Allreduce(MPI.IN_PLACE, bounds, op=MPI.MIN)
        least, largest = np.where(np.isinf(bounds), math.nan, bounds * (1.0, -1.0)).tolist()
        return {"min_temperature": least, "max_temperature": largest}

    @property
    def _liggghts_temperatures(self) -> np.ndarray:
        assert self._liggghts is not None
        return self._liggghts.temperatures

    def _measure_held(self) -> float:
        """Heat [J] of this rank's particles."""
        if not self._liggghts:
            return 0.0
        return self._specific_heat * add_up_heat(self.masses, self._liggghts_temperatures, self._reference)[0]


_TOTALS = (
    *("gas_before", "gas_after", "walls", "inlets", "outlets", "continuity", "particles", "gas_scale"),
    *("solids_before", "given", "solids_given", "solids_moved", "solids_scale"),
)
"""What the ledger adds up over the ranks [J]."""
