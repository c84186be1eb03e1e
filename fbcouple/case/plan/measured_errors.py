"""What numerics and mesh did to the mean map of solids flux in beds that were run: each number once, with its source.

Beds are compared as the gas lifts them, from their start to 0.12 s, before chance plays a part: after that two runs of
one case differ by more than numerics do. Parcels are told by means over 5 s, as it is the bubbles that they change.
`tests/case/test_measured_errors.py` holds every number against its study.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from fbcouple.errors import CaseError

FACTOR = 3.5
"""Factor that the two beds lie apart at preset `standard`; the larger is taken, and a third may lie as far from it."""
_ROOM = 1e-9


@dataclass(frozen=True)
class Measured:
    """An error, root mean square, of a member of a study against its finest one, over the scale of the `measure`.

    knob, value: whose, as a plan has them.
    """

    knob: str
    value: str
    bed: str
    study: str
    member: str
    measure: str
    error: float

    @property
    def over_map(self) -> float:
        """The error over the root mean square of the map, as standard errors of means are told."""
        return self.error * (RANGES[self.bed] if self.measure == _RANGE else 1.0)


_MAP, _RANGE, _SOLIDS = "maps:solids_flux", "means:solids_flux", "means:solids_fraction"
_CENTRE = "finest:solids_centre_z"
RANGES = {"patil/c2": 4.4, "mueller/0.9": 5.96}
"""Range of the map of solids flux of a bed over its root mean square, where errors were told over the range."""
NUMERICS, OVERLAP, PACKING = "preset and fluid step", "overlap", "overlap at rest"
MESH, PARCELS = "cells over d", "parcels"

MEASURED: tuple[Measured, ...] = (
    *(
        Measured(NUMERICS, value, "patil/c2", "fluid-step", member, _RANGE, error)
        for value, member, error in (
            ("draft", "`draft` (2.0, 2.0)", 0.004),
            ("standard", "**`standard`** (1.5, 1.5)", 0.003),
            ("standard, Courant 1", "1.0, 1.0", 0.002),
            ("standard, Courant 0.5", "0.5, 0.15", 0.002),
            ("reference", "`reference` (Courant 0.2, Fourier number 0.15)", 0.001),
        )
    ),
    *(
        Measured(NUMERICS, value, "mueller/0.9", "presets-lifted", member, _MAP, error)
        for value, member, error in (
            ("draft", "accuracy-draft", 0.0545),
            ("standard", "base", 0.0456),
            ("standard, Courant 1", "max_courant-1", 0.0361),
            ("standard, Courant 0.5", "max_courant-0.5", 0.0274),
            ("reference", "accuracy-reference", 0.0225),
        )
    ),
    *(
        Measured(OVERLAP, value, "patil/c2", "overlap-lifted", member, _SOLIDS, error)
        for value, member, error in (
            ("0.02", "max_overlap-0.02", 0.0041),
            ("0.03", "max_overlap-0.03", 0.0043),
            ("0.05", "base", 0.0043),
            ("0.07", "max_overlap-0.07", 0.0045),
            ("0.1", "max_overlap-0.1", 0.0047),
        )
    ),
    *(
        Measured(OVERLAP, value, "mueller/0.9", "presets-lifted", member, _MAP, error)
        for value, member, error in (
            ("0.02", "max_overlap-0.02", 0.0470),
            ("0.03", "max_overlap-0.03", 0.0468),
            ("0.05", "base", 0.0456),
            ("0.07", "max_overlap-0.07", 0.0450),
            ("0.1", "max_overlap-0.1", 0.0443),
        )
    ),
    *(
        Measured(PACKING, value, "overlap-rest", "overlap-rest", f"max_overlap-{value}", _CENTRE, error)
        for value, error in (("0.02", 0.0020), ("0.03", 0.0076), ("0.05", 0.0231), ("0.07", 0.0294), ("0.1", 0.0337))
    ),
    *(
        Measured(MESH, value, "mueller/0.9", "presets-lifted", member, _MAP, error)
        for value, member, error in (("2.21", "cells-16x4x44", 0.3793), ("3.14", "cells-11x3x30", 0.3772))
    ),
    *(
        Measured(PARCELS, value, "mueller/0.9", "coarse-graining", f"coarse_graining-{value}", _RANGE, error)
        for value, error in (("1.26", 0.0717), ("1.5", 0.0663))
    ),
)
"""`fluid-step` is a table of docs/results/studies/README.md; of `overlap-rest` the error is the shift of the centre of
mass over its height. The flux of patil/c2 was not measured by overlap: its solids fraction stands for it. What is
of the mesh was measured before walls counted: without half a cell of the coarser mesh at each of them."""
USUAL_OVERLAP = 0.05
FINEST_MESH = 1.67
"""Cells over the diameter of the mesh that those of `MESH` are compared with: the case's own."""


def list_errors(knob: str, bed: str = "") -> dict[str, float]:
    """Value of a knob -> its error over the map, that of `bed` or the largest of the beds."""
    errors: dict[str, float] = {}
    for row in MEASURED:
        if row.knob == knob and bed in ("", row.bed):
            errors[row.value] = max(errors.get(row.value, 0.0), row.over_map)
    return errors


def list_overlaps(rests: bool) -> dict[float, float]:
    """Overlap over the diameter -> what it adds, in squares, to the error of a fluid step, the largest of the beds: as
    much as it raises what `standard` errs, which was measured at `USUAL_OVERLAP`. In a bed of which a part `rests` not
    less than it shifts the packing."""
    added: dict[float, float] = {}
    for bed in {row.bed for row in MEASURED if row.knob == OVERLAP}:
        found = {float(value): error for value, error in list_errors(OVERLAP, bed).items()}
        whole = list_errors(NUMERICS, bed)["standard"]
        for overlap, error in found.items():
            ratio = max(1.0, error / found[USUAL_OVERLAP]) if overlap > USUAL_OVERLAP else 1.0
            added[overlap] = max(added.get(overlap, 0.0), whole * math.sqrt(ratio**2 - 1.0))
    packing = {float(value): error for value, error in list_errors(PACKING).items()} if rests else {}
    return {overlap: max(error, packing.get(overlap, 0.0)) for overlap, error in sorted(added.items())}


def list_meshes() -> dict[float, float]:
    """Cells over the diameter -> distance from a mesh of `FINEST_MESH`; a coarser one is not nearer than a finer."""
    return {FINEST_MESH: 0.0} | _never_nearer(MESH)


def list_ratios() -> dict[float, float]:
    """Diameter of parcels over that of their particles -> distance from these; larger ones are not nearer. Ratios from
    2 on have none: the bed that was measured no longer bubbled."""
    return {1.0: 0.0} | _never_nearer(PARCELS)


def _never_nearer(knob: str) -> dict[float, float]:
    sizes, worst = {}, 0.0
    for value, error in list_errors(knob).items():
        worst = max(worst, error)
        sizes[float(value)] = worst
    return sizes


def interpolate(key: str, known: Mapping[float, float], value: float) -> float:
    """The error of `value` between those of the next measured ones, in the logarithm of the value.

    Raises: CaseError naming `key` where `value` lies outside of them.
    """
    values = sorted(known)
    low, high = values[0], values[-1]
    if not low * (1.0 - _ROOM) <= value <= high * (1.0 + _ROOM):
        text = f"{value:.3g} is given, and errors were measured from {low:g} to {high:g}"
        raise CaseError([f"{key}: {text}; give one of these, or leave it to the plan."])
    above = next((n for n, one in enumerate(values) if one >= value), len(values) - 1)
    if above == 0:
        return known[values[0]]
    one, two = values[above - 1], values[above]
    part = (math.log(value) - math.log(one)) / (math.log(two) - math.log(one))
    return known[one] + min(part, 1.0) * (known[two] - known[one])
