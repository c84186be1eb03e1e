"""Feeds and outlets of particles in the decks, and no trace of them where there are none."""

from __future__ import annotations

import re

import numpy as np
import pytest
from test_render import build, join

from fbcouple.case.bed.region import read_mesh
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import find_box, render_decks
from fbcouple.decks.set_up import lay_out
from fbcouple.geometry.stl import list_walls
from fbcouple.launcher.launch import launch

FEED = {"low": [0.0, 0.0, 0.1], "high": [0.04, 0.01, 0.12], "rate": 100.0}
OPENING = {"face": "floor", "rectangle": [[0.002, 0.001], [0.004, 0.004]], "depth": 0.012}
DRY = {"gas": None, "exchange": None}
TRACES = r"identity|leaving|particletemplate|particledistribution|create_box|unfix|Plate"


def corners(text):
    rows = re.findall(r"vertex (\S+) (\S+) (\S+)", text)
    return np.array(rows, dtype=float).reshape(-1, 3, 3)


def area(triangles):
    return (
        np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1).sum() / 2
    )


def test_no_trace_of_what_is_not_asked_for():
    assert not re.search(TRACES, join(render_decks(build())))
    needs = find_needs(build())
    assert not any(needs[part] for part in ("feeds_and_outlets", "open_walls", "empty_start"))


@pytest.mark.parametrize("what", [{"particles__feeds": [FEED]}, {"particles__outlets": [{"face": "top"}]}])
def test_particles_that_come_or_go_are_known(what):
    case = build(**what)
    deck = render_decks(case)["DEM/in.liggghts"]
    assert find_needs(case)["feeds_and_outlets"] and not find_needs(case)["empty_start"]
    assert "property/atom identity vector yes no no" in deck and "group           leaving id 0\n" in deck
    assert "read_data       DEM/particles.data\n" in deck and "create_box" not in deck


def test_liggghts_knows_the_kinds_that_are_to_come():
    case = build(particles__feeds=[FEED | {"species": 2}], particles__mixture=[[0.8e-3, 1500.0, 0.3]])
    deck = render_decks(case)["DEM/in.liggghts"]
    radii = re.findall(r"particletemplate/sphere \d+ atom_type (\d) density constant (\S+) radius constant (\S+)", deck)
    diameter = case.particles.diameter
    assert [(int(t), float(d), float(r)) for t, d, r in radii] == [(1, 2500.0, diameter / 2), (2, 1500.0, 0.4e-3)]
    assert "particledistribution/discrete 32452843 2 kind1 0.5 kind2 0.5\n" in deck


def test_empty_start_has_a_box_and_no_particles():
    case = build(particles__count=0, particles__mass=None, particles__feeds=[FEED])
    deck = render_decks(case)["DEM/in.liggghts"]
    edges = re.search(r"region +box block (.*) units box\ncreate_box +2 box\n", deck)
    box = np.array(edges[1].split(), dtype=float).reshape(3, 2).T
    assert np.array_equal(box, find_box(case, None)) and "read_data" not in deck
    assert find_needs(case)["empty_start"]


FED = """
title = "less than half a parcel, and a feed"
end_time = 0.02
[domain]
size = [0.012, 0.012, 0.03]
cells = [3, 3, 6]
[particles]
diameter = 1e-3
density = 2500.0
FEW
[[particles.feeds]]
low = [0.0, 0.0, 0.02]
high = [0.012, 0.012, 0.03]
rate = 1600.0
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[output]
record_every = 0.01
"""


@pytest.mark.parametrize(
    "few", ["count = 3\ncoarse_graining = 2.0", "mass = 1e-7", "mass = 1e-7\ncoarse_graining = 2.0"]
)
def test_a_start_that_rounds_to_no_particle_is_an_empty_one(tmp_path, few):
    """LIGGGHTS reads no file of 0 atoms."""
    (tmp_path / "case.toml").write_text(FED.replace("FEW", few))
    ((run, case),) = lay_out(str(tmp_path), tmp_path / "run", (), False, True).items()
    assert find_needs(case)["empty_start"] and "create_box" in (run / "DEM/in.liggghts").read_text()
    rows: list[dict] = []
    launch(run, 1, rows.append)
    assert rows[0]["particles"] == 0 and 24 <= rows[-1]["particles"] <= 32


@pytest.mark.parametrize("periodic", [[], ["y"]])
def test_floor_around_an_opening(periodic):
    case = build(**DRY, particles__outlets=[OPENING], domain__periodic=periodic)
    decks, (width, depth, _) = render_decks(case), case.domain.size
    triangles = corners(decks["DEM/zloPlate-1.stl"])
    assert area(triangles) == pytest.approx(width * depth - 0.002 * 0.003, rel=1e-12)
    assert (triangles[..., 2] == 0.0).all() and triangles.min() == 0.0
    middle = triangles.mean(axis=1)
    inside = ((middle[:, :2] > [0.002, 0.001]) & (middle[:, :2] < [0.004, 0.004])).all(axis=1)
    assert not inside.any(), "no triangle lies in the opening"
    assert find_box(case, None)[0, 2] == -0.012 and "zplane 0.0\n" in decks["DEM/in.liggghts"]
    opened = decks["DEM/open-1.liggghts"]
    assert "unfix           zlo\n" in opened and "mesh n_meshes 1 meshes zloPlate\n" in opened
    wall = re.search(r"fix +xlo all (wall/gran .*) primitive", decks["DEM/in.liggghts"])
    assert f"{wall[1]} mesh" in opened, "the same contact as of the other walls"


def test_walls_open_one_after_the_other():
    port = {"face": "right", "circle": [0.003, 0.01, 0.004], "start": 0.5, "depth": 0.01}
    case = build(particles__outlets=[OPENING | {"start": 0.5}, {"face": "top"}, port])
    decks, size = render_decks(case), np.array(case.domain.size)
    assert decks["DEM/open-1.liggghts"].count("fix") == 1 and "unfix           zhi\n" in decks["DEM/open-1.liggghts"]
    later = decks["DEM/open-2.liggghts"]
    assert "wall/gran model" not in decks["DEM/open-1.liggghts"] and "n_meshes 2 meshes zloPlate xhiPlate\n" in later
    assert "unfix           zlo\n" in later and "unfix           xhi\n" in later and "zhi" not in later
    side = corners(decks["DEM/xhiPlate-2.stl"])
    assert (side[..., 0] == size[0]).all() and area(side) == pytest.approx(size[1] * size[2] - np.pi * 0.002**2)
    box = find_box(case, None)
    assert box[0].tolist() == [0.0, 0.0, -0.012] and box[1].tolist() == [
        size[0] + 0.01,
        size[1],
        size[2] + 8.0 * case.particles.diameter,
    ]


def test_walls_of_a_mesh_open_at_its_faces():
    hole = {"face": "floor", "rectangle": [[0.004, 0.004], [0.014, 0.012]], "start": 0.5}
    shape = {"domain__shape": "cylinder", "domain__size": [0.02, 0.02, 0.04], "domain__cells": [6, 6, 10]}
    case = build(**shape, gas__closed_nozzle=None, particles__outlets=[{"face": "top"}, hole])
    decks, mesh = render_decks(case), read_mesh(case)
    first, second = (corners(decks[f"DEM/surface-{number}.stl"]) for number in (1, 2))
    walls, top = area(list_walls(mesh)), mesh.find_area("outlet")
    assert area(first) == pytest.approx(walls - top, rel=1e-12) and not (first[..., 2] == 0.04).all(axis=1).any()
    assert 0.0 < area(first) - area(second) < top and "unfix           surface\n" in decks["DEM/open-2.liggghts"]
