"""Cases with baffles in the mesh: they are told, and no particle starts in one."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fbcouple.case.bed.mesh_box import choose_cells
from fbcouple.case.bed.region import find_imported, read_mesh
from fbcouple.case.bed.region_lattice import Inside, fill_region
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate
from fbcouple.errors import CaseError
from fbcouple.geometry.foam_files import write_polymesh

sys.path.append(str(Path(__file__).parents[1] / "geometry"))
from test_baffles import add_baffle, make_divided, split
from test_meshes import make_bricks

CASE = """
title = "a box with a baffle"
end_time = 0.05
[domain]
shape = "file"
mesh = "polyMesh"
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 1.2
[particles]
diameter = 1e-3
density = 2500.0
count = 2000
[contact]
restitution = 0.97
wall_restitution = 0.97
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
"""


def bring(folder, *changes, mesh=None):
    """The case with a box with a baffle at x = 2 cm, 1 to 4 cm above the floor, or another mesh."""
    write_polymesh(mesh or make_divided(), folder / "polyMesh")
    text = CASE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / "case.toml").write_text(text)
    return str(folder / "case.toml")


def test_baffles_are_counted(tmp_path):
    """Each face once, though it is in two patches; a mesh without has no row. The sampling grid stays that of the
    bricks, and a strip that weights reach across is told."""
    strip = add_baffle(make_bricks((4, 4, 6), (0.04, 0.04, 0.06)), [0.0199, 0.02, 0.01], [0.0201, 0.03, 0.04])
    plain = make_bricks((4, 4, 6), (0.04, 0.04, 0.06))
    for mesh, wanted in ((make_divided(), [(12, None)]), (strip, [(3, "warn")]), (plain, [])):
        case = load_case(bring(tmp_path, mesh=mesh))
        found = [one for one in estimate(case, folder=tmp_path) if one.name == "baffle faces"]
        assert [(one.value, one.verdict) for one in found] == wanted
        assert choose_cells(find_imported(case.domain, tmp_path).mesh) == [4, 4, 6]


def test_no_particle_starts_in_a_baffle(tmp_path):
    """What lies behind it is in the mesh, too: sites are as far from its faces as from other walls."""
    across = "[start]\nspacing = 1.1\nregion = [[0.015, 0.025], [0.0, 0.04], [0.012, 0.038]]"
    case = load_case(bring(tmp_path, ("[start]", across), ("count = 2000", "count = 400")))
    places, _ = fill_region(case, read_mesh(case, tmp_path))
    off = np.abs(places[:, 0] - 0.02)
    assert len(places) == 400 and off.min() >= 0.5e-3 and (off < 1.6e-3).any()


@pytest.mark.parametrize(("x", "fits"), [(0.02, False), (0.0203, False), (0.0205, True)])
def test_positions_in_a_baffle_are_told(tmp_path, x, fits):
    (tmp_path / "beads.csv").write_text(f"x,y,z\n{x},0.015,0.025\n0.01,0.01,0.03\n")
    case = bring(tmp_path, ("count = 2000", 'count = 2\npositions = "beads.csv"'), ("[start]\n", ""))
    if fits:
        assert load_case(case)
        return
    with pytest.raises(CaseError, match=r"1 particles are not inside the mesh, first is particle 1"):
        load_case(case)


@pytest.mark.parametrize("patches", ['["plate_a"]', '["plate_*", "outlet"]'])
def test_an_outlet_of_particles_is_no_baffle(tmp_path, patches):
    """The other side is in the mesh: nobody would ever be out."""
    outlet = f"[[particles.outlets]]\npatches = {patches}\n[contact]"
    with pytest.raises(CaseError, match=r"outlet 1: (12|24) faces are of baffles.*outside of the mesh"):
        load_case(bring(tmp_path, ("[contact]", outlet)))


def test_a_wall_thinner_than_a_particle_is_one():
    """The two sides of a baffle up to 0.2 mm apart."""
    whole, mesh = make_divided(), split(make_divided())
    points = mesh.points.copy()
    points[len(whole.points) :, 0] += 2e-4  # those of the cells on the right
    inside = Inside(replace(mesh, points=points))
    x = np.linspace(0.017, 0.023, 601)
    line = np.column_stack([x, np.full(601, 0.02), np.full(601, 0.025)])
    clear = inside.is_clear(line, 0.5e-3)
    assert not clear[np.abs(x - 0.02) < 0.5e-3].any() and clear[np.abs(x - 0.02) > 0.8e-3].all()
