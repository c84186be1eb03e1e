"""Weights and filter in a mesh of polyhedra: what is written is kept, and read as it is written."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.coupling.box.filter import filtered
from fbcouple.coupling.polyhedral.filter import CellFilter, CellGeometry
from fbcouple.coupling.polyhedral.halo import CellHaloExchange
from fbcouple.coupling.polyhedral.mapping import CELL_METHODS
from fbcouple.errors import DivergedError
from fbcouple.geometry.baffles import pair_faces, split_points
from fbcouple.geometry.cylinder import make_cylinder
from fbcouple.geometry.polyhedra import find_centres, take_apart
from fbcouple.geometry.tetrahedra import cut

sys.path.append(str(Path(__file__).parents[1] / "geometry"))
from test_baffles import make_divided
from test_meshes import make_bricks

COMM = MPI.COMM_SELF


def open_halo(mesh, rings=1):
    cells = take_apart(mesh, find_centres(mesh), np.arange(mesh.count), np.arange(len(mesh.points)))
    return CellHaloExchange(COMM, cells, mesh.low, mesh.high, rings)


@pytest.fixture(params=["tetrahedra", "prisms", "bricks"])
def geometry(request):
    if request.param == "bricks":
        mesh = make_bricks((4, 3, 5), (0.04, 0.03, 0.05))
    else:
        mesh = make_cylinder(0.04, 0.05, 6, 5, request.param)
    return CellGeometry(open_halo(mesh).local)


def scatter_points(geometry, count=3000):
    parts, rng = cut(geometry.local.cells), np.random.default_rng(3)
    chosen = rng.choice(len(parts.volumes), count, p=parts.volumes / parts.volumes.sum())
    weights = rng.dirichlet(np.ones(4), count)
    return np.einsum("pk,pkd->pd", weights, parts.nodes[parts.corners[chosen]])


@pytest.mark.parametrize("method", CELL_METHODS)
def test_writing_keeps_totals_and_reading_is_its_transpose(geometry, method):
    points, rng = scatter_points(geometry), np.random.default_rng(4)
    mapping, smooth = CELL_METHODS[method](geometry), CellFilter(geometry, 2)
    mapping.locate(points, np.full(len(points), 1e-4))
    field = geometry.local.make_field(3)
    rows = mapping.open(field)
    given = rows[:] = rng.random(rows.shape)
    given = np.array(given)
    mapping.write(rows, field)
    assert field.sum(axis=0) == pytest.approx(given.sum(axis=0), rel=1e-13)
    smooth.average_transposed(field)
    assert field.sum(axis=0) == pytest.approx(given.sum(axis=0), rel=1e-13)
    values = rng.random(field.shape)
    read = mapping.read(smooth.average(values.copy()), 3)
    assert np.sum(read * given) == pytest.approx(np.sum(values[:-1] * field[:-1]), rel=1e-13)
    constant = mapping.read(smooth.average(np.full_like(field, 2.5)), 3)
    assert np.abs(constant - 2.5).max() < 1e-14


def test_even_particles_give_every_cell_the_same(geometry):
    """One in the middle of each tetrahedron, as large as it: where weights are linear that is exact."""
    parts = geometry.parts
    mapping = CELL_METHODS["trilinear"](geometry)
    mapping.locate(parts.nodes[parts.corners].mean(axis=1), np.zeros(len(parts.volumes)))
    field = geometry.local.make_field(1)
    rows = mapping.open(field)
    rows[:, 0] = parts.volumes
    mapping.write(rows, field)
    assert field[:-1, 0] / geometry.volumes == pytest.approx(1.0, rel=1e-13)


@pytest.mark.parametrize("shape", ["box", "tapered"])
def test_nothing_passes_a_baffle(shape):
    """Particles in the middle row of cells on the left, against it: their volume stays on the left, what they read is
    from there, and a pass of the filter leaves it there; at a free edge it goes around."""
    mesh = make_divided(shape)
    geometry = CellGeometry(open_halo(split_points(mesh, pair_faces(mesh))).local)
    right = geometry.local.cells.centres[:, 0] > 0.02
    mapping, smooth = CELL_METHODS["trilinear"](geometry), CellFilter(geometry, 1)
    rng = np.random.default_rng(6)
    points = rng.uniform([0.015, 0.001, 0.02], [0.02 - 1e-9, 0.039, 0.03], (400, 3))
    mapping.locate(points, np.zeros(len(points)))
    field = geometry.local.make_field(1)
    rows = mapping.open(field)
    rows[:] = 1.0
    mapping.write(rows, field)
    assert field.sum() == pytest.approx(400.0) and not field[:-1][right].any()
    values = np.where(np.append(right, True), 1.0, 0.0)[:, None]
    assert not mapping.read(values, 1).any()
    middle = np.abs(geometry.local.cells.centres[:, 2] - 0.025) < 0.005
    amounts = np.append(np.where(right, 0.0, middle), 0.0)[:, None]
    smooth.average_transposed(amounts)
    assert amounts.sum() == pytest.approx(8.0) and not amounts[:-1][right].any()
    mapping.locate(points[:1] * [1.0, 1.0, 0.0] + [0.0, 0.0, 0.0395], np.zeros(1))
    assert mapping.read(values, 1).max() > 0.1


def test_weights_do_not_jump_between_cells(geometry):
    """What is read on both sides of the faces of a cell agrees."""
    points = scatter_points(geometry, 300)
    mapping, values = CELL_METHODS["trilinear"](geometry), geometry.local.make_field(1)
    values[:] = np.random.default_rng(5).random(values.shape)
    line = points[:1] + np.linspace(0.0, 1.0, 20001)[:, None] * (points[1:2] - points[:1])
    mapping.locate(line, np.zeros(len(line)))
    cells = mapping.cells.copy()
    read = mapping.read(values, 1)[:, 0]
    assert len(np.unique(cells)) > 1
    step = np.linalg.norm(line[1] - line[0]) / geometry.volumes.min() ** (1 / 3)
    assert np.abs(np.diff(read)).max() < 20.0 * step


def test_filter_on_bricks_is_that_of_the_box():
    cells = (4, 3, 5)
    geometry = CellGeometry(open_halo(make_bricks(cells, (0.04, 0.03, 0.05))).local)
    field = geometry.local.make_field(2)
    field[:-1] = np.random.default_rng(6).random((60, 2))
    box = np.zeros((6, 4, 5, 2))
    box[:-1, :-1, :-1] = field[:-1].reshape(5, 3, 4, 2)
    wanted = filtered(box, 3, np.zeros_like(box))[:-1, :-1, :-1].reshape(60, 2)
    assert np.abs(CellFilter(geometry, 3).average_transposed(field)[:-1] - wanted).max() < 1e-14


def test_a_rank_whose_box_touches_no_cell_has_an_empty_patch():
    mesh = make_cylinder(0.04, 0.05, 6, 5, "tetrahedra")
    cells = take_apart(mesh, find_centres(mesh), np.arange(mesh.count), np.arange(len(mesh.points)))
    halo = CellHaloExchange(COMM, cells, np.array([1.0, 1.0, 1.0]), np.array([1.1, 1.1, 1.1]), 2)
    geometry = CellGeometry(halo.local)
    assert len(halo.local.cells) == 0
    for method in CELL_METHODS.values():
        mapping, smooth = method(geometry), CellFilter(geometry, 1)
        mapping.locate(np.empty((0, 3)), np.empty(0))
        field = halo.local.make_field(4)
        rows = mapping.open(field)
        mapping.write(rows, field)
        smooth.average_transposed(field)
        assert mapping.read(smooth.average(field), 4).shape == (0, 4)
        given = np.ones((mesh.count, 4))
        halo.reverse(field[:-1], given)
        assert not given.any()
        halo.forward(given, field)
        with pytest.raises(DivergedError, match="no cell of the mesh"):
            mapping.locate(np.ones((1, 3)), np.ones(1))
