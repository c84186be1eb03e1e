"""A region that is no box in the decks: walls from its surface, schemes for cells that are no bricks."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_render import CYLINDER, build, join

from fbcouple.case.bed.particle_types import particle_count
from fbcouple.case.bed.region import read_mesh
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks, set_up
from fbcouple.geometry.block import make_block
from fbcouple.geometry.cylinder import count_cells, find_section
from fbcouple.geometry.foam_files import read_polymesh, write_polymesh
from fbcouple.launcher.openfoam_mesh import prepare_mesh

sys.path.append(str(Path(__file__).parents[1] / "geometry"))
from test_meshes import make_bricks


@pytest.fixture(scope="module")
def case():
    return build(**CYLINDER | {"domain__size": [0.03, 0.03, 0.06], "domain__cells": [6, 6, 8], "particles__mass": 0.01})


def test_walls_are_the_surface_of_the_mesh(case):
    decks = render_decks(case)
    liggghts = decks["DEM/in.liggghts"]
    assert "plane" not in liggghts and liggghts.count("wall/gran") == 1
    assert "mesh/surface file DEM/walls.stl type 2" in liggghts and "mesh n_meshes 1 meshes surface" in liggghts
    assert "orthogonal" not in decks["CFD/system/fvSchemes"] and "leastSquares" in decks["CFD/system/fvSchemes"]


def test_no_trace_of_it_in_a_box():
    assert not find_needs(build())["mesh_of_polyhedra"]
    for word in ("stl", "leastSquares", "corrected", "n_meshes", "velocityFromMomentum"):
        assert word not in join(render_decks(build()))


@pytest.mark.parametrize("form", ["bricks", "graded", "prisms"])
def test_bricks_of_a_file_have_the_schemes_of_a_box(tmp_path, form):
    size, cells = (0.04, 0.03, 0.05), (4, 3, 5)
    mesh = make_block(size, cells, "prisms") if form == "prisms" else make_bricks(cells, size)
    if form == "graded":
        mesh = replace(mesh, points=mesh.points * (0.5 + 10.0 * mesh.points))
    write_polymesh(mesh, tmp_path / "polyMesh")
    named = {"domain__shape": "file", "domain__mesh": "polyMesh", "domain__size": (mesh.high - mesh.low).tolist()}
    case = build(**named, domain__cells=list(cells), gas__closed_nozzle=None)
    box = build(domain__size=list(size), domain__cells=list(cells), gas__closed_nozzle=None)
    decks, wanted = render_decks(case, tmp_path), render_decks(box)
    for name in ("CFD/system/fvSchemes", "CFD/system/fvSolution"):
        assert (decks[name] == wanted[name]) == (form != "prisms"), name


def test_a_box_of_tetrahedra_has_plane_walls(tmp_path):
    case = build(domain__elements="tetrahedra", gas__closed_nozzle=None, domain__cells=[4, 3, 5])
    decks = render_decks(case)
    liggghts = decks["DEM/in.liggghts"]
    assert "walls.stl" not in liggghts and liggghts.count("wall/gran") == 6
    assert "CFD/system/blockMeshDict" not in decks and "leastSquares" in decks["CFD/system/fvSchemes"]
    set_up(case, tmp_path / "run")
    assert not (tmp_path / "run/DEM/walls.stl").exists()


def test_what_setup_writes(case, tmp_path):
    set_up(case, tmp_path / "run")
    corners = [
        [float(word) for word in line.split()[1:]]
        for line in (tmp_path / "run/DEM/walls.stl").read_text().splitlines()
        if "vertex" in line
    ]
    a, b, c = np.array(corners).reshape(-1, 3, 3).transpose(1, 0, 2)
    volume = find_section(0.03, 6) * 0.06
    # Normals point into the region: its volume by the divergence theorem is negative.
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(-volume, rel=1e-12)
    data = (tmp_path / "run/DEM/particles.data").read_text()
    assert "-0.001 0.031 xlo xhi" in data and "-0.001 0.061 zlo zhi" in data
    rows = [line.split() for line in data[data.index("Atoms") :].splitlines()[2:]]
    places = np.array(rows, dtype=float)[:, 4:]
    assert len(places) == particle_count(case.particles)
    angle = np.arange(18) * 2 * math.pi / 18 + math.pi / 18
    reach = (places[:, :2] - 0.015) @ np.stack([np.cos(angle), np.sin(angle)])  # towards each of the 18 sides
    assert reach.max() < 0.015 * math.cos(math.pi / 18) - 0.5e-3 and places[:, 2].min() > 0.5e-3
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + np.eye(len(places))
    assert apart.min() > 1e-3


def test_the_mesh_of_a_run_has_three_patches(case, tmp_path):
    set_up(case, tmp_path / "run")
    prepare_mesh(case, tmp_path / "run", 1)
    mesh = read_polymesh(tmp_path / "run/CFD/constant/polyMesh")
    assert mesh.count == count_cells(6, 8, "tetrahedra") == 6 * 9 * 8 * 3
    assert list(mesh.patches) == ["inlet", "outlet", "walls"]
    assert mesh.find_area("inlet") == pytest.approx(find_section(0.03, 6), rel=1e-12)
    assert mesh.volume == pytest.approx(read_mesh(case).volume, rel=1e-12)
