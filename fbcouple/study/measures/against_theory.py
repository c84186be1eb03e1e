"""Measures against numbers that follow from physics: a lone particle, a held bed, the weight of a bed."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from fbcouple.case.bed import derived
from fbcouple.case.bed.drag_balance import terminal_velocity
from fbcouple.case.bed.lattice import lay_out
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


@measure("terminal-velocity")
def measure_fall(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Slip of a lone particle over the last tenth of the run against its drag law's balance with the weight."""
    time, height = _fall(run)
    late = time >= 0.9 * time[-1]
    slip = _rise(run.case) - float(np.polyfit(time[late], height[late], 1)[0])
    expected = terminal_velocity(run.case)
    return Error(slip, expected, "m s-1", abs(slip / expected - 1.0))


@measure("path")
def measure_path(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Largest distance of a lone particle, which starts at rest, from the solution of its equation of motion in
    gas of the inlet's velocity, over the way of its terminal velocity."""
    time, height = _fall(run)
    exact = height[0] + _solve_path(run.case, time)
    worst = int(np.abs(height - exact).argmax())
    scale = terminal_velocity(run.case) * time[-1]
    return Error(float(height[worst]), float(exact[worst]), "m", float(abs(height[worst] - exact[worst])) / scale)


def _solve_path(case: Case, time: np.ndarray) -> np.ndarray:
    """Way [m] of a lone particle: m dv/dt = beta(|u - v|)(u - v) - V (rho_p - rho) g."""
    from fbcouple.case.user_laws import DRAG_LAWS  # noqa: PLC0415  (loads numba)

    assert case.gas is not None and case.particles is not None and case.exchange is not None
    law, gas, particles, rise = DRAG_LAWS[case.exchange.drag], case.gas, case.particles, _rise(case)
    weight = derived.particle_volume(particles) * (particles.density - gas.density) * case.gravity

    def move(_: float, state: np.ndarray) -> tuple[float, float]:
        slip = rise - state[1]
        beta = float(law(1.0, abs(slip), particles.diameter, gas.density, gas.viscosity))
        return state[1], (beta * slip - weight) / derived.particle_mass(particles)

    solved = solve_ivp(move, (0.0, time[-1]), (0.0, 0.0), t_eval=time, rtol=1e-9, atol=1e-13)
    return solved.y[0]


@measure("bed-pressure")
def measure_bed(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Pressure over a held lattice bed at the end of the run against its drag law at the lattice's voidage, and the
    gas's gain of head at its surface: dp = n beta u/eps L - rho U^2/2 (1/eps^2 - 1), u = U/eps (model A)."""
    from fbcouple.case.user_laws import DRAG_LAWS  # noqa: PLC0415  (loads numba)

    case = run.case
    if case.gas is None or case.particles is None or case.exchange is None or case.start is None:
        raise CaseError(["bed-pressure needs gas and particles on the lattice of [start]."])
    layout, superficial = lay_out(case), _rise(case)
    per_volume = 1.0 / math.prod(layout.spacing)
    voidage = 1.0 - per_volume * derived.particle_volume(case.particles)
    velocity = superficial / voidage
    beta = float(
        DRAG_LAWS[case.exchange.drag](voidage, velocity, case.particles.diameter, case.gas.density, case.gas.viscosity)
    )
    head = 0.5 * case.gas.density * superficial**2 * (1.0 / voidage**2 - 1.0)
    expected = per_volume * beta * velocity / voidage * layout.layers * layout.spacing[2] - head
    value = float(run.results.history("pressure_drop").values[-1])
    return Error(value, expected, "Pa", abs(value / expected - 1.0))


@measure("bed-weight")
def measure_weight(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Time-mean pressure drop of a fluidized bed against its weight less its buoyancy over its cross-section."""
    mean, expected = mean_of_history(run.results, "pressure_drop"), run.results.weight_per_area
    if not expected:
        raise CaseError(["bed-weight needs gas, particles and gravity."])
    return Error(mean.value, expected, "Pa", abs(mean.value / expected - 1.0), mean.error / expected)
