"""Replicas of a bed, from two seeds of `particles.positions_seed`: the same bed, in another motion."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.positions import LARGEST_SHIFT, start_kinds, start_positions
from fbcouple.case.schema.sections import Case
from fbcouple.decks.alone import Outcome, Particles, Rest, settle
from fbcouple.verify.harness import GLASS
from fbcouple.verify.registry import Number, check

_DIAMETER = GLASS["diameter"]
_COLUMN = (10, 8, 24)
"""Particles of the column along x, y and z; it stands at one end of a box that is three times as wide."""
_SPACING = 1.05
_STEPS = 12000


@check("positions-seed")
def positions_seed(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A column of 1920 spheres collapses and comes to rest, from two seeds. At the start they are the random shift
    apart; at the end the beds have one shape, and each sphere is elsewhere."""
    _write_column(folder)
    cases = [_make_case(seed) for seed in (1, 2)]
    starts = [start_positions(case, folder) for case in cases]
    apart = _find_distance(*starts)
    yield Number("distance of the same sphere at the start", apart, np.sqrt(2.0) * LARGEST_SHIFT, 0.05, "d", True)
    first, second = (_collapse(case, folder, start) for case, start in zip(cases, starts, strict=True))
    yield Number("distance of the same sphere at the end", _find_distance(first, second), 2.5, 2.0, "d")
    for axis, name, tolerance in ((2, "height", 0.02), (0, "length", 0.02)):
        sizes = [float(bed[:, axis].mean()) for bed in (first, second)]
        yield Number(f"{name} of the centre of mass, one over the other", sizes[1] / sizes[0], 1.0, tolerance)


def _write_column(folder: Path) -> None:
    sites = np.stack(np.meshgrid(*map(np.arange, _COLUMN), indexing="ij"), axis=-1).reshape(-1, 3)
    rows = ((sites + 0.5) * _SPACING * _DIAMETER).tolist()
    text = "x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in rows)
    (folder / "column.csv").write_text(text, encoding="utf-8")


def _make_case(seed: int) -> Case:
    width, depth, height = (count * _SPACING * _DIAMETER for count in _COLUMN)
    contact: dict[str, Any] = {"stiffness": 500.0, "restitution": 0.9, "wall_restitution": 0.9}
    contact |= {"friction": 0.3, "wall_friction": 0.3, "tangential": "history"}
    beads = {"count": int(np.prod(_COLUMN)), "positions": "column.csv", "positions_seed": seed, "rotation": True}
    return Case.model_validate(
        {
            "title": "verify",
            "end_time": 1.0,
            "domain": {"size": [3.0 * width, depth, 1.5 * height], "cells": [15, 4, 18]},
            "particles": GLASS | beads,
            "contact": contact,
        }
    )


def _collapse(case: Case, folder: Path, start: np.ndarray) -> np.ndarray:
    """Where the spheres are after `_STEPS` DEM steps, (n, 3) [m]."""
    held = Particles(start, np.zeros((len(start), 6)), start_kinds(case, folder))
    found: Outcome = settle(case, folder, held, Rest(math.inf, _STEPS, _STEPS))
    return found.particles.positions


def _find_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Root mean square of the distances of the same spheres [d]."""
    return float(np.sqrt(((one - other) ** 2).sum(axis=1).mean())) / _DIAMETER
