"""What a plan may turn: preset and fluid step, overlap, mesh, parcels; with values that were measured and their errors.

A knob more is a function in `KNOBS` that gives its values for a case: the options that each sets, and what it errs.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fbcouple.case.bed.parcel_numbers import FEWEST_ACROSS, find_width
from fbcouple.case.bed.particle_types import find_ratio, largest_diameter
from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.speeds import find_largest_overlap, list_speeds
from fbcouple.case.cost.work import SPOUTED, count_work
from fbcouple.case.plan.measured_errors import (
    MESH,
    NUMERICS,
    OVERLAP,
    PARCELS,
    interpolate,
    list_errors,
    list_meshes,
    list_overlaps,
    list_ratios,
)
from fbcouple.case.presets import KEY, PRESETS
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

Settings = dict[str, Any]
COARSER = (0.75, 0.5)
"""Cells along an edge over those of the case: the coarser meshes that are looked at."""
_SPRING_KEYS = ("contact.max_overlap", "contact.stiffness", "contact.youngs_modulus")
_LEFT = ("contact.steps_per_contact", "contact.max_overlap")
"""Options of a preset that are its own to set, by the bed, and that another knob turns."""
_STEP_KEYS = tuple(key for key in PRESETS["standard"] if key not in _LEFT)
_MESH_KEY = "domain.cells"
_PARCEL_KEYS = ("particles.coarse_graining", "particles.parcels")


def _set_preset(name: str, **limits: float) -> Settings:
    values = {key: PRESETS[name][key] for key in _STEP_KEYS}
    return {KEY: name, **values} | {f"gas.max_{limit}": value for limit, value in limits.items()}


_STEPS = {
    "draft": _set_preset("draft"),
    "standard": _set_preset("standard"),
    "standard, Courant 1": _set_preset("standard", courant=1.0, fourier=1.0),
    "standard, Courant 0.5": _set_preset("standard", courant=0.5, fourier=0.15),
    "reference": _set_preset("reference"),
}


@dataclass(frozen=True)
class Value:
    """A value of a knob: in words, as settings on top of the case, and the error [of the range] that it adds, in
    squares, to the mean map of solids flux."""

    words: str
    settings: Settings
    error: float


@dataclass(frozen=True)
class Numerics:
    """A value of each knob: in words by the knob's name, the settings of all, and their numerical error together."""

    words: dict[str, str]
    error: float
    settings: Settings = field(default_factory=dict)

    def format(self) -> str:
        """All knobs in a line."""
        return ", ".join(self.words.values())


def list_steps(case: Case, folder: Path, held: Collection[str]) -> list[Value]:
    """The presets, and standard with shorter fluid steps; steps of a contact that a case itself has stay. Of a fluid
    step that is held the error goes by its Courant number."""
    assert case.gas is not None
    errors = list_errors(NUMERICS)
    if any(key in held for key in _STEP_KEYS):
        courant = case.gas.max_courant
        known = {_STEPS[name]["gas.max_courant"]: error for name, error in errors.items()}
        return [Value(f"Courant {courant:g}", {}, interpolate("gas.max_courant", known, courant))]
    wanted = [name for name in _STEPS if KEY not in held or _STEPS[name][KEY] == case.accuracy]
    if not wanted:
        names = ", ".join(PRESETS)
        raise CaseError(
            [f'{KEY}: "{case.accuracy}" is given, one of {names} is allowed: errors were measured of them.']
        )
    return [Value(name, _STEPS[name], errors[name]) for name in wanted]


def list_springs(case: Case, folder: Path, held: Collection[str]) -> list[Value]:
    """Overlap of contacts at the fastest speed, over the diameter; of a spring that is held the one that it allows."""
    rests = count_work(case, folder).contacts >= SPOUTED
    known = list_overlaps(rests)
    if any(key in held for key in _SPRING_KEYS):
        region = find_region(case, folder)
        overlap = find_largest_overlap(case, list_speeds(case, region, None, folder))[0]
        return [Value(f"overlap {overlap:.2g} d", {}, interpolate("contact.max_overlap", known, overlap))]
    return [Value(f"overlap {value:g} d", {_SPRING_KEYS[0]: value}, error) for value, error in known.items()]


def list_cells(case: Case, folder: Path, held: Collection[str]) -> list[Value]:
    """The case's own mesh, and of a plain box coarser ones, by what they differ from it; what its own differs from a
    finer one is not known."""
    own, diameter = _size_cells(case, case.domain.cells), _find_diameter(case)
    values = [Value(f"cells {own / diameter:.2g} d, own", {}, 0.0)]
    assert case.gas is not None
    if _MESH_KEY in held or not case.domain.is_plain_box or case.gas.closed_nozzle or case.gas.closed_nozzle_size:
        return values
    measured = list_meshes()
    for part in COARSER:
        cells = [max(1, int(part * count + 0.5)) for count in case.domain.cells]
        size = round(_size_cells(case, cells) / diameter, 2)
        if max(own / diameter, min(measured)) < size <= max(measured):
            values.append(Value(f"cells {size:.2g} d", {_MESH_KEY: cells}, interpolate(_MESH_KEY, measured, size)))
    return values


def _size_cells(case: Case, cells: Collection[int]) -> float:
    """Edge of a cube of a cell's volume [m], by the grid of the case."""
    return float(math.prod(case.domain.size) / math.prod(cells)) ** (1.0 / 3.0)


def _find_diameter(case: Case) -> float:
    assert case.particles is not None
    return largest_diameter(case.particles)


_WHOLE = Value("particles", {}, 0.0)


def list_parcels(case: Case, folder: Path, held: Collection[str]) -> list[Value]:
    """The particles themselves, and parcels of them as large as fit between the walls; of a case in parcels, and of one
    that starts from what another run has, its own."""
    assert case.particles is not None
    own, known = find_ratio(case.particles), list_ratios()
    if own == 1.0 and case.start and (case.start.run is not None or case.start.restart is not None):
        return [_WHOLE]
    if own > 1.0 or any(key in held for key in _PARCEL_KEYS):
        return [Value(f"parcels of {own:.3g} d", {}, interpolate(_PARCEL_KEYS[0], known, own))]
    largest = find_width(case.domain) / FEWEST_ACROSS / _find_diameter(case)
    parcels = [
        Value(f"parcels of {ratio:g} d", {_PARCEL_KEYS[0]: ratio}, error)
        for ratio, error in known.items()
        if 1.0 < ratio <= largest
    ]
    return [_WHOLE, *parcels]


KNOBS: dict[str, Callable[[Case, Path, Collection[str]], list[Value]]] = {
    NUMERICS: list_steps,
    OVERLAP: list_springs,
    MESH: list_cells,
    PARCELS: list_parcels,
}
"""Knob -> its values for a case whose own files lie in a folder, in the order in which they are told; of options that
are held it has the case's own alone."""


def list_numerics(case: Case, folder: Path, held: Collection[str] = ()) -> Iterator[Numerics]:
    """Every combination of the knobs' values for `case`, whose own files lie in `folder`.

    held: options that are given for this plan, which stay: their knobs have the case's own value alone.

    Raises: CaseError if such a value lies where nothing was measured.
    """
    lists = [list_values(case, folder, held) for list_values in KNOBS.values()]
    for values in itertools.product(*lists):
        settings: Settings = {}
        for value in values:
            settings |= value.settings
        words = {knob: value.words for knob, value in zip(KNOBS, values, strict=True)}
        yield Numerics(words, math.hypot(*(value.error for value in values)), settings)
