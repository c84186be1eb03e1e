"""Cells that no gas can flow in are told, with how many and where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_meshes import make_bricks

from fbcouple.errors import CaseError
from fbcouple.geometry.block import make_block
from fbcouple.geometry.cylinder import make_cylinder
from fbcouple.geometry.numbering import build_mesh
from fbcouple.geometry.polyhedra import find_centres
from fbcouple.geometry.quality import measure_cells, measure_widths, require_sound
from fbcouple.geometry.ragged import Ragged


@pytest.mark.parametrize("shift", [0.0, 4.5e5])
@pytest.mark.parametrize("elements", ["tetrahedra", "prisms", "bricks"])
def test_sound_meshes_pass_wherever_they_are(elements, shift):
    mesh = make_bricks((4, 3, 5), (0.4, 0.3, 0.5)) if elements == "bricks" else make_cylinder(0.4, 0.8, 8, 5, elements)
    mesh = replace(mesh, points=mesh.points + shift)
    require_sound(mesh)
    volumes, least, openness = measure_cells(mesh, find_centres(mesh))
    assert volumes.sum() == pytest.approx(mesh.volume, rel=1e-7 if shift else 1e-12)
    assert (least > 0.0).all() and openness.max() < 1e-9


def turn(mesh, face):
    """The face with its points the other way round."""
    backward = np.arange(len(mesh.faces)) == face
    return replace(mesh, faces=mesh.faces.take(np.arange(len(mesh.faces)), backward))


def test_a_face_that_goes_round_the_wrong_way():
    mesh = make_block((0.04, 0.03, 0.05), (4, 3, 5), "tetrahedra")
    with pytest.raises(CaseError, match=r"^1 of 360 cells are not closed"):
        require_sound(turn(mesh, len(mesh.owner) - 1))
    with pytest.raises(CaseError, match=r"^2 of 360 cells are not closed"):
        require_sound(turn(mesh, 0))


def test_all_faces_the_wrong_way():
    mesh = make_block((0.04, 0.03, 0.05), (4, 3, 5), "prisms")
    everything = np.arange(len(mesh.faces))
    inverted = replace(mesh, faces=mesh.faces.take(everything, np.ones(len(mesh.faces), bool)))
    with pytest.raises(CaseError, match=r"120 of 120 cells have no positive volume.*first: cell 0 at \("):
        require_sound(inverted)


def test_a_point_pulled_through_a_wall():
    mesh = make_bricks((3, 3, 3), (3.0, 3.0, 3.0))
    points = mesh.points.copy()
    inner = np.flatnonzero(np.all(points == [1.0, 1.0, 1.0], axis=1))
    points[inner] = [2.6, 2.6, 2.6]
    with pytest.raises(CaseError, match=r"no positive volume|star-shaped"):
        require_sound(replace(mesh, points=points))


def test_a_face_that_is_missing():
    mesh = make_bricks((2, 2, 2), (1.0, 1.0, 1.0))
    kept = np.arange(len(mesh.owner) - 1)
    first, count = mesh.patches["walls"]
    patches = mesh.patches | {"walls": (first, count - 1)}
    with pytest.raises(CaseError, match="1 of 8 cells are not closed: a face is missing"):
        require_sound(replace(mesh, faces=mesh.faces.take(kept), owner=mesh.owner[kept], patches=patches))


def stack(gap, merged):
    """Two bricks, one above the other."""
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    heights = [0.0, 1.0, 2.0] if merged else [0.0, 1.0, 1.0 + gap, 2.0]
    points = np.concatenate([np.column_stack([square, np.full(4, z)]) for z in heights])
    above = 4 if merged else 8
    cells = np.array([range(8), range(above, above + 8)])
    return build_mesh(points, [("hexahedron", cells)], ["walls"], lambda rows: np.zeros(len(rows), int))


def test_bodies_that_share_no_face():
    require_sound(stack(0.0, True))
    with pytest.raises(
        CaseError, match=r"2 bodies that share no face \(of 1, 1 cells\), and 4 points are there twice: .*Coherence"
    ):
        require_sound(stack(0.0, False))
    with pytest.raises(CaseError, match=r"2 bodies that share no face \(of 1, 1 cells\); join them, or keep one"):
        require_sound(stack(0.1, False))


def test_the_last_cell_counts_though_it_owns_no_face():
    mesh = make_bricks((3, 3, 3), (3.0, 3.0, 3.0))
    middle = 13
    number = np.arange(27)
    number[[middle, 26]] = 26, middle  # the cell inside of all others is the last: its neighbours own its faces
    cells = number[np.concatenate([mesh.owner, mesh.neighbour])]
    owner, neighbour = cells[: len(mesh.owner)], cells[len(mesh.owner) :]
    inner = len(neighbour)
    swap = np.concatenate([owner[:inner] > neighbour, np.zeros(len(owner) - inner, bool)])
    faces = mesh.faces.take(np.arange(len(mesh.faces)), swap)
    low, high = np.minimum(owner[:inner], neighbour), np.maximum(owner[:inner], neighbour)
    renumbered = replace(mesh, faces=faces, owner=np.concatenate([low, owner[inner:]]), neighbour=high)
    assert renumbered.owner.max() == 25 and renumbered.count == 27
    require_sound(renumbered)
    assert isinstance(renumbered.faces, Ragged) and renumbered.volume == pytest.approx(27.0)


def test_bricks_are_as_wide_as_their_edges():
    widths = measure_widths(make_bricks((4, 3, 5), (0.4, 0.6, 0.25)))
    assert widths == pytest.approx(np.tile([0.1, 0.2, 0.05], (60, 1)), rel=1e-12)


def test_the_width_of_a_cell_is_what_its_courant_number_counts():
    """Of a uniform flow half the flows through the faces of a cell add up to u V over its width along u."""
    mesh = make_cylinder(0.4, 0.8, 8, 5, "tetrahedra")
    flow = np.abs(mesh.find_vectors(np.arange(len(mesh.owner))) @ [0.0, 0.0, 3.0])
    inner = slice(len(mesh.neighbour))
    sums = np.bincount(mesh.owner, flow, mesh.count) + np.bincount(mesh.neighbour, flow[inner], mesh.count)
    volumes, *_ = measure_cells(mesh, find_centres(mesh))
    assert 0.5 * sums / volumes == pytest.approx(3.0 / measure_widths(mesh)[:, 2], rel=1e-12)
