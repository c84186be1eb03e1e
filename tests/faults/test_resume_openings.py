"""A run whose particles leave by patches of a mesh goes on bit for bit, between one opening and the next."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from small_bed import find_differences

from fbcouple.decks.set_up import lay_out
from fbcouple.launcher.launch import launch
from fbcouple.results.reader import open_results

MESH = Path(__file__).parents[1] / "mpi/vessel_mesh.py"
CASE = """
title = "a vessel that two patches empty"
end_time = 3e-3
[domain]
shape = "file"
mesh = "vessel.msh"
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 0.5
max_courant = 0.5
max_step = 1e-4
[particles]
diameter = 1e-3
density = 2500.0
count = 300
rotation = true
[[particles.feeds]]
low = [0.008, -0.002, 0.01]
high = [0.0138, 0.002, 0.014]
rate = 5e4
velocity = [1.5, 0.2, 0.0]
[[particles.feeds]]
low = [-0.002, -0.002, 0.0001]
high = [0.002, 0.002, 0.004]
rate = 5e4
velocity = [0.0, 0.3, -1.5]
[[particles.outlets]]
patches = ["sp*"]
[[particles.outlets]]
patches = ["drain"]
start = 8e-4
[[particles.outlets]]
face = "top"
start = 2.5e-3
[contact]
restitution = 0.97
wall_restitution = 0.97
friction = 0.3
wall_friction = 0.3
tangential = "history"
stiffness = 200.0
[start]
region = [[-0.006, 0.006], [-0.006, 0.006], [0.016, 0.03]]
[exchange]
filter_passes = 1
[output]
record_every = 5e-4
[checkpoint]
moment_steps = 4
"""


def test_resumed_run_is_the_uninterrupted_one(tmp_path):
    subprocess.run([sys.executable, MESH, tmp_path / "vessel.msh"], check=True)
    (tmp_path / "case.toml").write_text(CASE)
    runs = [tmp_path / name for name in ("one", "other")]
    for run in runs:
        lay_out(str(tmp_path / "case.toml"), run, (), False, forced=True)
    launch(runs[0], 2, lambda row: None)
    launch(runs[1], 2, lambda row: None, until=1.6e-3)
    launch(runs[1], 2, lambda row: None, resume=True)
    assert find_differences(*runs) == []
    results = open_results(runs[0]).data
    assert {1.0, 2.0} <= set(results["exit_outlet"].values.tolist())
    assert float(results["exit_time"][results["exit_outlet"] == 2.0].min()) > 8e-4
    assert float(results["ledger_error"].max()) < 1e-13
