"""Which simulation of Hamidouche et al. 2019 a run is: told by its effective case, never by its name."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from fbcouple.results.reader import Results

SHORTEST_WINDOW = 5.0
"""Averaging [s] below which a run decides nothing."""
AS_PRINTED = "e = 0.97"
AS_COMPUTED = "e = 1"
"""What the paper's Runge-Kutta step makes of its e = 0.97, within 2 %."""
_NUMERICS = {0.97: AS_PRINTED, 1.0: AS_COMPUTED}

# What all its simulations share (section 3, tables 1 and 2).
_SHARED: dict[str, Any] = {
    "domain.size": [0.08, 0.015, 0.25],
    "gas.density": 1.165,
    "gas.viscosity": 2e-5,
    "particles.diameter": 1e-3,
    "particles.density": 2500.0,
    "particles.rotation": False,
    "exchange.drag": "huilin-gidaspow",
    "exchange.filter_passes": 1,
    "exchange.pressure_gradient": True,
}
# What none of them has: absent or empty, or as the second says.
_ABSENT: dict[str, Any] = {
    "domain.periodic": None,
    "particles.mixture": None,
    "particles.sizes": None,
    "particles.spread": None,
    "contact.pairs": None,
    "contact.walls": None,
    "contact.model": "hooke",
    "contact.tangential": "no-history",
    "exchange.voidage": "trilinear",
    "exchange.diffusion_width": None,
}
_NOZZLES = {(17, 3, 55): [3, 3], (35, 6, 110): [5, 4], (70, 12, 220): [10, 8]}


# Numerics that the paper tells: what it prints, or the range of what it does not; a run may have others and be told so.
_TOLD: dict[str, tuple[float, float]] = {
    "gas.max_courant": (0.2, 0.2),
    "gas.max_fourier": (0.15, 0.15),
    "contact.steps_per_contact": (6, 1000),
    "contact.stiffness": (300.0, 1500.0),
}


SUB_GRID_MODELS = ("localized-dynamic", "smagorinsky", "dynamic-lagrangian", "keqn")
"""Options of `gas.turbulence` that are a model; the first is the paper's."""


@dataclass(frozen=True)
class Bed:
    """A row of table 3: bed mass [kg], superficial velocity [m/s], friction between particles and at walls, mesh, and
    which sub-grid models a run of it may have."""

    mass: float
    velocity: float
    friction: float
    wall_friction: float
    cells: tuple[int, int, int] = (35, 6, 110)
    models: tuple[str, ...] = SUB_GRID_MODELS
    walls: str = "no-slip"


BEDS: dict[str, Bed] = {
    "c1": Bed(0.075, 1.20, 0.2, 0.2, (17, 3, 55)),
    "c2": Bed(0.075, 1.20, 0.2, 0.2),
    "c3": Bed(0.075, 1.20, 0.2, 0.2, (70, 12, 220)),
    "c2-slip": Bed(0.075, 1.20, 0.2, 0.2, walls="slip"),
    "c3-slip": Bed(0.075, 1.20, 0.2, 0.2, (70, 12, 220), walls="slip"),
    "c4-0.0": Bed(0.075, 1.20, 0.1, 0.0),
    "c4-0.1": Bed(0.075, 1.20, 0.1, 0.1),
    "c4-0.2": Bed(0.075, 1.20, 0.1, 0.2),
    "c4-0.4": Bed(0.075, 1.20, 0.1, 0.4),
    "c5-0.0": Bed(0.075, 1.20, 0.0, 0.1),
    "c5-0.1": Bed(0.075, 1.20, 0.1, 0.1),
    "c5-0.2": Bed(0.075, 1.20, 0.2, 0.1),
    "c5-0.4": Bed(0.075, 1.20, 0.4, 0.1),
    "c6": Bed(0.075, 1.71, 0.1, 0.1),
    "c7": Bed(0.125, 1.54, 0.1, 0.1),
    "c6-smagorinsky": Bed(0.075, 1.71, 0.1, 0.1, models=("smagorinsky",)),
    "a1": Bed(0.075, 1.71, 0.1, 0.1, models=("none",)),
}


def identify(results: Results) -> tuple[str, list[str]]:
    """Tell which numerics (`AS_PRINTED`, `AS_COMPUTED`) and which rows of `BEDS` a run is; no row if it is none."""
    return identify_case(results.case)


def identify_case(case: dict[str, Any]) -> tuple[str, list[str]]:
    """The same of an effective case."""
    if not all(_agrees(_look_up(case, key), wanted) for key, wanted in _SHARED.items()):
        return "", []
    if any(_look_up(case, key) and _look_up(case, key) != allowed for key, allowed in _ABSENT.items()):
        return "", []
    restitution = _look_up(case, "contact.restitution")
    cells = tuple(_look_up(case, "domain.cells"))
    if restitution not in _NUMERICS or _look_up(case, "contact.wall_restitution") != restitution:
        return "", []
    if cells not in _NOZZLES or _look_up(case, "gas.closed_nozzle") != _NOZZLES[cells]:
        return "", []
    return _NUMERICS[restitution], [name for name, bed in BEDS.items() if _is_bed(case, bed, cells)]


def name_differences(results: Results) -> list[str]:
    """Numerics of a run of the paper's that are not the paper's, with their values; the bed is the same."""
    found = []
    for key, (least, most) in _TOLD.items():
        value = _look_up(results.case, key)
        if value is not None and not least <= value <= most:
            found.append(f"{key} = {value:g}")
    model = _look_up(results.case, "gas.turbulence")
    return [*found, f"gas.turbulence = {model}"] if model in SUB_GRID_MODELS[1:] else found


def _is_bed(case: dict[str, Any], bed: Bed, cells: tuple[int, ...]) -> bool:
    pairs = {
        "gas.inlet_velocity": bed.velocity,
        "contact.friction": bed.friction,
        "contact.wall_friction": bed.wall_friction,
        "gas.walls": bed.walls,
    }
    fits = all(_agrees(_look_up(case, key), wanted) for key, wanted in pairs.items())
    return fits and cells == bed.cells and _look_up(case, "gas.turbulence") in bed.models and _weighs(case, bed.mass)


def _weighs(case: dict[str, Any], mass: float) -> bool:
    particles = case["particles"]
    one = particles["density"] * math.pi / 6.0 * particles["diameter"] ** 3
    given = particles.get("mass") or particles.get("count", 0) * one
    return abs(given - mass) <= one


def _look_up(case: dict[str, Any], key: str) -> Any:
    section, _, name = key.partition(".")
    return (case.get(section) or {}).get(name)


def _agrees(given: Any, wanted: Any) -> bool:
    if isinstance(wanted, float):
        return isinstance(given, int | float) and math.isclose(given, wanted, rel_tol=1e-9)
    return bool(given == wanted)


def averaged_time(results: Results) -> float:
    """Length [s] of the averaging window that the run got through; 0 if it has not begun."""
    return 0.0 if results.window is None else max(results.window[1] - results.window[0], 0.0)


def sort_runs(runs: Iterable[Results]) -> tuple[dict[str, dict[str, Results]], dict[str, str]]:
    """Sort runs by numerics and name of `BEDS`. Of two runs of one bed that with the paper's sub-grid model counts, and
    of two that have it, or have not, the one that averaged longer; the other is the twin, if the bed has two names.

    Returns: numerics -> name -> run, and for each name why a run of it was left out (averaged too short).
    """
    found: dict[str, dict[str, list[Results]]] = {AS_PRINTED: {}, AS_COMPUTED: {}}
    left_out: dict[str, str] = {}
    for run in runs:
        numerics, names = identify(run)
        for name in names:
            if averaged_time(run) < SHORTEST_WINDOW:
                which = run.label or run.path.parent.name
                left_out[name] = f"{which} averaged {averaged_time(run):.3g} s, needed {SHORTEST_WINDOW:g} s"
            else:
                found[numerics].setdefault(name, []).append(run)
    chosen = {
        numerics: {name: _choose(name, known) for name, known in names.items()} for numerics, names in found.items()
    }
    return chosen, left_out


def _choose(name: str, runs: list[Results]) -> Results:
    """Of the `runs` of a bed the one that counts for it under `name`."""
    ranked = sorted(runs, key=_rank, reverse=True)
    place = [other for other, bed in BEDS.items() if bed == BEDS[name]].index(name)
    is_alike = len(ranked) > place and _rank(ranked[place])[0] == _rank(ranked[0])[0]
    return ranked[place] if is_alike else ranked[0]


def list_twins(runs: Iterable[Results]) -> list[tuple[str, Results, Results]]:
    """Pairs of runs of one bed from different seeds, that averaged long enough: its first name, and both."""
    beds: dict[tuple[str, str], list[Results]] = {}
    for run in runs:
        numerics, names = identify(run)
        if names and averaged_time(run) >= SHORTEST_WINDOW:
            beds.setdefault((numerics, names[0]), []).append(run)
    return [
        (name, one, other)
        for (_, name), known in beds.items()
        for one, other in combinations(sorted(known, key=_rank, reverse=True), 2)
        if _look_up(one.case, "start.seed") != _look_up(other.case, "start.seed")
        and _look_up(one.case, "gas.turbulence") == _look_up(other.case, "gas.turbulence")
    ]


def _rank(run: Results) -> tuple[bool, float]:
    """What makes one of two runs of a bed count."""
    return _look_up(run.case, "gas.turbulence") not in SUB_GRID_MODELS[1:], averaged_time(run)
