"""Particles thrown at a wall without thickness from both sides come back, in a mesh that fills a box and in a tapered
one."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.decks.set_up import lay_out
from fbcouple.geometry.foam_files import write_polymesh
from fbcouple.launcher.launch import launch

sys.path.append(str(Path(__file__).parents[1] / "geometry"))
from test_baffles import make_divided

CASE = """
title = "two particles and a plate"
end_time = 0.0025
gravity = 0.0
[domain]
shape = "file"
mesh = "polyMesh"
[gas]
density = 1e-3
viscosity = 1e-8
inlet_velocity = 0.0
[particles]
diameter = 1e-3
density = 2500.0
count = 2
positions = "two.csv"
[contact]
stiffness = 500.0
restitution = 0.9
wall_restitution = 0.9
friction = 0.0
wall_friction = 0.0
[exchange]
[output]
tracked = [1, 2]
record_every = 0.00025
"""


@pytest.mark.parametrize(("shape", "ranks"), [("box", 1), ("tapered", 2)])
def test_particles_come_back_from_a_baffle(tmp_path, shape, ranks):
    (tmp_path / "case.toml").write_text(CASE)
    rows = ["x,y,z,vx,vy,vz", "0.0185,0.011,0.025,1.0,0,0", "0.0215,0.027,0.032,-1.0,0,0"]
    (tmp_path / "two.csv").write_text("\n".join(rows))
    write_polymesh(make_divided(shape), tmp_path / "polyMesh")
    run = tmp_path / "run"
    lay_out(str(tmp_path / "case.toml"), run, (), False, forced=True)
    launch(run, ranks, lambda row: None)
    with xr.open_dataset(run / "results.nc") as results:
        places = results["tracked_position"].values[..., 0]
        speeds = results["tracked_velocity"].values[..., 0]
    assert (places[:, 0] < 0.0196).all() and (places[:, 1] > 0.0204).all(), "a tenth of a diameter into the wall"
    assert speeds[-1] == pytest.approx(np.array([-0.9, 0.9]), abs=0.03)
