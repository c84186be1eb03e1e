"""A sample of the cells: rows of densities, from the particles and from the gas."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fbcouple.case.bed.particle_types import largest_diameter
from fbcouple.coupling.box.halo import HaloExchange, LocalGrid, find_local_grid
from fbcouple.coupling.discretisation import BoxSpace, MeshSpace
from fbcouple.coupling.polyhedral.halo import CellHaloExchange
from fbcouple.coupling.polyhedral.mapping import CellMapping
from fbcouple.errors import DivergedError
from fbcouple.physics.compiler import njit
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.means import SOLIDS_COLUMNS


class SolidsSampler:
    """Puts this rank's particles into cells and sums the cells over the ranks."""

    def __init__(self, halo: HaloExchange, volumes: np.ndarray | None = None) -> None:
        """`volumes` (cells,) [m3] of this rank's cells; None: those of the grid."""
        self._halo = halo
        self._volumes = halo.local.grid.cell_volume if volumes is None else volumes[:, None]
        self._field = halo.local.make_field(SOLIDS_COLUMNS - 1)
        self._rows = np.empty((halo.owned_count, SOLIDS_COLUMNS - 1))

    def sample(
        self, positions: np.ndarray, velocities: np.ndarray, radii: np.ndarray, masses: np.ndarray
    ) -> np.ndarray:
        """Rows (cells, SOLIDS_COLUMNS) of this rank's cells (collective)."""
        local: LocalGrid = self._halo.local
        self._field.fill(0.0)
        box = 1.0 / local.grid.spacing, np.array(local.low), np.array(local.high), local.walls
        coordinates = local.grid.measure_from_corner(positions)
        stray = _bin(coordinates, velocities, radii, masses, *box, self._field)
        if stray >= 0:
            raise DivergedError(f"a particle at {positions[stray]} m is outside the cells {local.low} to {local.high}")
        self._halo.reverse(self._field, self._rows)
        return _row_up(self._rows) / self._volumes


class CellSampler:
    """Puts this rank's particles into the cells of a mesh of polyhedra and sums the cells over the ranks."""

    def __init__(self, mapping: CellMapping, halo: CellHaloExchange, volumes: np.ndarray) -> None:
        """`mapping` finds the cells of particles; `volumes` (cells,) [m3] of this rank's cells."""
        self._mapping, self._halo, self._volumes = mapping, halo, volumes[:, None]
        self._field = halo.local.make_field(SOLIDS_COLUMNS - 1)
        self._rows = np.empty((halo.owned_count, SOLIDS_COLUMNS - 1))

    def sample(
        self, positions: np.ndarray, velocities: np.ndarray, radii: np.ndarray, masses: np.ndarray
    ) -> np.ndarray:
        """Rows (cells, SOLIDS_COLUMNS) of this rank's cells (collective)."""
        self._mapping.locate(positions, radii)
        self._field.fill(0.0)
        _add_up(self._mapping.cells, velocities, radii, masses, self._field)
        self._halo.reverse(self._field, self._rows)
        return _row_up(self._rows) / self._volumes


SAMPLERS: dict[type, Callable[[Any], SolidsSampler | CellSampler]] = {
    BoxSpace: lambda space: SolidsSampler(space.halo, space.volumes),
    MeshSpace: lambda space: CellSampler(space.mapping, space.halo, space.volumes),
}
"""Who samples the particles in the cells of each discretisation."""


def open_sampler(sim: Simulation) -> SolidsSampler | CellSampler:
    """The sampler of the cells that `sim` has (collective)."""
    assert sim.case.particles is not None
    if not sim.is_coupled:
        reach = largest_diameter(sim.case.particles)
        low, high = sim.liggghts.bounds
        return SolidsSampler(HaloExchange(sim.comm, find_local_grid(sim.grid, low, high, reach, 0), sim.owned))
    return SAMPLERS[type(sim.coupling.space)](sim.coupling.space)


def sample_solids(sampler: SolidsSampler | CellSampler, sim: Simulation) -> np.ndarray:
    """Rows (cells, SOLIDS_COLUMNS) of this rank's cells from the particles as they are now (collective)."""
    p, inside, masses = sim.particles, sim.rows_inside, sim.liggghts.own_masses
    return sampler.sample(*(column[inside] for column in (p.positions, p.velocities, p.radii, masses)))


def _row_up(rows: np.ndarray) -> np.ndarray:
    """The sums of each cell (cells, SOLIDS_COLUMNS - 1), and beside them that of m |v - cell mean|^2."""
    mass, momentum, energy = rows[:, 1:2], rows[:, 2:5], rows[:, 5:6]
    with np.errstate(invalid="ignore", divide="ignore"):
        bulk = np.where(mass > 0, np.sum(momentum**2, axis=1, keepdims=True) / mass, 0.0)
    return np.hstack([rows, energy - bulk])


def sample_heat(sampler: SolidsSampler | CellSampler, sim: Simulation) -> np.ndarray:
    """Rows (cells, HEAT_COLUMNS) of this rank's cells from the temperatures of the particles (collective)."""
    assert sim.heat is not None
    p, inside, temperatures = sim.particles, sim.rows_inside, sim.liggghts.temperatures
    # A temperature goes in the place of a velocity: what the sampler adds up is m times it.
    columns = np.zeros((len(temperatures), 3))
    columns[:, 0] = temperatures
    rows = sampler.sample(*(column[inside] for column in (p.positions, columns, p.radii, sim.heat.masses)))
    return rows[:, 1:3]


def sample_gas(voidage: np.ndarray, velocity: np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """Rows (cells, GAS_COLUMNS) from voidage (cells,), velocity (cells, 3) [m/s] and pressure (cells,) [Pa]."""
    return np.column_stack([voidage, velocity, voidage[:, None] * velocity, pressure])


@njit(cache=True)
def _bin(positions, velocities, radii, masses, scale, low, high, walls, field):
    for p in range(len(positions)):
        i = _find_cell(positions[p, 0] * scale[0], low[0], high[0], walls[0, 0], walls[1, 0])
        j = _find_cell(positions[p, 1] * scale[1], low[1], high[1], walls[0, 1], walls[1, 1])
        k = _find_cell(positions[p, 2] * scale[2], low[2], high[2], walls[0, 2], walls[1, 2])
        if i < 0 or j < 0 or k < 0:
            return p
        _add_particle(velocities[p], radii[p], masses[p], field[k, j, i])
    return -1


@njit(inline="always")
def _add_particle(velocity, radius, mass, row):
    square = 0.0
    row[0] += 4.0 / 3.0 * np.pi * radius**3
    row[1] += mass
    for axis in range(3):
        row[2 + axis] += mass * velocity[axis]
        square += velocity[axis] ** 2
    row[5] += mass * square


@njit(cache=True)
def _add_up(cells, velocities, radii, masses, field):
    for p in range(len(cells)):
        _add_particle(velocities[p], radii[p], masses[p], field[cells[p]])


@njit(inline="always")
def _find_cell(coordinate, low, high, first, last):
    """Cell in the local grid, or -1 if it is not in it; a centre on a wall belongs to the cell inside."""
    if not (first - 1.0 < coordinate <= last + 1.0):
        return -1
    cell = min(max(int(np.floor(coordinate)), first), last)
    return cell - low if low <= cell < high else -1
