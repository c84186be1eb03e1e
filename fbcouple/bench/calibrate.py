"""`fbcouple bench calibrate`: what a step costs on this machine, from small beds that tell one cost after the other."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from fbcouple.bench.step_costs import UNITS, StepCosts
from fbcouple.bench.suite import measure_prepared
from fbcouple.bench.turns import OTHERS, QUIET, Row
from fbcouple.case.cost.coefficients import LAWS, SHIPPED, SUBGRID, USUAL_DIGITS, Coefficients, flatten
from fbcouple.case.cost.work import count_digits, share_ghosts
from fbcouple.case.schema.sections import Case
from fbcouple.results.tables import describe_machine

QUIETEST = 1.15
"""Least factor that measured coefficients are taken to be within: another minute of the same machine differs by it."""
LIFTS, RESTS = 1.2, 0.3
"""Superficial velocities [m/s] above and below the 0.54 m/s that fluidize the beads."""
MIXED = ("mixed", "later")
"""Scenes whose particles are no longer in the order of the lattice: with many contacts, and with few."""
Content = dict[str, Any]
Say = Callable[[str], None]


@dataclass(frozen=True)
class Scene:
    """A case, the ranks that it is run on, and simulated time before the measurement and of it [s]."""

    case: Case
    ranks: int
    warm: float
    seconds: float


def make_scene(
    law: str = "hooke",
    velocity: float = LIFTS,
    correctors: int = 2,
    count: int = 14_000,
    cells: tuple[int, int, int] = (16, 8, 32),
    spacing: float = 1.03,
    turbulence: str = "none",
) -> Case:
    """A bed of glass beads of 1 mm, on cells of 2.5 mm, that gas at `velocity` [m/s] lifts or flows through.

    law: of the contacts, as `Coefficients.contact` names it; spacing: of the lattice that it starts on, in diameters;
    turbulence: the sub-grid model of the gas.
    """
    contact: Content = {"restitution": 0.9, "wall_restitution": 0.9, "friction": 0.2, "wall_friction": 0.2}
    contact |= {"steps_per_contact": 8, "tangential": "no-history" if law == "hooke" else "history"}
    if law.startswith("hertz"):
        contact |= {"model": "hertz", "youngs_modulus": 5e6, "poisson_ratio": 0.25, "impact_speed": 1.0}
    else:
        contact |= {"stiffness": 400.0}
    gas: Content = {"density": 1.165, "viscosity": 2e-5, "inlet_velocity": velocity, "correctors": correctors}
    gas |= {"pressure_tolerance": 1e-5, "max_courant": 0.5, "max_fourier": 1.5, "turbulence": turbulence}
    return Case.model_validate(
        {
            "title": f"{count} beads, {law}, gas at {velocity:g} m/s, {correctors} pressure corrections",
            "end_time": 10.0,
            "domain": {"size": [2.5e-3 * number for number in cells], "cells": list(cells)},
            "gas": gas,
            "particles": {"diameter": 1e-3, "density": 2500.0, "count": count, "rotation": law != "hooke"},
            "contact": contact,
            "start": {"spacing": spacing},
            "exchange": {"filter_passes": 1},
        }
    )


def list_scenes() -> dict[str, Scene]:
    """The scenes by name: a bed that has moved until it is mixed, at two times, for particles among others and their
    contacts; beds that begin to move, for the gas, each sub-grid model and the exchange; beds that rest, for contacts
    that remember, each named by its law; two that have hardly any contacts or hardly anything.

    A bed still in the order of its lattice is cheaper: what comes next in memory, and what touches, can be guessed.
    """
    mixed = Scene(make_scene(), 1, 0.25, 0.04)
    scenes = {"mixed": mixed, "two ranks": replace(mixed, ranks=2)}
    scenes["later"] = replace(mixed, warm=0.4)
    for correctors in (1, 2, 3):
        scenes[f"{correctors} corrections"] = Scene(make_scene(correctors=correctors), 1, 0.05, 0.03)
    for model in SUBGRID:
        scenes[model] = Scene(make_scene(turbulence=model), 1, 0.05, 0.02)
    for law in LAWS[1:]:
        scenes[law] = Scene(make_scene(law, RESTS, count=8000), 1, 0.04, 0.02)
    scenes["dilute"] = Scene(make_scene(cells=(16, 8, 64), count=4000, spacing=3.0), 1, 0.005, 0.04)
    scenes["tiny"] = Scene(make_scene(cells=(4, 4, 8), count=60, spacing=2.0), 1, 0.005, 0.06)
    return scenes


def calibrate(say: Say = lambda text: None) -> tuple[Coefficients, list[Row]]:
    """Run the scenes and find the coefficients of this machine; `say` is told of each scene before it runs.

    Returns: the coefficients, and a row a scene with what it took. Raises: SolverError.
    """
    found: dict[str, StepCosts] = {}
    rows = []
    begin = time.time()
    for name, scene in list_scenes().items():
        say(f"{name}: {scene.case.title}, {scene.ranks} rank{'s' if scene.ranks > 1 else ''}")
        told = measure_prepared("costs", scene.case, scene.ranks, scene.warm, scene.seconds)
        others = told.pop(OTHERS, None)
        found[name] = StepCosts(**told)
        rows.append(tell_scene(name, found[name]) | {OTHERS: others})
    coefficients = find_coefficients(found)
    if (busy := rows[list(found).index("two ranks")][OTHERS] or 0.0) > QUIET:
        words = "two ranks that wait for cores tell nothing of what they cost each other: that is as shipped"
        say(f"{busy:.2g} cores were others': {words}")
        coefficients = replace(coefficients, shared=SHIPPED.shared)
    measured = f"{platform.node()}, {describe_machine()}, {time.strftime('%Y-%m-%d %H:%M', time.gmtime(begin))} UTC"
    return replace(coefficients, measured=measured), rows


def tell_scene(name: str, costs: StepCosts) -> Row:
    """A row of a table: processor time of a unit of work of each phase."""
    own = costs.particles / costs.ranks or 1.0
    cells = costs.cells / costs.ranks or 1.0
    return {
        "scene": name,
        "ranks": costs.ranks,
        "particles": costs.particles,
        "contacts each": costs.contacts_each,
        "DEM steps a list": costs.dem_steps / costs.rebuilds if costs.rebuilds else None,
        "cells": costs.cells,
        "dem_ns": 1e9 * costs.phases["dem"] / costs.dem_steps / own,
        "cfd_us": 1e6 * costs.phases["cfd"] / costs.fluid_steps / cells,
        "exchange_ns": 1e9 * costs.phases["exchange"] / costs.fluid_steps / own,
        "spread": max(costs.spread.values(), default=1.0),
        "memory_MB": costs.memory / 1e6,
    }


def tabulate(found: Coefficients) -> list[Row]:
    """The coefficients beside those that are shipped, a row each."""
    own, shipped = (flatten(asdict(one)) for one in (found, SHIPPED))
    return [
        {"cost": name, "here": value, "shipped": shipped[name], "unit": _find_unit(name)}
        for name, value in own.items()
        if name != "measured"
    ]


def _find_unit(name: str) -> str:
    if name.endswith("memory"):
        return "bytes"
    return "1" if name == "spread" or name.startswith("shared") else "s"


def find_coefficients(found: Mapping[str, StepCosts]) -> Coefficients:
    """Coefficients from what the scenes of `list_scenes` took: each from those that differ in it.

    New lists of neighbours are too few in beds so small: theirs is as much dearer than a particle alone as of what is
    shipped. Bytes of particles and cells, and the start of a cell, are as shipped.
    """
    tiny, dilute, mixed = found["tiny"], found["dilute"], found["mixed"]
    dem = {name: costs.phases["dem"] / costs.dem_steps for name, costs in found.items()}
    particle = max((dem["dilute"] - dem["tiny"]) / (dilute.particles - tiny.particles), 0.0)
    dem_step = max(dem["tiny"] - particle * tiny.particles, 0.0)
    bed = {name: (dem[name] - dem_step) / costs.particles - particle for name, costs in found.items()}
    rebuild = SHIPPED.rebuild / SHIPPED.particle * particle
    neighbour, contact = _fit_beds(found, bed, rebuild)
    cell, corrector, fluid_step = _fit_gas(found)
    on_particles, on_cells, exchange_step = _fit_exchange(found)
    spread = max(max(costs.spread.values()) ** 0.5 for name, costs in found.items() if name in (*LAWS, *MIXED))
    coefficients = replace(
        SHIPPED,
        particle=particle,
        neighbour=neighbour,
        rebuild=rebuild,
        contact=contact,
        dem_step=dem_step,
        cell=cell,
        corrector=corrector,
        fluid_step=fluid_step,
        exchange_particle=on_particles,
        exchange_cell=on_cells,
        exchange_step=exchange_step,
        subgrid=_fit_subgrid(found),
        start_up=tiny.setting_up,
        rank_memory=tiny.memory,
        spread=max(spread, QUIETEST),
    )
    return replace(coefficients, shared=_compare_ranks(mixed, found["two ranks"], coefficients))


def _fit_beds(
    found: Mapping[str, StepCosts], bed: Mapping[str, float], rebuild: float
) -> tuple[float, dict[str, float]]:
    """Seconds a particle of a bed, and a contact by law: the first and contacts without memory by least squares, none
    below 0, of the beds that are mixed; the others by what is left of theirs.

    bed: seconds a particle and DEM step of each scene, without what a particle alone costs; rebuild: of a new list.
    """
    rest = {name: bed[name] - rebuild * costs.rebuilds / costs.dem_steps for name, costs in found.items()}
    rows = np.array([[1.0, found[name].contacts_each] for name in MIXED])
    neighbour, touch = _fit_positive(rows, np.array([rest[name] for name in MIXED]))
    contact = {law: max(rest[law] - neighbour, 0.0) / found[law].contacts_each for law in LAWS[1:]}
    return neighbour, {LAWS[0]: touch} | contact


def _fit_gas(found: Mapping[str, StepCosts]) -> tuple[float, float, float]:
    """Seconds a cell, a cell and corrector, and a step: least squares, none below 0, over the beds of one rank."""
    scenes = list_scenes()
    rows, values = [], []
    for name, costs in found.items():
        gas = scenes[name].case.gas
        # at rest the gas needs fewer iterations
        if costs.ranks == 1 and gas is not None and gas.turbulence == "none" and name not in LAWS:
            digits = count_digits(gas.pressure_tolerance, gas.max_courant) / USUAL_DIGITS
            rows.append([costs.cells, costs.cells * gas.correctors * digits, 1.0])
            values.append(costs.phases["cfd"] / costs.fluid_steps)
    cell, corrector, fixed = _fit_positive(np.array(rows), np.array(values))
    return cell, corrector, fixed


def _fit_subgrid(found: Mapping[str, StepCosts]) -> dict[str, float]:
    """Seconds a cell and fluid step of each sub-grid model, over the same bed without one."""
    alone = found["2 corrections"]
    plain = alone.phases["cfd"] / alone.fluid_steps
    costs = {model: found[model].phases["cfd"] / found[model].fluid_steps for model in SUBGRID}
    return {model: max(seconds - plain, 0.0) / alone.cells for model, seconds in costs.items()}


def _fit_exchange(found: Mapping[str, StepCosts]) -> tuple[float, float, float]:
    """Seconds a particle, a cell and a step, likewise."""
    rows = [[costs.particles, costs.cells, 1.0] for costs in found.values() if costs.ranks == 1]
    values = [costs.phases["exchange"] / costs.fluid_steps for costs in found.values() if costs.ranks == 1]
    particle, cell, fixed = _fit_positive(np.array(rows, dtype=float), np.array(values))
    return particle, cell, fixed


def _fit_positive(rows: np.ndarray, values: np.ndarray) -> list[float]:
    """Least squares of relative misses, (n, k) and (n,), whose negative parts are left out one after the other."""
    weighted = rows / values[:, None]
    kept = list(range(rows.shape[1]))
    while True:
        parts, *_ = np.linalg.lstsq(weighted[:, kept], np.ones(len(values)), rcond=None)
        if parts.min() >= 0.0 or len(kept) == 1:
            break
        kept.pop(int(np.argmin(parts * weighted[:, kept].mean(axis=0))))
    whole = np.zeros(rows.shape[1])
    whole[kept] = np.maximum(parts, 0.0)
    return whole.tolist()


def _compare_ranks(alone: StepCosts, two: StepCosts, found: Coefficients) -> dict[str, float]:
    """What the work of a stage costs each of two ranks, over half of what it costs one: 1 where nothing is lost.

    Without the fixed costs of a step, and without what the model has the ranks do for each other.
    """
    ghosts = share_ghosts(list_scenes()["two ranks"].case, 2)
    fixed = {"dem": found.dem_step, "cfd": found.fluid_step, "exchange": found.exchange_step}
    shared = {}
    for phase, steps in UNITS.items():
        of_one = alone.phases[phase] / getattr(alone, steps) - fixed[phase]
        of_two = two.phases[phase] / getattr(two, steps) - fixed[phase]
        known = 1.0 + ghosts if phase == "dem" else 1.0
        shared[phase] = max(2.0 * of_two / (of_one * known), 1.0)
    return shared
