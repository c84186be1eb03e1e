"""A mesh on the regular grid: means over the depth of what is inside, values at the places of cells."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.coupling.box.cells import BoxCells
from fbcouple.coupling.polyhedral.bricks import find_grid
from fbcouple.coupling.polyhedral.cells import MeshCells
from fbcouple.geometry.cylinder import make_cylinder
from fbcouple.geometry.grid import Grid
from fbcouple.geometry.polyhedra import find_centres, take_apart
from fbcouple.geometry.tetrahedra import cut

sys.path.append(str(Path(__file__).parents[1] / "geometry"))
from test_meshes import make_bricks

COMM = MPI.COMM_SELF


def take(mesh):
    """Cells in an order of their own."""
    order = np.random.default_rng(2).permutation(mesh.count)
    cells = take_apart(mesh, find_centres(mesh), np.arange(mesh.count), np.arange(len(mesh.points))).select(order)
    parts = cut(cells)
    return cells, np.bincount(parts.owners, parts.volumes)


@pytest.mark.parametrize("known", [True, False], ids=["as bricks", "as polyhedra"])
def test_bricks_give_what_the_box_gives(known):
    shape, size = (4, 3, 5), (0.04, 0.03, 0.05)
    cells, volumes = take(make_bricks(shape, size))
    grid = Grid(shape, size)
    mesh = MeshCells(COMM, grid, cells, volumes, find_grid(COMM, cells, volumes) if known else None)
    box = BoxCells(grid, grid.indices(cells.centres))
    values = np.random.default_rng(3).uniform(size=len(cells))
    found, wanted = (of.open_depth_mean(COMM).find(values) for of in (mesh, box))
    assert found.shape == (5, 4) and np.abs(found - wanted).max() < 1e-14
    mesh.prepare_samples(COMM)
    vectors = np.random.default_rng(4).uniform(size=(len(cells), 3)).astype(np.float32)
    sampled = mesh.sample([(mesh.owned, vectors)])
    assert sampled.dtype == np.float32 and (sampled == box.sample([(box.owned, vectors)])).all()


def test_columns_count_with_what_is_inside_of_the_mesh():
    """Values that go linearly along x and z come back, and nothing where the whole column is outside."""
    mesh = make_cylinder(0.04, 0.05, 12, 10, "prisms")
    cells, volumes = take(mesh)
    grid = Grid((10, 6, 5), (0.06, 0.04, 0.05), origin=(0.0, 0.0, 0.0))
    found = MeshCells(COMM, grid, cells, volumes).open_depth_mean(COMM).find(3.0 + 10.0 * cells.centres[:, 2])
    z = np.arange(5)[:, None] * 0.01 + 0.005
    assert np.isfinite(found[:, :6]).all() and np.isnan(found[:, 7:]).all()
    assert np.abs(found[:, :6] - (3.0 + 10.0 * z)).max() < 0.1 / 6


def test_places_outside_of_the_mesh_have_no_value():
    mesh = make_cylinder(0.04, 0.05, 12, 10, "prisms")
    cells, volumes = take(mesh)
    known = MeshCells(COMM, Grid((8, 8, 5), (0.04, 0.04, 0.05)), cells, volumes)
    known.prepare_samples(COMM)
    field = known.sample([(known.owned, np.ones((len(cells), 1), np.float32))])
    assert np.isnan(field[:, 0, 0]).all() and (field[:, 2:6, 2:6] == 1.0).all()
