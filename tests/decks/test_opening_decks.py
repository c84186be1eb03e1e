"""Decks of a case with inlets and outlets as tables: what each inlet has of each face, and no blockMesh."""

from __future__ import annotations

import re

import numpy as np
import pytest
from test_render import build

from fbcouple.case.bed.adopt_inlets import adopt_inlets
from fbcouple.case.bed.region import find_openings, read_mesh
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks
from fbcouple.decks.set_up import lay_out
from fbcouple.geometry.block import list_cyclic, make_hexahedra
from fbcouple.geometry.foam_files import read_polymesh, write_polymesh
from fbcouple.geometry.quality import require_sound
from fbcouple.launcher.launch import launch

FLOOR = {"rectangle": [[0.0, 0.0], [0.01, 0.006]], "velocity": 0.5}
JET = {"circle": [0.0051, 0.0029, 0.0033], "ramp": [[0.0, 0.0], [1e-3, 4.0], [1e-3, 3.0]]}
PORT = {"rectangle": [[0.0009, 0.0013], [0.0052, 0.0147]], "face": "right", "velocity": 1.0, "profile": "parabolic"}


def build_inlets(*inlets, **changes):
    changes = {"gas__inlet_velocity": None, "gas__closed_nozzle": None, "gas__inlets": list(inlets)} | changes
    return adopt_inlets(build(**changes))


def read_shares(text):
    """Parts of the faces of the inlet, a row for each stream."""
    found = re.findall(r"share\d+ +nonuniform List<scalar> (\d+)\s+\(([^()]*)\);", text)
    shares = [np.array(numbers.split(), float) for _, numbers in found]
    assert [len(row) for row in shares] == [int(count) for count, _ in found]
    return np.array(shares)


def find_areas(mesh):
    return np.linalg.norm(mesh.find_vectors(mesh.list_patch("inlet")), axis=1)


@pytest.mark.parametrize("elements", [None, "prisms", "tetrahedra"])
def test_each_inlet_has_its_area_on_any_cells(elements):
    case = build_inlets(FLOOR, JET, PORT, **({"domain__elements": elements} if elements else {}))
    jet = np.pi * 0.0033**2 / 4
    expected = [0.01 * 0.006 - jet, jet, 0.0043 * 0.0134]
    shares = read_shares(render_decks(case)["CFD/0/U"])
    assert shares @ find_areas(read_mesh(case)) == pytest.approx(expected, rel=1e-12)
    assert [inlet.area for inlet in case.gas.inlets] == pytest.approx(expected, rel=1e-12)
    assert case.gas.inlet_section == 0.01 * 0.006
    # the profile goes beyond 1 in the middle, all others stay within a face, and each face of the floor is full
    assert shares.min() > -1e-12 and shares[:2].max() <= 1.0 + 1e-12 and shares[2].max() > 1.5
    floor = shares[2] == 0.0
    assert shares[:2, floor].sum(axis=0) == pytest.approx(1.0, abs=1e-12)


def test_tables_are_in_the_deck_and_blockmesh_is_not_asked():
    case = build_inlets(FLOOR, JET)
    decks = render_decks(case)
    assert find_needs(case)["openings"] and not find_needs(build())["openings"]
    assert "CFD/system/blockMeshDict" not in decks and "CFD/system/topoSetDict" not in decks
    tables = re.findall(r"table\d\s+\(\s*((?:\([^()]*\)\s*)+)\);", decks["CFD/0/U"])
    rows = [[tuple(map(float, row.split())) for row in re.findall(r"\(([^()]*)\)", table)] for table in tables]
    assert rows == [[(0.0, 0.5)], [(0.0, 0.0), (1e-3, 4.0), (1e-3, 3.0)]]
    assert "share" not in render_decks(build())["CFD/0/U"]


def test_what_no_inlet_covers_and_what_is_closed_is_wall():
    closed = {"rectangle": [[0.002, 0.0], [0.0063, 0.006]], "velocity": 0.0}
    case = build_inlets(FLOOR, closed)
    openings = find_openings(case)
    # faces of 2 mm: one is closed as a whole, one to 15 %
    assert openings.mesh.patches["inlet"][1] == 3 * 3
    assert sorted(set(np.round(openings.shares[0], 12))) == [0.85, 1.0]
    only = find_openings(build_inlets(JET)).mesh
    assert only.patches["inlet"][1] == 9 and only.patches["walls"][1] == 2 * 50 + 2 * 30 + 15 - 9


def test_a_closed_nozzle_in_metres_is_the_same_on_every_mesh():
    for cells in ([5, 3, 10], [7, 5, 8], [20, 12, 10]):
        case = build(gas__closed_nozzle=None, gas__closed_nozzle_size=[0.0023, 0.0031], domain__cells=cells)
        (shares,) = read_shares(render_decks(case)["CFD/0/U"])
        area = shares @ find_areas(read_mesh(case))
        assert area == pytest.approx(0.01 * 0.006 - 0.0023 * 0.0031, rel=1e-12)
        (velocity,) = re.findall(r"table1\s+\(\s+\(0.0 (\S+)\)", render_decks(case)["CFD/0/U"])
        assert float(velocity) * area == pytest.approx(1.2 * 0.01 * 0.006, rel=1e-12)


def test_outlets_are_whole_faces_and_all_else_is_wall():
    port = {"rectangle": [[0.0, 0.01], [0.006, 0.0145]], "face": "left"}
    mesh = find_openings(build_inlets(FLOOR, gas__outlets=[port])).mesh
    first, count = mesh.patches["outlet"]
    assert count == 3 * 2  # of layers of 2 mm those whose centres are from 10 to 14.5 mm
    assert np.all(mesh.points[mesh.faces.take(np.arange(first, first + count)).values, 0] == 0.0)
    assert mesh.patches["inlet"][1] == 15


def test_the_box_of_hexahedra_is_sound_and_repeats_itself_point_by_point(tmp_path):
    mesh = make_hexahedra((0.01, 0.006, 0.02), (5, 3, 10), ("x", "y"))
    require_sound(mesh)
    assert mesh.volume == pytest.approx(0.01 * 0.006 * 0.02, rel=1e-12) and mesh.count == 150
    for low, high, size in (("xlo", "xhi", [0.01, 0, 0]), ("ylo", "yhi", [0, 0.006, 0])):
        one, other = (mesh.faces.take(mesh.list_patch(name)).values.reshape(-1, 4) for name in (low, high))
        partner = other[:, [0, 3, 2, 1]]  # the other way round, from the same point
        assert mesh.points[one] + size == pytest.approx(mesh.points[partner], abs=1e-15)
    write_polymesh(mesh, tmp_path, list_cyclic(("x", "y")))
    assert "xlo { type cyclic; neighbourPatch xhi;" in (tmp_path / "boundary").read_text()


@pytest.mark.parametrize("patches", [["inlet"], ["xlo"], ["inlet", "yhi"]])
def test_patches_of_a_mesh_that_are_called_as_cyclic_ones_of_a_box_are_inlets_or_walls(tmp_path, patches):
    """Gas alone, by OpenFOAM: a mesh file repeats itself nowhere, whatever its patches are called."""
    made = make_hexahedra((0.01, 0.006, 0.02), (5, 3, 10), ("x", "y"))
    write_polymesh(made, tmp_path / "mesh")
    (tmp_path / "case.toml").write_text(GAS_ALONE.format(patches=patches))
    (run,) = lay_out(str(tmp_path), tmp_path / "run", (), False, True)
    rows: list[dict] = []
    launch(run, 1, rows.append)
    mesh = read_polymesh(run / "CFD/constant/polyMesh")
    assert mesh.count == made.count and sorted(mesh.patches) == ["inlet", "outlet", "walls"]
    assert mesh.find_area("inlet") == pytest.approx(sum(made.find_area(name) for name in patches), rel=1e-12)
    assert len(mesh.owner) == len(made.owner) and rows[-1]["time"] == pytest.approx(2e-3)


GAS_ALONE = """
title = "gas through a mesh"
end_time = 2e-3
[domain]
shape = "file"
mesh = "mesh"
[gas]
density = 1.2
viscosity = 1.8e-5
[[gas.inlets]]
patches = {patches}
velocity = 0.1
[[gas.outlets]]
patches = ["outlet"]
[output]
record_every = 1e-3
"""
