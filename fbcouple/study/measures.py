"""What a member's error is measured by, as a registry. To add one: a function under `@measure("name")`.

A measure compares a finished run with a number that follows from physics, with the finest member, or with measured
points; the case file calls it by its name, `name:argument` where it takes one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.integrate import solve_ivp

from fbcouple.case.bed import derived
from fbcouple.case.bed.drag_balance import terminal_velocity
from fbcouple.case.bed.lattice import lay_out
from fbcouple.case.problems import Problem, show, suggest
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.input_files.companion_files import find_companion
from fbcouple.input_files.measured_lines import QUANTITIES, parse_reference, read_line
from fbcouple.postproc.deviation import find_deviation
from fbcouple.postproc.experiment import read_run
from fbcouple.postproc.measures import mean_of_history
from fbcouple.results.depth_means import depth_average
from fbcouple.results.reader import Results
from fbcouple.results.writer import HISTORIES


@dataclass(frozen=True)
class Error:
    """A member's value beside the expected one, SI; `error` is relative to the measure's scale, `stderr` its
    statistical standard error where the value is a time mean."""

    value: float
    expected: float
    unit: str
    error: float
    stderr: float | None = None


@dataclass(frozen=True)
class Finished:
    """A finished run: its results and its case, which was checked."""

    results: Results
    case: Case


Function = Callable[[Finished, str, Finished | None], Error]


@dataclass(frozen=True)
class Measure:
    """A measure: its function, the arguments that it takes (none: it takes no argument), and what it compares with."""

    name: str
    function: Function
    arguments: tuple[str, ...]
    needs_reference: bool


MEASURES: dict[str, Measure] = {}


def measure(name: str, arguments: Sequence[str] = (), needs_reference: bool = False) -> Callable[[Function], Function]:
    """Register a measure under the name by which a study calls it."""

    def register(function: Function) -> Function:
        MEASURES[name] = Measure(name, function, tuple(arguments), needs_reference)
        return function

    return register


def check_measures(texts: Sequence[str], has_reference: bool) -> Iterator[Problem]:
    """Each text names a measure, with an argument that it takes, and what it compares with is there."""
    if not texts:
        yield Problem("measures", f"the list is empty; give one or more of: {', '.join(MEASURES)}.")
    for text in texts:
        name, _, argument = text.partition(":")
        if name not in MEASURES:
            close = suggest(name, MEASURES)
            hint = f"; did you mean `{close}`" if close else ""
            yield Problem("measures", f"{show(text)} is given, allowed are: {', '.join(MEASURES)}{hint}.")
            continue
        allowed = MEASURES[name].arguments
        if bool(allowed) != bool(argument) or (argument and argument not in allowed):
            close = suggest(argument, allowed)
            hint = f"; did you mean `{name}:{close}`" if close else ""
            wanted = f"{name}: and one of {', '.join(allowed)}" if allowed else f"`{name}` without an argument"
            yield Problem("measures", f"{show(text)} is given, {wanted} is allowed{hint}.")
        if MEASURES[name].needs_reference and not has_reference:
            yield Problem("measures", f"{show(text)} compares with the finest member; add [reference] with its keys.")


def find_error(text: str, run: Finished, reference: Finished | None) -> Error:
    """Measure `run` by the measure that `text` names.

    Raises: CaseError if the results lack what it needs.
    """
    name, _, argument = text.partition(":")
    return MEASURES[name].function(run, argument, reference)


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


@measure("finest", arguments=tuple(HISTORIES), needs_reference=True)
def compare_finest(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Root mean square distance of a history from the finest member's, over the range of that one."""
    assert reference is not None
    here, there = run.results.history(argument), reference.results.history(argument)
    known = np.isfinite(there.values)
    time, wanted = there["time"].values[known], there.values[known]
    found = np.isfinite(here.values)
    values = np.interp(time, here["time"].values[found], here.values[found])
    scale = float(np.ptp(wanted)) or abs(float(wanted[-1])) or 1.0
    error = float(np.sqrt(np.mean((values - wanted) ** 2))) / scale
    return Error(float(values[-1]), float(wanted[-1]), HISTORIES[argument][0], error)


@measure("history-mean", arguments=tuple(HISTORIES), needs_reference=True)
def compare_history_mean(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Time mean of a history over the averaging window against the finest member's; `stderr` is that of both."""
    assert reference is not None
    here, there = (mean_of_history(one.results, argument) for one in (run, reference))
    if not there.value:
        raise CaseError([f"history-mean:{argument}: the finest member's is 0, and nothing is a part of it."])
    error, chance = abs(here.value / there.value - 1.0), math.hypot(here.error, there.error) / abs(there.value)
    return Error(here.value, there.value, HISTORIES[argument][0], error, chance)


@measure("experiment", arguments=tuple(QUANTITIES))
def compare_experiment(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Root mean square distance of the time means from the measured points of a quantity, over the points' range."""
    means, errors, wanted = np.concatenate(_read_lines(run, "experiment", argument), axis=1)
    away, scale = find_deviation(means, wanted, errors), float(np.ptp(wanted))
    found = away.rms / scale, away.rms_error / scale
    return Error(float(means.mean()), float(wanted.mean()), QUANTITIES[argument], *found)


@measure("amplitude", arguments=tuple(QUANTITIES))
def compare_amplitude(run: Finished, argument: str, reference: Finished | None) -> Error:
    """How far the time means of a quantity vary along its measured lines, over what the measured points do: largest
    less smallest value, the mean over the lines; its `error` is the distance from 1, root mean square over them."""
    lines = [find_deviation(means, wanted, errors) for means, errors, wanted in _read_lines(run, "amplitude", argument)]
    found = np.array([line.amplitude for line in lines])
    chance = float(np.mean([line.amplitude_error for line in lines]))
    return Error(float(found.mean()), 1.0, "1", float(np.sqrt(np.mean((found - 1.0) ** 2))), chance)


def _read_lines(run: Finished, measure: str, quantity: str) -> list[np.ndarray]:
    """The lines of `quantity` that the case names, each as rows of time means at the measured points, their standard
    errors, and what was measured, (3, n)."""
    named = [parse_reference(text) for text in run.case.output.references]
    rows = []
    for line in (one for one in named if one.quantity == quantity):
        file = find_companion(run.results.path.parent, line.file, ".csv")
        points = read_line(line, file, run.results.size, run.results.corner)
        x, mean, error = read_run(run.results, line)
        spread = np.full(len(x), np.nan) if error is None else error
        rows.append(np.stack([np.interp(points.x, x, mean), np.interp(points.x, x, spread), points.value]))
    if not rows:
        raise CaseError([f"{measure}:{quantity}: the case names no such line in output.references."])
    return rows


@measure("means", arguments=tuple(QUANTITIES), needs_reference=True)
def compare_means(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Root mean square distance of a time mean over width and height from the finest member's, depth means both, over
    the range of that one; `stderr` is the distance that the block errors of the two alone would make."""
    return _compare_maps(run, argument, reference, lambda there: float(there.max() - there.min()))


@measure("maps", arguments=tuple(QUANTITIES), needs_reference=True)
def compare_maps(run: Finished, argument: str, reference: Finished | None) -> Error:
    """As `means`, over the root mean square of the finest member's map in place of its range: so the standard error of
    a map is told, `averages.until_error`."""
    return _compare_maps(run, argument, reference, lambda there: math.sqrt(float((there**2).mean())))


def _compare_maps(
    run: Finished, argument: str, reference: Finished | None, find_scale: Callable[[xr.DataArray], float]
) -> Error:
    assert reference is not None
    there = _average(reference.results, argument)
    here, own = (
        _average(run.results, name).interp(x=there["x"], z=there["z"]) for name in (argument, f"{argument}_stderr")
    )
    away = here - there
    noise = own**2 + _average(reference.results, f"{argument}_stderr") ** 2
    scale = find_scale(there)
    rms = math.sqrt(float((away**2).mean()))
    chance = math.sqrt(float(noise.where(np.isfinite(away)).mean()))
    return Error(float(here.mean()), float(there.mean()), QUANTITIES[argument], rms / scale, chance / scale)


def _average(results: Results, name: str) -> xr.DataArray:
    """Depth average of a time mean, of a vector its vertical component."""
    field = results.data[name].astype(float)
    return depth_average(field.sel(component="z") if "component" in field.dims else field)
