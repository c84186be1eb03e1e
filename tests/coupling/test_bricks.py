"""A mesh of equal hexahedra is known for the box that it is, and the coupling on it is the box's own."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.case.schema.sections import Case
from fbcouple.coupling.coupling import Coupling
from fbcouple.coupling.discretisation import BoxSpace
from fbcouple.coupling.particles import Particles
from fbcouple.coupling.polyhedral.bricks import find_grid
from fbcouple.coupling.polyhedral.cells import MeshCells
from fbcouple.geometry.baffles import pair_faces, split_points
from fbcouple.geometry.block import make_block
from fbcouple.geometry.polyhedra import find_centres, take_apart
from fbcouple.geometry.tetrahedra import cut

sys.path.append(str(Path(__file__).parents[1] / "geometry"))
from test_baffles import make_divided
from test_meshes import make_bricks

COMM, CELLS, SIZE = MPI.COMM_SELF, (4, 3, 5), (0.04, 0.03, 0.05)
CASE = {
    "title": "bricks",
    "end_time": 1.0,
    "domain": {"size": SIZE, "cells": CELLS},
    "gas": {"density": 1.2, "viscosity": 2e-5, "inlet_velocity": 1.0},
    "particles": {"diameter": 1e-3, "density": 2500.0, "count": 500},
    "contact": {"restitution": 0.9, "wall_restitution": 0.9, "friction": 0.1, "wall_friction": 0.1},
    "start": {},
    "exchange": {"filter_passes": 1},
}


def take(mesh):
    cells = take_apart(mesh, find_centres(mesh), np.arange(mesh.count), np.arange(len(mesh.points)))
    parts = cut(cells)
    return cells, np.bincount(parts.owners, parts.volumes)


def move(mesh, points):
    return replace(mesh, points=points(mesh.points))


def test_a_box_of_bricks_is_known_wherever_it_stands():
    corner = np.array([-0.02, 0.1, -0.003])
    grid = find_grid(COMM, *take(move(make_bricks(CELLS, SIZE), lambda points: np.round(points + corner, 10))))
    assert grid is not None and grid.cells == CELLS
    assert grid.size == pytest.approx(SIZE, rel=1e-8) and grid.origin == pytest.approx(corner, abs=1e-10)


@pytest.mark.parametrize(
    "mesh",
    [
        make_block(SIZE, CELLS, "prisms"),
        move(make_bricks(CELLS, SIZE), lambda points: points + [0.0, 0.0, 1.0] * np.sin(40.0 * points) * 1e-4),
        move(make_bricks(CELLS, SIZE), lambda points: points[:, [0, 1, 2]] @ [[1, 0, 0.1], [0, 1, 0], [0, 0, 1]]),
    ],
    ids=["prisms", "graded", "sheared"],
)
def test_what_is_no_box_of_equal_cells_is_not_taken_for_one(mesh):
    assert find_grid(COMM, *take(mesh)) is None


def test_a_box_with_a_baffle_is_none():
    """The box's weights and filter would reach across it."""
    mesh = make_divided()
    assert find_grid(COMM, *take(mesh)) is not None
    assert find_grid(COMM, *take(split_points(mesh, pair_faces(mesh)))) is None


def couple(grid, cells, volumes, shift):
    case, rng = Case.model_validate(CASE), np.random.default_rng(1)
    places = rng.uniform(5e-4, np.array(SIZE) - 5e-4, (500, 3)) + shift
    bed = Particles(places, rng.normal(size=(500, 3)), np.full(500, 5e-4), np.full(500, 1.3e-6))
    bounds = np.array([np.zeros(3), SIZE]) + shift
    bricks = None if grid is None else (grid, volumes)
    coupling = Coupling(case, BoxSpace(case, COMM, cells.centres, bounds, 1e-3, bricks))
    coupling.read_gas(rng.normal(size=(len(cells), 6)))
    coupling.map(bed)
    coupling.deposit_drag(bed, 1e-4)
    return coupling


def test_coupling_is_the_same_to_the_last_bit_as_in_the_built_in_box():
    cells, volumes = take(make_bricks(CELLS, SIZE))
    grid = find_grid(COMM, cells, volumes)
    box, found = couple(None, cells, volumes, 0.0), couple(grid, cells, np.full(len(cells), grid.cell_volume), 0.0)
    assert (found.drag_sums == box.drag_sums).all() and (found.voidage == box.voidage).all()


def test_and_the_same_to_rounding_elsewhere():
    cells, volumes = take(make_bricks(CELLS, SIZE))
    shift = np.array([-0.02, 0.1, -0.003])
    moved = replace(cells, points=cells.points + shift, centres=cells.centres + shift)
    box, found = couple(None, cells, volumes, 0.0), couple(find_grid(COMM, moved, volumes), moved, volumes, shift)
    assert np.abs(found.drag_sums - box.drag_sums).max() < 1e-11 * np.abs(box.drag_sums).max()
    assert np.abs(found.voidage - box.voidage).max() < 1e-12


def test_a_particle_behind_a_wall_is_found():
    cells, volumes = take(make_bricks(CELLS, SIZE))
    grid = find_grid(COMM, cells, volumes)
    inside, behind = np.full((1, 3), 0.01), np.array([[0.01, 0.01, 0.01], [0.01, -1e-5, 0.01]])
    known = MeshCells(COMM, grid, cells, volumes, grid)
    assert known.find_outside(inside) is None and known.find_outside(behind) == 1
    assert MeshCells(COMM, grid, cells, volumes).find_outside(behind) is None
