"""A bed that is held: layers of one lattice with fewer and fewer spheres, each of a uniform voidage, that never move.

A cell is three face-centred cubes side by side with 12 sites; a layer takes 12, 10, 8, 6, 4 or 2 of them, in pairs
that weigh the same on both of the cell's neighbours. The bed repeats itself along x and y, and the lattice lies across
its cells and over its sides, so that every cell of a layer holds the same solids only if weights and sides are right;
nothing overlaps, down to voidage 0.4.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import GAS, GLASS, blow, open_bench

VOIDAGES = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
LAYER = 8
"""Cells of each layer: in the middle ones the gas knows nothing of the layers above and below."""
_MIDDLE = LAYER // 2
_PAIRS = 6
_CUBE = (4 * np.pi / 6 / (1 - VOIDAGES[0])) ** (1 / 3) * GLASS["diameter"]
SIZE = np.array([3 * _CUBE, _CUBE, _CUBE])
"""Edges of a cell [m]."""


def lattice_sites() -> np.ndarray:
    """Centres [m], shape (particles, 3), the layers one above the other."""
    low = np.array([[0.25, 0.25, 0.25], [0.75, 0.75, 0.25]])
    high = np.array([[0.75, 0.25, 0.75], [0.25, 0.75, 0.75]])
    pairs = [[low[i] + [cube, 0, 0], high[i] + [cube, 0, 0]] for i in (0, 1) for cube in (0, 1, 2)]
    cells = [
        np.concatenate(pairs[: _PAIRS - layer]) + np.array([0, 0, layer * LAYER + cell])
        for layer in range(len(VOIDAGES))
        for cell in range(LAYER)
    ]
    column = np.concatenate(cells) * _CUBE
    columns = [column + np.array([x, y, 0]) * SIZE for x in range(_COLUMNS) for y in range(_COLUMNS)]
    period = SIZE * [_COLUMNS, _COLUMNS, LAYER * len(VOIDAGES)]
    return (np.concatenate(columns) + _SHIFT * SIZE) % period


_COLUMNS = 2
"""Cells along x and y."""
_SHIFT = np.array([0.29, 0.87, 0.0])
"""How far the lattice is moved off the cells, in cells: no site lies on a border of two."""


def _choose_kinds() -> np.ndarray:
    """Kind, 0 or 1, of each site of `lattice_sites`: pair by pair within a cell, in turn."""
    pairs = [np.repeat(np.arange(_PAIRS - layer) % 2, 2) for layer in range(len(VOIDAGES)) for _ in range(LAYER)]
    return np.tile(np.concatenate(pairs), _COLUMNS**2)


def _count_sites() -> np.ndarray:
    """Sites in a cell of each layer whose pair is even and odd, shape (layers, 2)."""
    pairs = _PAIRS - np.arange(len(VOIDAGES))
    return 2 * np.column_stack([(pairs + 1) // 2, pairs // 2])


class HeldBed:
    """The layers in an upward flow of `inlet` [m/s], with their drag by `law`.

    `exchange`: other options of that section. `voidages` (layers,) is what the spheres leave free. With a `second`
    diameter [m] every other pair of spheres has it, and `parts` (layers, 2) are the parts of the cells that the two
    sizes fill. With a `ratio` the spheres are parcels of grains that are smaller by so much.
    """

    def __init__(
        self,
        folder: Path,
        comm: MPI.Comm,
        law: str,
        inlet: float,
        second: float | None = None,
        ratio: float | None = None,
        **exchange: Any,
    ) -> None:
        cells = [_COLUMNS, _COLUMNS, LAYER * len(VOIDAGES)]
        sections: dict[str, Any] = {
            "domain": {"size": [float(edge) for edge in SIZE * cells], "cells": cells, "periodic": ["x", "y"]},
            "gas": GAS | {"inlet_velocity": inlet, "pressure_tolerance": 1e-12},
            "exchange": {"drag": law} | exchange,
        }
        edits = {"DEM/in.liggghts": lambda text: text.replace("fix             motion", "# fix             motion")}
        kinds = _choose_kinds() if second else None
        if kinds is not None:
            share = float(np.mean(kinds))
            sections["particles"] = {"fractions": "number", "mixture": [[second, GLASS["density"], share]]}
        if ratio:
            sections["particles"] = {"diameter": GLASS["diameter"] / ratio, "coarse_graining": ratio}
        volumes = np.pi / 6 * np.array([GLASS["diameter"], second or GLASS["diameter"]]) ** 3
        self.parts = _count_sites() * volumes / np.prod(SIZE)
        self.voidages = 1.0 - self.parts.sum(axis=1)
        self.sim: Simulation = open_bench(folder, comm, sections, lattice_sites(), edits, kinds)
        self.inlet = inlet
        self.sim.initialise()
        assert self.sim.liggghts is not None
        height = self.sim.liggghts.positions[:, 2] / SIZE[2]
        self._layer = (height // LAYER).astype(int)
        self._inner = np.abs(height - self._layer * LAYER - _MIDDLE) < 1

    def flow(self, superficial: np.ndarray, steps: int = 3) -> None:
        """Let the gas pass each layer with this superficial slip [m/s], shape (layers,), for some coupled steps.

        The gas comes up with the inlet's velocity; what is wanted beyond that the layer's particles make up by a
        velocity of their own, without moving: the slip counts, not the frame.
        """
        assert self.sim.liggghts is not None
        self.sim.liggghts.velocities[:, 2] = ((self.inlet - superficial) / self.voidages)[self._layer]
        for _ in range(steps):
            blow(self.sim)

    @property
    def pressure_losses(self) -> np.ndarray:
        """Pressure per length [Pa/m] in the middle of each layer, shape (layers,)."""
        assert self.sim.gas is not None
        p = _average_heights(self.sim.gas.centres, self.sim.gas.pressure)
        return (p[:, _MIDDLE - 1] - p[:, _MIDDLE]) / SIZE[2]

    @property
    def gas_forces(self) -> np.ndarray:
        """Upward force of the gas on a particle [N] in the middle of each layer, the lift of its volume included,
        shape (layers,)."""
        check = self.sim
        assert check.liggghts is not None
        force = check.liggghts.gas_force[:, 2]
        return np.array([force[self._inner & (self._layer == n)].mean() for n in range(len(VOIDAGES))])

    @property
    def found_voidages(self) -> np.ndarray:
        """Voidage of the cells in the middle of each layer, shape (layers, columns)."""
        assert self.sim.gas is not None and self.sim.coupling is not None
        return _sort_heights(self.sim.gas.centres, self.sim.coupling.voidage)[:, _MIDDLE]


def _sort_heights(centres: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Cell values as (layers, heights in a layer, columns)."""
    return values[np.argsort(centres[:, 2], kind="stable")].reshape(len(VOIDAGES), LAYER, -1)


def _average_heights(centres: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Cell values averaged over the columns, as (layers, heights in a layer)."""
    return _sort_heights(centres, values).mean(axis=2)
