"""What filter, diffusion and voidage methods do to a constant, to a total next to walls, and how wide they spread.

No solver runs here: the exchange alone, on one rank.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.schema.sections import Case
from fbcouple.coupling.box.diffusion import Diffusion
from fbcouple.coupling.box.filter import filtered
from fbcouple.coupling.box.halo import LocalGrid
from fbcouple.coupling.box.mapping import VOIDAGE_METHODS
from fbcouple.coupling.coupling import Coupling, Particles
from fbcouple.coupling.discretisation import BoxSpace
from fbcouple.geometry.grid import Grid
from fbcouple.verify.harness import GAS, GLASS
from fbcouple.verify.registry import Number, check

_GRID = Grid((41, 37, 45), (0.0615, 0.074, 0.09))
"""Cells of 1.5, 2 and 2 mm, an odd number of them: one is in the middle."""
_DIAMETER = GLASS["diameter"]
_PASSES = 3
_WIDTH = 4.0
"""Of kernel and diffusion, in diameters; the box is eight times as wide at least on either side."""

Smooth = Callable[[np.ndarray], np.ndarray]


def _patch_field(values: float) -> np.ndarray:
    return np.full_like(LocalGrid(_GRID, (0, 0, 0), _GRID.cells).make_field(1), values)


def _inside(field: np.ndarray) -> np.ndarray:
    return field[:-1, :-1, :-1, 0].transpose(2, 1, 0)


def _spread(amount: np.ndarray, axis: int) -> float:
    """Variance [m2] along `axis` of what is in the cells (x, y, z), each at its centre."""
    profile, x = amount.sum(axis=tuple({0, 1, 2} - {axis})), _GRID.centres(axis)
    mean = profile @ x / profile.sum()
    return float(profile @ (x - mean) ** 2 / profile.sum())


def _check(smooth: Smooth, expected: np.ndarray, tolerance: float) -> Iterator[Number]:
    """A constant, a total in cells of walls and corners, and the variances `expected` (3,) [m2] from the middle."""
    constant = _inside(smooth(_patch_field(0.4)))
    yield Number("constant, farthest off", float(np.abs(constant - 0.4).max()), 0.0, 1e-12)
    field = _patch_field(0.0)
    for x, y, z in ((0, 0, 0), (-1, 5, -1), (7, -1, 0), (3, 3, -1)):
        _inside(field)[x, y, z] += 1.0
    yield Number("total next to walls", float(_inside(smooth(field)).sum()), 4.0, 4e-12)
    field = _patch_field(0.0)
    _inside(field)[tuple(n // 2 for n in _GRID.cells)] = 1.0
    found = _inside(smooth(field))
    for axis, name in enumerate("xyz"):
        yield Number(
            f"variance along {name}", _spread(found, axis), float(expected[axis]), tolerance, "m2", relative=True
        )


@check("filter")
def conservative_filter(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Eqs 33 and 34: half a cell squared of variance a pass along each axis, all to 1e-12."""
    scratch = _patch_field(0.0)
    yield from _check(lambda field: filtered(field, _PASSES, scratch), 0.5 * _PASSES * _GRID.spacing**2, 1e-12)


@check("diffusion")
def diffusion(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A bandwidth of b: variance b^2/2 along each axis; 1e-9 of it lies beyond the walls of the box."""
    bandwidth = _WIDTH * _DIAMETER
    smoother = Diffusion(LocalGrid(_GRID, (0, 0, 0), _GRID.cells), bandwidth)

    def smooth(field: np.ndarray) -> np.ndarray:
        smoother.smooth(field)
        return field

    yield from _check(smooth, np.full(3, bandwidth**2 / 2), 1e-8)


_BANDWIDTHS: dict[str, dict[str, Any]] = {name: {"voidage": name} for name in VOIDAGE_METHODS}
_BANDWIDTHS["gaussian"]["kernel_width"] = _WIDTH
_BANDWIDTHS |= {"centre + diffusion": {"voidage": "centre", "diffusion_width": _WIDTH}}
_BANDWIDTHS |= {"trilinear + filter": {"filter_passes": _PASSES}}


def _expect(name: str, offset: np.ndarray) -> np.ndarray:
    """Variances (3,) [m2] about the mean of a particle `offset` (3,) [m] above the centre of its cell.

    Trilinear weights w and 1 - w are dx apart. A Gaussian over cells has the variance of a cell on top, and lacks
    4e-4 beyond 3 b. Diffusion and filter add theirs to that of the deposit.
    """
    spacing = _GRID.spacing
    share = offset / spacing
    return {
        "trilinear": share * (1.0 - share) * spacing**2,
        "centre": np.zeros(3),
        "gaussian": (1.0 - 4.2e-4) * (_WIDTH * _DIAMETER) ** 2 / 2 + spacing**2 / 12,
        "centre + diffusion": np.full(3, (_WIDTH * _DIAMETER) ** 2 / 2),
        "trilinear + filter": (share * (1.0 - share) + 0.5 * _PASSES) * spacing**2,
    }[name]


_WITHIN = {"gaussian": 1e-3, "centre + diffusion": 1e-8}
"""Relative tolerances of the variances where 1e-10 is not to be had."""


def _map(exchange: dict[str, Any], folder: np.ndarray) -> np.ndarray:
    """Solids volume in the cells (x, y, z) over that of the lone particle at `folder` (3,) [m]."""
    case = Case.model_validate(
        {
            "title": "verify",
            "end_time": 1.0,
            "domain": {"size": _GRID.size, "cells": _GRID.cells},
            "gas": GAS,
            "particles": GLASS | {"count": 1},
            "exchange": exchange,
        }
    )
    triples = np.stack(np.meshgrid(*map(np.arange, _GRID.cells), indexing="ij"), axis=-1).reshape(-1, 3)
    centres, bounds = (triples + 0.5) * _GRID.spacing, np.array([[0.0] * 3, _GRID.size])
    coupling = Coupling(case, BoxSpace(case, MPI.COMM_SELF, centres, bounds, _DIAMETER))
    radius = np.array([_DIAMETER / 2])
    volume = np.pi / 6 * _DIAMETER**3
    coupling.map(Particles(folder[None], np.zeros((1, 3)), radius, GLASS["density"] * np.array([volume])))
    return ((1.0 - coupling.voidage) * _GRID.cell_volume / volume).reshape(_GRID.cells)


@check("voidage-width")
def voidage_width(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A lone particle by each voidage method: whole in a corner, where its mean is, and its variance."""
    offset = np.array([0.5, 0.8, 0.9]) * 1e-3
    middle = (np.array(_GRID.cells) // 2 + 0.5) * _GRID.spacing
    for name, exchange in _BANDWIDTHS.items():
        corner = _map(exchange, np.full(3, 0.45 * _DIAMETER))
        yield Number(f"{name}: total in a corner", float(corner.sum()), 1.0, 1e-12)
        amount = _map(exchange, middle + offset)
        if name == "divided":
            yield from _judge_divided(amount, middle + offset)
            continue
        for axis, expected in enumerate(_expect(name, offset).tolist()):
            label, found = f"{name}: variance along {'xyz'[axis]}", _spread(amount, axis)
            tolerance = _WITHIN.get(name, 1e-10) * expected if expected else 1e-10 * _DIAMETER**2
            yield Number(label, found, expected, tolerance, "m2")


def _judge_divided(amount: np.ndarray, folder: np.ndarray) -> Iterator[Number]:
    """Along each axis the part of the sphere beyond the face above it: h^2 (3 - h)/4 for a cap of h radii, 4.6 %."""
    for axis in range(3):
        face = np.round(folder[axis] / _GRID.spacing[axis]).astype(int)
        height = 1.0 - (face * _GRID.spacing[axis] - folder[axis]) / (_DIAMETER / 2)
        beyond = float(np.moveaxis(amount, axis, 0)[face:].sum())
        cap = height**2 * (3.0 - height) / 4.0
        yield Number(f"divided: beyond the face along {'xyz'[axis]}", beyond, float(cap), 0.046)
