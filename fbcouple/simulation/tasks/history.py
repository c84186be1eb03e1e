"""The history: a row of numbers when one is due, in memory and in logs/run.jsonl."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.derived import has_ramp
from fbcouple.case.bed.streams import has_openings, list_outlets
from fbcouple.case.schema.gas import Gas
from fbcouple.paths import LOG
from fbcouple.results.inlet_speed import find_mean
from fbcouple.results.line_log import append_line, read_log
from fbcouple.simulation.clock import Cadence
from fbcouple.simulation.heat import FLOWS
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.averages import Averages
from fbcouple.simulation.tasks.diagnostics import find_weight
from fbcouple.simulation.tasks.limits import JUDGED_ONLY
from fbcouple.simulation.tasks.monitors import Monitors
from fbcouple.simulation.tasks.task import Saved, Task
from fbcouple.simulation.tasks.writing import writing

_ROWS = "history.jsonl"


class History(Task):
    """Rows of what `Monitors` measured, with extremes and time means since the row before."""

    def __init__(self, sim: Simulation, run: Path, monitors: Monitors, averages: Averages | None = None) -> None:
        """`averages`: what knows where the means begin and the error that they have reached."""
        self._run, self._monitors = run, monitors
        self._sure = averages.until_sure if averages else None
        self._start_up = averages.start_up if averages else None
        for reader in (self._start_up, self._sure):
            if reader:
                reader.read_rows = lambda: self.rows
        self.rows: list[dict[str, Any]] = []
        self.recorded_at = -1
        """The step of the last row."""
        self._cadence = Cadence(sim.case.output.record_every)
        self._since = dict.fromkeys((*_SINCE, *(_SINCE_HEAT if sim.heat else ())), 0.0)
        self._outlets = len(list_outlets(sim.case)) if sim.case.gas and has_openings(sim.case) else 1
        self._flows = np.zeros((self._outlets, 2))
        self._log = (run / LOG).open("a", encoding="utf-8") if sim.comm.rank == 0 else None

    def start(self, sim: Simulation) -> None:
        """The first row is that of the start (collective)."""
        self.after_step(sim)

    def after_step(self, sim: Simulation) -> None:
        """Follow the step; record it if a row is due (collective)."""
        self._follow(sim)
        if self._cadence.due(sim.time) or not sim.clock.running:
            self._record(sim)
        if self._looks_next(sim):
            self._monitors.prepare(sim)

    def _follow(self, sim: Simulation) -> None:
        report, since = sim.gas_report, self._since
        if report and sim.case.gas:
            inlet = self._monitors.inlet
            since["inflow_error"] = max(since["inflow_error"], self._monitors.numbers["inflow_error"])
            since["courant"] = max(since["courant"], report.courant)
            since["mass_error"] = max(since["mass_error"], inlet.find_loss(report, sim.dt))
            since["elapsed"] += sim.dt
            since["inflow_time"] += report.inflow * sim.dt
            since["pressure_time"] += report.inlet_pressure * sim.dt
            since["backflow_time"] += report.backflow * sim.dt
            since["outflow_time"] += report.outflow * sim.dt
            if self._outlets > 1:
                self._flows += sim.gas.measure_outlets(self._outlets) * sim.dt
            since["support_time"] += sim.conservation.support * sim.dt
            since["displaced_wrongly"] += report.displaced_wrongly
        if sim.heat:
            since["heat_error"] = max(since["heat_error"], sim.heat.error)
            since["heat_time"] += sim.dt
            for name, heat in sim.heat.flows.items():
                since[name] += heat
        since["momentum_error"] = max(since["momentum_error"], sim.conservation.momentum_error)

    def _looks_next(self, sim: Simulation) -> bool:
        """Will the step to come be recorded, or may a checkpoint be written after it?"""
        clock = sim.clock
        is_moment = (clock.steps + 1) % sim.case.checkpoint.moment_steps == 0
        return is_moment or self._cadence.is_due(clock.time + clock.dt)

    def _record(self, sim: Simulation) -> None:
        with sim.timers("record"):
            row = self._measure(sim)
        mine = sim.timers.restart()
        row["wall"] = {stage: sim.comm.allreduce(seconds, max) for stage, seconds in mine.items()}
        self.rows.append(row)
        self.recorded_at = sim.clock.steps
        if self._log:
            with writing(self._run, LOG):
                append_line(self._log, row)

    def _measure(self, sim: Simulation) -> dict[str, Any]:
        row: dict[str, Any] = {"time": sim.time, "steps": sim.clock.steps, "substeps": sim.substeps}
        row |= {name: value for name, value in self._monitors.inspect(sim).items() if name not in JUDGED_ONLY}
        since, elapsed = self._since, self._since["elapsed"]
        if sim.has_gas:
            row.setdefault("gas_flux_error", float("nan"))
            row["pressure_drop"] = since["pressure_time"] / elapsed if elapsed else float("nan")
            if sim.case.gas and has_ramp(sim.case.gas):
                area = self._monitors.inlet.area
                row["inlet_velocity"] = since["inflow_time"] / elapsed / area if elapsed else float("nan")
            if sim.case.gas and sim.case.gas.top == "open":
                passed = since["outflow_time"] + since["backflow_time"]
                row["gas_backflow"] = since["backflow_time"] / passed if passed else 0.0
                if self._outlets > 1:
                    row["outlet_backflow"] = _find_parts(self._flows)
            row |= {"gas_mass_error": since["mass_error"], "max_courant": since["courant"]}
            row["gas_inflow_error"] = since["inflow_error"]
        if self._start_up:
            row["averages_start"] = self._start_up.begin if self._start_up.is_over else math.nan
        if self._sure:
            row |= {"averages_error": self._sure.error, "expected_end": self._sure.expected_end}
        if sim.is_coupled:
            row["momentum_error"] = since["momentum_error"]
            row["displaced_gas_error"] = since["displaced_wrongly"] / (row["solids_volume"] or math.inf)
            row["gas_support"] = since["support_time"] / elapsed / find_weight(sim) if elapsed else 0.0
        if sim.heat:
            row |= sim.heat.measure(sim.gas.voidage if sim.has_gas else None)
            row["heat_error"] = since["heat_error"]
            row |= {name: since[name] / since["heat_time"] if since["heat_time"] else 0.0 for name in sim.heat.flows}
        self._since = dict.fromkeys(since, 0.0)
        self._flows[:] = 0.0
        return row

    def save(self, sim: Simulation, folder: Path) -> Saved:
        """When the next row is due, what was followed since the last, and all rows in a file of their own."""
        if sim.comm.rank == 0:
            with (folder / _ROWS).open("w", encoding="utf-8") as file:
                for row in self.rows:
                    append_line(file, row)
        numbers = {"next": self._cadence.next, "outlets": self._flows.tolist()} | self._since
        return Saved(numbers, files=[_ROWS])

    def load(self, sim: Simulation, saved: Saved, folder: Path) -> None:
        """Go on from `saved`."""
        self._cadence.next = saved.numbers["next"]
        self._since = {name: saved.numbers[name] for name in self._since}
        self._flows[:] = saved.numbers["outlets"]
        self.rows = read_log(folder / _ROWS)
        if sim.case.gas and has_ramp(sim.case.gas):
            _fill_in_velocity(self.rows, sim.case.gas)


def _find_parts(flows: np.ndarray) -> list[float]:
    """Of the gas that passed each outlet, out and in (n, 2), the part that came in."""
    passed = flows.sum(axis=1)
    return np.divide(flows[:, 1], passed, out=np.zeros(len(flows)), where=passed > 0.0).tolist()


def _fill_in_velocity(rows: list[dict[str, Any]], gas: Gas) -> None:
    """Rows of a run whose inlet was constant up to then, and is not from now on, get its velocity."""
    told, start = gas.model_dump(), 0.0
    for row in rows:
        if "inlet_velocity" not in row:
            row["inlet_velocity"] = find_mean(told, start, row["time"]) if row["time"] > start else math.nan
        start = row["time"]


_SINCE = (
    "momentum_error",
    "mass_error",
    "inflow_error",
    "courant",
    "elapsed",
    "inflow_time",
    "pressure_time",
    "backflow_time",
    "outflow_time",
    "support_time",
    "displaced_wrongly",
)
"""What is followed from row to row."""
_SINCE_HEAT = ("heat_error", "heat_time", *FLOWS)
"""The same of a case with heat."""
