"""A box without side walls knows no place along them: what is moved along comes out moved, and otherwise the same."""

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.case.schema.sections import Case
from fbcouple.coupling.box.halo import HaloExchange, find_local_grid
from fbcouple.coupling.coupling import Coupling, Particles
from fbcouple.coupling.discretisation import BoxSpace
from fbcouple.errors import DivergedError
from fbcouple.geometry.grid import Grid
from fbcouple.simulation.tasks.samplers import SolidsSampler

EDGES = np.array([0.002, 0.003, 0.0025])
CELLS = [(6, 3, 7), (2, 1, 5), (1, 1, 4)]
DT = 3e-4


def couple(cells, places, velocities, radii, gas, exchange, periodic=("x", "y")):
    """Voidage, K and S (x, y, z, 5) and forces (n, 3) of one coupling step in this process; gas (x, y, z, 6)."""
    size = tuple((cells * EDGES).tolist())
    case = Case.model_validate(
        {
            "title": "a bed",
            "end_time": 1.0,
            "domain": {"size": size, "cells": cells, "periodic": periodic},
            "gas": {"density": 1.165, "viscosity": 2e-5, "inlet_velocity": 1.0},
            "particles": {"diameter": 4e-4, "density": 2500.0, "count": len(radii)},
            "exchange": exchange,
        }
    )
    centres = (np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(-1, 3) + 0.5) * EDGES
    particles = Particles(places, velocities, radii, 2500.0 * 4 / 3 * np.pi * radii**3)
    rows = np.ascontiguousarray(gas.reshape(-1, 6))
    coupling = Coupling(case, BoxSpace(case, MPI.COMM_SELF, centres, np.array([[0.0] * 3, size]), reach=1e-3))
    coupling.map(particles)
    coupling.read_gas(rows)
    coupling.deposit_drag(particles, DT)
    held, current = np.zeros((2, len(radii), 3))
    coupling.apply_gas_force(particles, rows, held, current)
    voidage, drag = coupling.gas_input
    return np.column_stack([voidage, drag / EDGES.prod()]).reshape(*cells, 5), held


def draw(rng, cells, count=80):
    """Places (n, 3) in the box, velocities, radii and a gas."""
    places = rng.uniform(0.0, 1.0, (count, 3)) * (np.array(cells) * EDGES)
    gas = rng.standard_normal((*cells, 6)) * [1.0, 1.0, 1.0, 1e3, 1e3, 1e3]
    return places, rng.standard_normal((count, 3)), rng.uniform(1e-4, 2e-4, count), gas


WAYS = {
    "trilinear": {},
    "filtered": {"filter_passes": 3},
    "centre": {"voidage": "centre"},
    "divided": {"voidage": "divided"},
    "gaussian": {"voidage": "gaussian", "kernel_width": 3.0},
    "diffusion": {"diffusion_width": 3.0},
}
every_way = pytest.mark.parametrize("exchange", WAYS.values(), ids=WAYS)


@pytest.mark.parametrize("cells", CELLS)
@every_way
def test_bed_and_gas_moved_by_cells_give_the_same_moved(rng, cells, exchange):
    places, velocities, radii, gas = draw(rng, cells)
    fields, forces = couple(cells, places, velocities, radii, gas, exchange)
    moved = (places + np.array([2.0, 1.0, 0.0]) * EDGES) % (np.array(cells) * EDGES)
    again, same = couple(cells, moved, velocities, radii, np.roll(gas, (2, 1), (0, 1)), exchange)
    assert again == pytest.approx(np.roll(fields, (2, 1), (0, 1)), rel=1e-9, abs=1e-9)
    assert same == pytest.approx(forces, rel=1e-9, abs=1e-12)


@every_way
def test_a_particle_that_is_not_yet_back_counts_as_if_it_were(rng, exchange):
    cells = (6, 3, 7)
    places, velocities, radii, gas = draw(rng, cells)
    size = np.array(cells) * EDGES
    out = places + np.where(places < 9e-4, size, 0.0) * [1.0, 1.0, 0.0]
    out -= np.where(places > size - 9e-4, size, 0.0) * [1.0, 1.0, 0.0]
    assert (out != places).any(axis=1).sum() > 20
    for one, other in zip(*(couple(cells, p, velocities, radii, gas, exchange) for p in (places, out)), strict=True):
        assert other == pytest.approx(one, rel=1e-9, abs=1e-9)


def test_walls_make_a_difference_beside_them_only(rng):
    cells = (8, 7, 5)
    bed = draw(rng, cells, 400)
    free, walled = (couple(cells, *bed, {}, periodic=axes)[0] for axes in (("x", "y"), ()))
    off = np.abs(free - walled).max(axis=(2, 3))
    assert off[2:-2, 2:-2].max() < 1e-12 and off[0].min() > 1e-3 and off[:, -1].min() > 1e-3


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_one_axis_alone_may_be_periodic(rng, axis):
    """A particle beside the low end of an axis shares its volume with the cells at the high end, or with none."""
    cells = (6, 3, 7)
    size = np.array(cells) * EDGES
    place = size / 2
    place[axis] = 0.1 * EDGES[axis]
    names = ("x",) if axis == 0 else ("y",)
    fields, _ = couple(cells, place[None], np.zeros((1, 3)), np.array([1e-4]), np.zeros((*cells, 6)), {}, names)
    solids = np.moveaxis(1.0 - fields[..., 0], axis, 0)
    far = solids[-1].sum() / solids.sum()
    assert far == pytest.approx(0.0 if axis == 2 else 0.4, abs=1e-9)


def test_the_averages_find_the_cell_of_a_particle_that_is_not_yet_back(rng):
    cells = (6, 3, 7)
    grid = Grid(cells, tuple((cells * EDGES).tolist()), (True, True, False))
    local = find_local_grid(grid, np.zeros(3), np.array(grid.size), 1e-3, 0)
    owned = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(-1, 3)
    sampler = SolidsSampler(HaloExchange(MPI.COMM_SELF, local, owned))
    place = np.array([[-1e-4, grid.size[1] + 1e-4, 0.006]])
    rows = sampler.sample(place, np.ones((1, 3)), np.array([1e-4]), np.ones(1))
    assert owned[np.flatnonzero(rows[:, 0])].tolist() == [[5, 0, 2]]
    with pytest.raises(DivergedError):
        sampler.sample(np.array([[0.0, 0.0, grid.size[2] + 0.01]]), np.ones((1, 3)), np.array([1e-4]), np.ones(1))
