"""At which heights profiles are taken, and up to which maps are drawn: from the bed, unless a user says otherwise."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.results.depth_means import depth_average
from fbcouple.results.reader import NotDrawableError, Results

SCARCE = 0.01
"""Solids fraction below which there is no bed, only a few particles that pass."""
ROOM = 1.15
"""Height of a map over that of the bed."""
NEARLY_ALL = 0.9
"""Part of the box from which on a map shows all of it."""


def list_heights(results: Results) -> tuple[float, ...]:
    """Heights of profiles [m above the floor]: those asked for, else the case's, else that of the centre of mass.

    Raises: CaseError if the case in results.nc has heights that are none; NotDrawableError without solids.
    """
    asked = results.view.heights or read_heights(results, "profile_heights")
    return asked or (find_centre(results),)


def read_heights(results: Results, option: str) -> tuple[float, ...]:
    """An option of `output` of the run's case that is heights; results.nc may come from anybody."""
    output = results.case.get("output", {})
    given = output.get(option, []) if isinstance(output, dict) else None
    if not isinstance(given, list) or not all(isinstance(z, int | float) and 0 < z < math.inf for z in given):
        text = f"output.{option} of its case is no list of heights in m"
        raise CaseError([f"{results.path}: {text}; set the run up again."])
    return tuple(float(height) for height in given)


def find_centre(results: Results) -> float:
    """Height [m above the floor] of the centre of mass of the time-mean solids."""
    weight = depth_average(results.mean("solids_fraction")).sum("x").values
    if not weight.sum() > 0.0:
        raise NotDrawableError([f"{results.path} has no solids to take the height of a profile from."])
    share = float(weight @ results.share("z") / weight.sum())
    return share * results.size[2]


def format_height(height: float, results: Results) -> str:
    """A height in a note: "z = 23 mm ($z/H$ = 0.092)"."""
    return f"$z$ = {1e3 * height:.3g} mm ($z/H$ = {height / results.size[2]:.3g})"


def find_tops(runs: Sequence[Results]) -> list[float]:
    """z/H up to which the map of each run is drawn: the same height [m] for all, a little above the highest bed."""
    highest = max(_find_top(run) * run.size[2] for run in runs)
    return [min(highest / run.size[2], 1.0) for run in runs]


def _find_top(results: Results) -> float:
    """z/H of the upper edge of the cells a little above the bed; 1 where there is no bed, or all is asked for."""
    if results.view.full_height or "solids_fraction" not in results.data:
        return 1.0
    try:
        rows = depth_average(results.mean("solids_fraction")).max("x").values
    except NotDrawableError:
        return 1.0
    bed = np.flatnonzero(rows > SCARCE)
    if not bed.size:
        return 1.0
    layers = len(rows)
    top = math.ceil(ROOM * (int(bed[-1]) + 1)) / layers
    return top if top < NEARLY_ALL else 1.0
