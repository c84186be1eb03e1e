"""The fastest particle bounds the fluid step: none crosses more than a cell in it, or passes an outlet unseen."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from fbcouple.case.bed.derived import dem_step
from fbcouple.case.load import load_case
from fbcouple.decks.set_up import lay_out
from fbcouple.launcher.launch import launch
from fbcouple.results.reader import open_results

RISER = """
title = "a riser of fine grains, whose outlet is as deep as the default has it, 0.8 mm"
end_time = 0.03
[domain]
size = [0.01, 0.01, 0.05]
cells = [4, 4, 20]
[gas]
density = 1.2
viscosity = 1.8e-5
inlet_velocity = 14.0
max_courant = 6.0
[particles]
diameter = 1e-4
density = 2500.0
count = 0
[[particles.feeds]]
low = [0.0, 0.0, 0.0]
high = [0.01, 0.01, 0.01]
rate = 4e3
[[particles.outlets]]
face = "top"
[contact]
stiffness = 0.5
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
"""


def test_grains_that_the_gas_carries_out_are_seen(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(RISER)
    run = tmp_path / "run"
    lay_out(str(tmp_path / "case.toml"), run, (), False, forced=True)
    launch(run, 1, lambda row: None)
    data = open_results(run).data
    assert data["particles_removed"].values[-1] > 20 and float(data["ledger_error"].max()) < 1e-12
    mass = 2500.0 * math.pi * 1e-12 / 6.0
    speeds = np.sqrt(2.0 * data["kinetic_energy"].values / (mass * np.maximum(data["particles"].values, 1.0)))
    assert speeds.max() > math.sqrt(2.0 * 9.81 * 0.05), "they are faster than a fall through the region"


RAIN = """
title = "rain through gas at rest, which alone would let a step be 10 ms long"
end_time = 0.04
gravity = 0.0
[domain]
size = [0.02, 0.02, 0.2]
cells = [4, 4, 40]
[gas]
density = 1.2
viscosity = 1.8e-5
inlet_velocity = 0.0
[particles]
diameter = 2e-3
density = 2500.0
count = 0
[[particles.feeds]]
low = [0.0, 0.0, 0.18]
high = [0.02, 0.02, 0.2]
rate = 500.0
velocity = [0.0, 0.0, -4.0]
[contact]
stiffness = 200.0
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
[output]
record_every = 1e-3
"""


def test_no_particle_crosses_more_than_a_cell_in_a_step(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(RAIN)
    run = tmp_path / "run"
    lay_out(str(tmp_path / "case.toml"), run, (), False, forced=True)
    launch(run, 1, lambda row: None)
    case, data = load_case(str(run)), open_results(run).data
    steps = data["substeps"].values[len(data["time"]) // 2 :] * dem_step(case.contact, case.particles)
    assert 0.9 * 5e-3 / 4.0 < steps.max() <= 5e-3 / 3.9
