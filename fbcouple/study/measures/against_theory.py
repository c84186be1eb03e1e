"""Measures against numbers that follow from physics: a lone particle, a held bed, the weight of a bed."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from fbcouple.case.bed.drag_balance import find_balance, find_drag
from fbcouple.case.bed.lattice import lay_out
from fbcouple.case.bed.particle_types import Kind, list_kinds, particle_count
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.postproc.measures import mean_of_history
from fbcouple.study.measures.registry import Error, Finished, measure


def _fall(run: Finished) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and heights [m] of the particles' centre."""
    heights = run.results.history("solids_centre_z")
    return heights["time"].values.astype(float), heights.values


def _rise(case: Case) -> float:
    """Velocity [m/s] of the gas far from the particles."""
    if case.gas is None or case.gas.inlet_velocity is None:
        raise CaseError(["terminal-velocity and path need gas.inlet_velocity."])
    return case.gas.inlet_velocity


def _take_only_kind(case: Case, name: str) -> Kind:
    """The kind of particles (or parcels) of a bed that has one. Raises: CaseError if there is none, or several."""
    kinds = list_kinds(case.particles) if case.particles else []
    if case.gas is None or case.exchange is None or not kinds:
        raise CaseError([f"{name} needs gas, particles and [exchange]."])
    if len(kinds) > 1:
        text = f"the case has {len(kinds)} kinds of particles (mixture, spread, or sizes of a file), one is allowed"
        raise CaseError([f"{name}: {text}, for the expected number is that of equal spheres; take another measure."])
    return kinds[0]


@measure("terminal-velocity")
def measure_fall(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Slip of a lone particle over the last tenth of the run against its drag law's balance with the weight."""
    time, height = _fall(run)
    late = time >= 0.9 * time[-1]
    slip = _rise(run.case) - float(np.polyfit(time[late], height[late], 1)[0])
    expected = _find_terminal(run.case, "terminal-velocity")
    return Error(slip, expected, "m s-1", abs(slip / expected - 1.0))


def _find_terminal(case: Case, name: str) -> float:
    """Speed [m/s] at which drag carries the weight of a lone particle of the measure `name`."""
    return find_balance(case, 1.0, None, _take_only_kind(case, name))


@measure("path")
def measure_path(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Largest distance of a lone particle, which starts at rest, from the solution of its equation of motion in
    gas of the inlet's velocity, over the way of its terminal velocity."""
    time, height = _fall(run)
    exact = height[0] + _solve_path(run.case, time)
    worst = int(np.abs(height - exact).argmax())
    scale = _find_terminal(run.case, "path") * time[-1]
    return Error(float(height[worst]), float(exact[worst]), "m", float(abs(height[worst] - exact[worst])) / scale)


def _solve_path(case: Case, time: np.ndarray) -> np.ndarray:
    """Way [m] of a lone particle: m dv/dt = beta(|u - v|)(u - v) - V (rho_p - rho) g; of a parcel with the drag of
    all its grains."""
    kind, rise = _take_only_kind(case, "path"), _rise(case)
    assert case.gas is not None
    weight = kind.volume * (kind.density - case.gas.density) * case.gravity

    def move(_: float, state: np.ndarray) -> tuple[float, float]:
        slip = rise - state[1]
        return state[1], (find_drag(case, 1.0, abs(slip), None, kind) * slip - weight) / kind.mass

    solved = solve_ivp(move, (0.0, time[-1]), (0.0, 0.0), t_eval=time, rtol=1e-9, atol=1e-13)
    return solved.y[0]


@measure("bed-pressure")
def measure_bed(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Pressure over a held lattice bed at the end of the run against its drag law at the lattice's voidage, and the
    gas's gain of head at its surface: dp = n beta u/eps L - rho U^2/2 (1/eps^2 - 1), u = U/eps (model A); n counts
    the parcels of a coarse-grained bed, beta and the voidage are theirs."""
    case = run.case
    kind, superficial = _take_only_kind(case, "bed-pressure"), _rise(case)
    assert case.gas is not None and case.particles is not None
    if case.start is None or case.domain.shape != "box" or case.start.region is not None:
        raise CaseError(["bed-pressure needs a box whose floor the lattice of [start] fills, without start.region."])
    layout = lay_out(case)
    layers = particle_count(case.particles) / (layout.columns * layout.rows)
    per_volume = 1.0 / math.prod(layout.spacing)
    voidage = 1.0 - per_volume * kind.volume
    velocity = superficial / voidage
    beta = find_drag(case, voidage, velocity, None, kind)
    head = 0.5 * case.gas.density * superficial**2 * (1.0 / voidage**2 - 1.0)
    expected = per_volume * beta * velocity / voidage * layers * layout.spacing[2] - head
    value = float(run.results.history("pressure_drop").values[-1])
    return Error(value, expected, "Pa", abs(value / expected - 1.0))


@measure("bed-weight")
def measure_weight(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Time-mean pressure drop of a fluidized bed against its weight less its buoyancy over its cross-section."""
    mean, expected = mean_of_history(run.results, "pressure_drop"), run.results.weight_per_area
    if not expected:
        raise CaseError(["bed-weight needs gas, particles and gravity."])
    return Error(mean.value, expected, "Pa", abs(mean.value / expected - 1.0), mean.error / expected)
