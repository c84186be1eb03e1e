"""Walls without thickness inside of a mesh, as createBaffles makes them: found, and written as walls once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_meshes import break_up, make_bricks

from fbcouple.geometry.baffles import find_unsplit, pair_faces, split_points
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.stl import list_walls
from fbcouple.geometry.tetrahedra import cut, find_neighbours

CELLS, SIZE = (4, 4, 6), (0.04, 0.04, 0.06)


def add_baffle(mesh, low, high):
    """The inner faces whose middles lie between `low` and `high` (3,) [m] as two walls, back to back, as createBaffles
    has them."""
    inner = len(mesh.neighbour)
    rows = mesh.faces.take(np.arange(inner))
    middles = np.add.reduceat(mesh.points[rows.values], rows.starts[:-1], axis=0) / rows.lengths[:, None]
    chosen = np.all((middles >= low) & (middles <= high), axis=1)
    plate, kept = np.flatnonzero(chosen), np.flatnonzero(~chosen)
    order = np.concatenate([kept, np.arange(inner, len(mesh.owner)), plate, plate])
    backward = np.arange(len(order)) >= len(order) - len(plate)
    owner = np.concatenate([mesh.owner[order[: -len(plate)]], mesh.neighbour[plate]])
    ends = len(order) - 2 * len(plate), len(order) - len(plate)
    patches = {name: (first - len(plate), count) for name, (first, count) in mesh.patches.items()}
    patches |= {"plate_a": (ends[0], len(plate)), "plate_b": (ends[1], len(plate))}
    return PolyMesh(mesh.points, mesh.faces.take(order, backward), owner, mesh.neighbour[kept], patches)


def make_divided(shape="box"):
    """Bricks about a baffle at x = 2 cm from wall to wall, 1 to 4 cm above the floor; "tapered": wider at the top."""
    mesh = make_bricks(CELLS, SIZE)
    if shape == "tapered":
        widen = 1.0 + mesh.points[:, 2:] * [2.0, 2.0, 0.0]
        middle = np.array([0.02, 0.02, 0.0])
        mesh = replace(mesh, points=middle + (mesh.points - middle) * widen)
    return add_baffle(mesh, [0.0199, -1.0, 0.01], [0.0201, 1.0, 0.04])


def split(mesh):
    """The sides of a baffle have points of their own, as `mergeOrSplitBaffles -split` and gmsh's Crack give them."""
    return split_points(mesh, pair_faces(mesh))


@pytest.mark.parametrize("shape", ["box", "tapered"])
@pytest.mark.parametrize("change", [lambda mesh: mesh, split], ids=["shared points", "own points"])
def test_faces_of_a_baffle_are_paired(shape, change):
    mesh = change(make_divided(shape))
    pairs = pair_faces(mesh)
    assert pairs.tolist() == np.column_stack([mesh.list_patch("plate_a"), mesh.list_patch("plate_b")]).tolist()
    assert len(pairs) == 4 * 3


def test_a_mesh_without_baffles_has_no_pairs():
    assert pair_faces(make_bricks(CELLS, SIZE)).shape == (0, 2)


@pytest.mark.parametrize("shape", ["box", "tapered"])
def test_a_baffle_is_a_wall_and_written_once(shape):
    """LIGGGHTS refuses a mesh with a triangle that is there twice; of a box the sides stay two triangles each."""
    mesh = make_divided(shape)
    walls = list_walls(mesh)
    sides = 12 if shape == "box" else 4 * (2 * 4 * 4 + 4 * 4 * 6)
    assert len(walls) == sides + 4 * 4 * 3
    corners = np.sort(np.round(walls, 9).view("f8,f8,f8")[..., 0], axis=1)
    assert len(np.unique(corners, axis=0)) == len(walls)
    assert (np.abs(walls[..., 0] - 0.02) < 1e-12).all(axis=1).sum() == 4 * 4 * 3
    assert len(list_walls(mesh, mesh.list_patch("plate_a"))) == len(walls)
    both = np.concatenate([mesh.list_patch(name) for name in ("plate_a", "plate_b")])
    assert len(list_walls(mesh, both)) == sides


def test_a_step_in_a_box_is_no_box():
    """Outer faces off the six sides, however small: all faces are walls."""
    mesh = make_bricks(CELLS, SIZE)
    points = mesh.points.copy()
    points[np.argmin(np.linalg.norm(points - [0.02, 0.02, 0.0], axis=1)), 2] = 1e-7
    assert len(list_walls(replace(mesh, points=points))) == 4 * (2 * 4 * 4 + 4 * 4 * 6)


@pytest.mark.parametrize("shape", ["box", "tapered"])
def test_points_are_shared_around_free_edges_alone(shape):
    """Of 4 x 3 faces from wall to wall the two inner rows of points become two, five each; the rows at the free edges
    stay. Nothing moves, and what is split once is split."""
    mesh = make_divided(shape)
    found = split(mesh)
    assert len(found.points) == len(mesh.points) + 2 * 5
    assert (found.points[found.faces.values] == mesh.points[mesh.faces.values]).all()
    assert len(split(found).points) == len(found.points) and not find_unsplit(found, pair_faces(found)).any()
    parts = cut(break_up(found))
    assert (find_neighbours(parts.corners) < 0).sum() == len(
        found.cut_faces(np.arange(len(found.neighbour), len(found.owner)))
    )


def test_faces_with_one_point_of_their_own_have_middles_of_their_own():
    """Of a free baffle of 2 x 2 faces the two sides of each share three of four points."""
    mesh = add_baffle(make_bricks(CELLS, SIZE), [0.0199, 0.01, 0.01], [0.0201, 0.03, 0.03])
    found = split(mesh)
    assert len(found.points) == len(mesh.points) + 1 and not find_unsplit(found, pair_faces(found)).any()
    surface = found.cut_faces(np.arange(len(found.neighbour), len(found.owner)))
    assert (find_neighbours(cut(break_up(found)).corners) < 0).sum() == len(surface)


def test_what_cannot_be_split_is_told():
    """A strip one cell wide between free edges has no point that the cells on one side alone have."""
    mesh = add_baffle(make_bricks(CELLS, SIZE), [0.0199, 0.02, 0.01], [0.0201, 0.03, 0.04])
    pairs = pair_faces(mesh)
    assert len(pairs) == 3 and len(split(mesh).points) == len(mesh.points)
    assert find_unsplit(split(mesh), pairs).all()
    attached = add_baffle(make_bricks(CELLS, SIZE), [0.0199, 0.03, 0.0], [0.0201, 0.04, 0.04])
    assert len(split(attached).points) == len(attached.points) + 4
    assert not find_unsplit(split(attached), pair_faces(attached)).any()
