"""What a DEM step, a fluid step and the exchange cost on a machine: measured once and kept by host, or as shipped."""

from __future__ import annotations

import json
import math
import platform
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from fbcouple.errors import CaseError, SolverError
from fbcouple.machine.cache import make_folder
from fbcouple.machine.whole_files import write_whole
from fbcouple.paths import cache_folder

FORMAT = 2
"""Of the file that is kept: another one is measured anew."""
LAWS = ("hooke", "hooke history", "hertz history")
"""Laws of contacts that cost differently: friction without memory, and a tangential spring that remembers."""
SUBGRID = ("smagorinsky", "keqn", "dynamic-lagrangian", "localized-dynamic")
"""Sub-grid models of the gas, as `gas.turbulence` names them."""
SHARED = ("dem", "cfd", "exchange")
"""Stages whose work a second rank makes dearer."""
USUAL_DIGITS = 4.5
"""Decades of a pressure solve that `corrector` is for."""


@dataclass(frozen=True)
class Coefficients:
    """Processor seconds of one rank, each per what its name says, and bytes.

    particle: a particle and DEM step, alone; neighbour: what a particle of a bed costs more, for those around it;
    rebuild: a particle of a bed and new list of neighbours; contact: a contact and DEM step, by law; dem_step,
    fluid_step, exchange_step: fixed; cell: a cell and fluid step but for the pressure; corrector: a cell and pressure
    solve; subgrid: a cell and fluid step, by sub-grid model; exchange_particle, exchange_cell: a fluid step; start_up,
    start_cell: before the first step; turnover: a fluid step after which LIGGGHTS begins anew, as feeds put particles
    in (not calibrated); shared: factor of what a stage costs each of several ranks over one alone;
    rank_memory, particle_memory, cell_memory: bytes; spread: factor within which the times repeat themselves; measured:
    where and when, "" of the shipped ones.
    """

    particle: float
    neighbour: float
    rebuild: float
    dem_step: float
    cell: float
    corrector: float
    fluid_step: float
    exchange_particle: float
    exchange_cell: float
    exchange_step: float
    start_up: float
    start_cell: float
    rank_memory: float
    particle_memory: float
    cell_memory: float
    spread: float
    turnover: float = 4.7e-3
    contact: Mapping[str, float] = field(default_factory=dict)
    subgrid: Mapping[str, float] = field(default_factory=dict)
    shared: Mapping[str, float] = field(default_factory=dict)
    measured: str = ""

    @property
    def is_shipped(self) -> bool:
        """Are these of another machine?"""
        return not self.measured


SHIPPED = Coefficients(
    particle=17e-9,
    neighbour=28e-9,
    rebuild=210e-9,
    dem_step=1.6e-6,
    cell=0.83e-6,
    corrector=0.30e-6,
    fluid_step=0.38e-3,
    exchange_particle=63e-9,
    exchange_cell=170e-9,
    exchange_step=0.23e-3,
    start_up=3.0,
    start_cell=2e-5,
    rank_memory=333e6,
    particle_memory=600.0,
    cell_memory=1900.0,
    spread=2.0,
    contact={"hooke": 35e-9, "hooke history": 66e-9, "hertz history": 61e-9},
    subgrid={"smagorinsky": 0.12e-6, "keqn": 0.38e-6, "dynamic-lagrangian": 0.77e-6, "localized-dynamic": 0.55e-6},
    shared={"dem": 1.07, "cfd": 1.20, "exchange": 1.20},
)
"""Of two cores of an x86-64 virtual machine, by `fbcouple bench calibrate` in processor time with nothing else on it;
`rebuild` from patil/c2 (41 lists in 600 steps). Their spread is that of usual machines."""


def find_file(host: str | None = None) -> Path:
    """Where the coefficients of `host`, by default this machine, are kept. Raises: SolverError without a cache."""
    name = re.sub(r"[^A-Za-z0-9._-]", "_", host or platform.node() or "unnamed")
    return cache_folder() / f"cost-{name}.json"


def load_coefficients() -> Coefficients:
    """The coefficients of this machine, or the shipped ones where it has not been measured.

    Raises: CaseError if what is kept is damaged.
    """
    try:
        path = find_file()
    except SolverError:
        return SHIPPED  # no home folder: nothing can be kept
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return SHIPPED
    except (OSError, ValueError) as error:
        raise CaseError([_format_damage(path, str(error))]) from error
    return read_coefficients(text, path)


def read_coefficients(text: str, path: Path) -> Coefficients:
    """Coefficients from JSON that lies at `path`. Raises: CaseError naming what is wrong with it."""
    try:
        content = json.loads(text)
        given = dict(content["coefficients"]) if content["format"] == FORMAT else None
    except (ValueError, LookupError, TypeError, RecursionError) as error:
        raise CaseError([_format_damage(path, "it is no table of coefficients")]) from error
    if given is None:
        raise CaseError([_format_damage(path, f"format {content['format']!r} is not {FORMAT}")])
    wrong = [
        name
        for name, value in flatten(given).items()
        if name != "measured" and not (isinstance(value, int | float) and math.isfinite(value) and value >= 0.0)
    ]
    names = {part.name for part in fields(Coefficients)}
    tables = {"contact": set(LAWS), "subgrid": set(SUBGRID), "shared": set(SHARED)}
    whole = names - {"turnover"} <= set(given) <= names and all(
        isinstance(given[name], dict) and set(given[name]) == parts for name, parts in tables.items()
    )
    if wrong or not whole or not isinstance(given["measured"], str):
        what = f"{', '.join(sorted(wrong))} is no number" if wrong else "its names are others"
        raise CaseError([_format_damage(path, what)])
    return Coefficients(**given)


def flatten(given: Mapping[str, Any]) -> dict[str, Any]:
    """The entries of the tables in `given` by names with a dot, beside the others."""
    flat: dict[str, Any] = {}
    for name, value in given.items():
        flat |= {f"{name}.{key}": part for key, part in value.items()} if isinstance(value, dict) else {name: value}
    return flat


def save_coefficients(found: Coefficients, about: Mapping[str, Any]) -> Path:
    """Keep what was measured on this machine, with what is said `about` it. Returns: the file. Raises: SolverError."""
    path = find_file()
    make_folder(path.parent)
    content = {"format": FORMAT, "host": platform.node(), **about, "coefficients": asdict(found)}
    try:
        write_whole(path, json.dumps(content, indent=1) + "\n")
    except OSError as error:
        raise SolverError(f"{path}: cannot be written ({error.strerror}); see FBCOUPLE_CACHE") from error
    return path


def scale(found: Coefficients, factor: float) -> Coefficients:
    """The same of a machine that takes `factor` times as long for everything."""
    times = (
        "particle",
        "neighbour",
        "rebuild",
        "dem_step",
        "cell",
        "corrector",
        "fluid_step",
        "exchange_particle",
        "exchange_cell",
        "exchange_step",
        "start_up",
        "start_cell",
        "turnover",
    )
    slower = {name: getattr(found, name) * factor for name in times}
    contact, subgrid = (
        {key: value * factor for key, value in table.items()} for table in (found.contact, found.subgrid)
    )
    return replace(found, **slower, contact=contact, subgrid=subgrid)


def _format_damage(path: Path, what: str) -> str:
    return f"{path}: the costs of this machine cannot be read ({what}); remove it, or run `fbcouple bench calibrate`."
