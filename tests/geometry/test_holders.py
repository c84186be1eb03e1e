"""The cell that holds a point: the same one whichever parts the mesh is in, where cells meet, too."""

import numpy as np
import pytest

from fbcouple.geometry.block import make_block
from fbcouple.geometry.cylinder import make_cylinder
from fbcouple.geometry.holders import NOWHERE, find_holders
from fbcouple.geometry.polyhedra import find_centres, take_apart

MESHES = {
    "tetrahedra": make_cylinder(0.02, 0.03, 4, 6, "tetrahedra"),
    "prisms": make_cylinder(0.02, 0.03, 4, 6, "prisms"),
    "block": make_block((0.02, 0.02, 0.03), (3, 3, 4), "tetrahedra"),
}


@pytest.fixture(params=MESHES)
def cells(request):
    mesh = MESHES[request.param]
    return take_apart(mesh, find_centres(mesh), np.arange(mesh.count), np.arange(len(mesh.points)))


def test_a_centre_is_in_its_own_cell(cells):
    assert find_holders(cells, cells.centres).tolist() == cells.ids.tolist()


def test_points_outside_are_in_none(cells):
    outside = np.array([[0.01, 0.01, -1e-6], [0.01, 0.01, 0.031], [-1e-6, 0.01, 0.01], [np.nan, 0.0, 0.0]])
    assert find_holders(cells, outside).tolist() == [NOWHERE] * 4


@pytest.mark.parametrize("seed", [1, 2])
def test_parts_of_the_mesh_agree_on_points_that_many_cells_share(cells, seed):
    """Points of the mesh, of which each is in several cells, walls among them, and the middles of its cells' sides."""
    rng = np.random.default_rng(seed)
    sides = np.array([cells.points[cells.faces.take(np.array([face])).values].mean(axis=0) for face in range(40)])
    points = np.concatenate([cells.points[:60], sides, rng.uniform(0.0, 0.02, (20, 3))])
    whole = find_holders(cells, points)
    assert (whole[:100] >= 0).all()
    part = rng.integers(0, 3, len(cells))
    found = [find_holders(cells.select(np.flatnonzero(part == n)), points) for n in range(3)]
    assert np.max(found, axis=0).tolist() == whole.tolist()
