"""The beds of Hamidouche et al. 2019, and which of them an effective case is.

A case is of the paper if it says nothing that the paper's does not: an option counts unless it is named here as one in
which runs of a bed may differ, so that a new model is none of the paper's until it is looked at.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

AS_PRINTED = "e = 0.97"
AS_COMPUTED = "e = 1"
"""What the paper's Runge-Kutta step makes of its e = 0.97, within 2 %."""
_CONTACTS = {0.97: AS_PRINTED, 1.0: AS_COMPUTED}

# What all its simulations share (section 3, tables 1 and 2), and every case of it says.
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
# The same of what older cases do not say.
_PLAIN: dict[str, Any] = {
    "gravity": 9.81,
    "domain.shape": "box",
    "gas.top": "open",
    "particles.fractions": "mass",
    "particles.classes": 8,
    "particles.coarse_graining": 1.0,
    "contact.model": "hooke",
    "contact.tangential": "no-history",
    "contact.rolling_friction": 0.0,
    "contact.scale_restitution": True,
    "start.method": "lattice",
    "start.spacing": 1.03,
    "start.jitter": 0.5,
    "exchange.polydisperse": "none",
    "exchange.scheme": "exponential",
    "exchange.voidage": "trilinear",
    "exchange.viscous_force": False,
    "exchange.lift_force": False,
    "exchange.virtual_mass": False,
}
# What tells its simulations from each other.
_OF_BEDS = (
    *("domain.cells", "gas.closed_nozzle", "gas.inlet_velocity", "gas.walls", "gas.turbulence"),
    *("particles.mass", "particles.count"),
    *("contact.restitution", "contact.wall_restitution", "contact.friction", "contact.wall_friction"),
)
# In what runs of a bed may differ: seeds, how long they are, what is kept of them, and what is for speed alone.
_ANY = (
    *("title", "end_time", "accuracy", "gas.max_step", "contact.skin"),
    *("start.seed", "start.settle_limit", "start.rest_speed", "particles.positions_seed"),
)
_ANY_SECTIONS = ("averages", "output", "checkpoint", "monitors")
_NOZZLES = {(17, 3, 55): [3, 3], (35, 6, 110): [5, 4], (70, 12, 220): [10, 8]}
NUMERICS: dict[str, tuple[float, float]] = {
    "gas.max_courant": (0.2, 0.2),
    "gas.max_fourier": (0.15, 0.15),
    "gas.correctors": (2, 20),
    "gas.pressure_tolerance": (0.0, 1e-5),
    "contact.steps_per_contact": (6, 1000),
    "contact.stiffness": (300.0, 1500.0),
}
"""What the paper prints, or the range of what it does not; a run may have others and be told so."""
_KNOWN = {*_SHARED, *_PLAIN, *_OF_BEDS, *_ANY, *NUMERICS}

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


def identify_case(case: dict[str, Any]) -> tuple[str, list[str]]:
    """Tell which contacts (`AS_PRINTED`, `AS_COMPUTED`) and which rows of `BEDS` an effective case has; no row if it is
    none."""
    return ("", []) if list_strangers(case) else name_nearest(case)


def list_strangers(case: dict[str, Any]) -> list[str]:
    """Options of a case, with their values, that no simulation of the paper has."""
    lacking = [key for key, wanted in _SHARED.items() if not _agrees(look_up(case, key), wanted)]
    others = [key for key, value in _flatten(case) if key not in _KNOWN or not _is_plain(key, value)]
    return [f"{key} = {_word(look_up(case, key))}" for key in [*lacking, *others]]


def name_nearest(case: dict[str, Any]) -> tuple[str, list[str]]:
    """Which a case would be, as `identify_case` tells it, without its strange options."""
    restitution, given = look_up(case, "contact.restitution"), look_up(case, "domain.cells")
    cells = tuple(given) if isinstance(given, list) else ()
    if restitution not in _CONTACTS or look_up(case, "contact.wall_restitution") != restitution:
        return "", []
    if cells not in _NOZZLES or look_up(case, "gas.closed_nozzle") != _NOZZLES[cells]:
        return "", []
    return _CONTACTS[restitution], [name for name, bed in BEDS.items() if _is_bed(case, bed, cells)]


def look_up(case: dict[str, Any], key: str) -> Any:
    """The value of `section.key`, or of a key of the top, in a case; None where it has none."""
    section, _, name = key.rpartition(".")
    table = case.get(section) if section else case
    return table.get(name) if isinstance(table, dict) else None


def _flatten(case: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Options of a case that count, and hold something."""
    for key, value in case.items():
        if key in _ANY_SECTIONS:
            continue
        own = {f"{key}.{name}": given for name, given in value.items()} if isinstance(value, dict) else {key: value}
        yield from ((name, given) for name, given in own.items() if given is not None and given != [])


def _is_plain(key: str, value: Any) -> bool:
    return key not in _PLAIN or _agrees(value, _PLAIN[key])


def _word(value: Any) -> str:
    return "none" if value is None else str(value).lower() if isinstance(value, bool) else str(value)


def _is_bed(case: dict[str, Any], bed: Bed, cells: tuple[int, ...]) -> bool:
    pairs = {
        "gas.inlet_velocity": bed.velocity,
        "contact.friction": bed.friction,
        "contact.wall_friction": bed.wall_friction,
        "gas.walls": bed.walls,
    }
    fits = all(_agrees(look_up(case, key), wanted) for key, wanted in pairs.items())
    return fits and cells == bed.cells and look_up(case, "gas.turbulence") in bed.models and _weighs(case, bed.mass)


def _weighs(case: dict[str, Any], mass: float) -> bool:
    one = _SHARED["particles.density"] * math.pi / 6.0 * _SHARED["particles.diameter"] ** 3
    given = look_up(case, "particles.mass") or (look_up(case, "particles.count") or 0) * one
    return abs(given - mass) <= one


def _agrees(given: Any, wanted: Any) -> bool:
    if isinstance(wanted, bool) or isinstance(given, bool):
        return given is wanted
    if isinstance(wanted, float):
        return isinstance(given, int | float) and math.isclose(given, wanted, rel_tol=1e-9)
    return bool(given == wanted)
