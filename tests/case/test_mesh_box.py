"""What a mesh from a file says itself: its size, the grid that it is sampled on; a wrong unit still shows."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fbcouple.case.bed.mesh_box import choose_cells
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate
from fbcouple.decks.set_up import lay_out
from fbcouple.errors import CaseError
from fbcouple.geometry.cylinder import make_cylinder
from fbcouple.geometry.foam_files import write_polymesh
from fbcouple.geometry.stl import list_walls

sys.path.append(str(Path(__file__).parents[1] / "geometry"))
from test_meshes import make_bricks, write_gmsh

CASE = """
title = "mesh"
end_time = 0.05
[domain]
shape = "file"
mesh = "mesh.msh"
inlet = "in"
outlet = "out"
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 1.2
[particles]
diameter = 1e-3
density = 2500.0
count = 1500
[contact]
restitution = 0.97
wall_restitution = 0.97
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
"""


def write(folder, mesh, text=CASE):
    write_gmsh(mesh, folder / "mesh.msh")
    (folder / "case.toml").write_text(text)
    return str(folder / "case.toml")


def column():
    mesh = make_cylinder(0.03, 0.06, 6, 12, "tetrahedra")
    return replace(mesh, points=mesh.points - [0.015, 0.015, 0.01])


def tell(case, folder):
    return {number.name: number for number in estimate(case, folder=folder)}


def test_size_and_grid_are_those_of_the_mesh(tmp_path):
    mesh = column()
    case = load_case(write(tmp_path, mesh))
    assert case.domain.size == tuple((mesh.high - mesh.low).tolist())
    spacing = np.array(case.domain.size) / case.domain.cells
    assert np.abs(spacing / np.cbrt(mesh.volume / mesh.count) - 1.0).max() < 0.05
    numbers = tell(case, tmp_path)
    assert numbers["mesh z"].value == case.domain.size[2] and "-0.01 to 0.05 m" in numbers["mesh z"].meaning
    assert " x ".join(map(str, case.domain.cells)) in numbers["sampling grid"].meaning
    assert numbers["filled part"].verdict == "fit"


def test_a_block_of_rows_is_sampled_cell_by_cell_and_what_is_given_stays(tmp_path):
    write_polymesh(make_bricks((4, 3, 5), (0.04, 0.03, 0.05)), tmp_path / "polyMesh")
    path = str(tmp_path / "case.toml")
    text = CASE.replace('"mesh.msh"', '"polyMesh"').replace('"in"', '"inlet"').replace('"out"', '"outlet"')
    (tmp_path / "case.toml").write_text(text)
    assert load_case(path).domain.cells == (4, 3, 5)
    assert load_case(path, ["domain.cells=[2, 2, 9]"]).domain.cells == (2, 2, 9)
    with pytest.raises(CaseError, match=r"domain\.size: .* within 1% is allowed"):
        load_case(path, ["domain.size=[0.04, 0.03, 0.06]"])


def test_layers_of_prisms_are_sampled_layer_by_layer():
    """Squares as large as a mean triangle across; tetrahedra of the same layers stay cubes."""
    mesh = make_cylinder(0.03, 0.06, 6, 8, "prisms")
    across, depth, up = choose_cells(mesh)
    assert up == 8 and across == pytest.approx(0.03 / math.sqrt(mesh.volume / 0.06 / (mesh.count / 8)), abs=0.5)
    assert abs(across - depth) <= 1
    assert choose_cells(column())[2] != 12
    uneven = mesh.points.copy()
    uneven[:, 2] **= 2
    assert choose_cells(replace(mesh, points=uneven))[2] != 8


def test_the_run_says_both(tmp_path):
    mesh = column()
    lay_out(write(tmp_path, mesh), tmp_path / "run", (), False, forced=True)
    case = load_case(str(tmp_path / "run"))
    assert f"size = {(mesh.high - mesh.low).tolist()}" in (tmp_path / "run/case.toml").read_text()
    assert case.domain.size == tuple((mesh.high - mesh.low).tolist())


@pytest.mark.parametrize(("scale", "told"), [("25.4", "filled part"), ("1000.0", "filled part")])
def test_a_mesh_in_another_unit_is_noticed(tmp_path, scale, told):
    case = load_case(write(tmp_path, column()), [f"domain.scale={scale}"])
    assert tell(case, tmp_path)[told].verdict == "warn"


def test_a_mesh_that_is_too_small_is_refused_with_its_unit(tmp_path):
    with pytest.raises(CaseError, match=r"do not fit .*domain\.scale"):
        load_case(write(tmp_path, column()), ["domain.scale=0.3"])


def test_a_mesh_that_cannot_be_read_is_told_once_and_nothing_else_is_asked_for(tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    with pytest.raises(CaseError) as refused:
        load_case(str(tmp_path / "case.toml"))
    (problem,) = refused.value.problems
    assert "domain.mesh" in problem and "cannot be read" in problem


def test_a_box_has_to_say_its_size(tmp_path):
    (tmp_path / "case.toml").write_text(CASE.replace('shape = "file"', 'shape = "box"'))
    with pytest.raises(CaseError, match=r"domain\.size: is missing"):
        load_case(str(tmp_path / "case.toml"))


def test_walls_of_a_mesh_that_fills_a_box_are_its_sides():
    mesh = make_bricks((4, 3, 5), (0.04, 0.03, 0.05))
    walls = list_walls(replace(mesh, points=mesh.points - [0.01, 0.02, 0.03]))
    a, b, c = walls.transpose(1, 0, 2)
    assert len(walls) == 12 and walls.min(axis=(0, 1)).tolist() == [-0.01, -0.02, -0.03]
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(-0.04 * 0.03 * 0.05, rel=1e-12)
    assert len(list_walls(column())) > 100
