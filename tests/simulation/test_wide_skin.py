"""A wide skin of the neighbour lists is for speed alone, however far particles stray before LIGGGHTS hands them on."""

from __future__ import annotations

from pathlib import Path

import pytest

from fbcouple.decks.set_up import lay_out
from fbcouple.launcher.launch import launch
from fbcouple.results.reader import open_results

CASE = """
title = "a particle that passes a periodic side"
end_time = 0.01
gravity = 0.0
[domain]
size = [0.02, 0.01, 0.03]
cells = [10, 5, 15]
periodic = ["x"]
[gas]
density = 1.2
viscosity = 1.8e-5
inlet_velocity = 0.1
[particles]
diameter = 1e-3
density = 2500.0
count = 2
positions = "pos.csv"
[contact]
skin = {skin}
stiffness = 300.0
restitution = 0.9
wall_restitution = 0.9
friction = 0.0
wall_friction = 0.0
[exchange]
[output]
record_every = 0.001
"""
STARTS = "x,y,z,vx,vy,vz\n0.0185,0.005,0.01,1.0,0,0\n0.005,0.005,0.02,0,0,0\n"


def test_a_skin_changes_nothing_but_time(tmp_path: Path) -> None:
    energies = []
    for skin in (0.3, 10.0):
        folder = tmp_path / f"skin-{skin:g}"
        folder.mkdir()
        (folder / "case.toml").write_text(CASE.format(skin=skin))
        (folder / "pos.csv").write_text(STARTS)
        run = folder / "run"
        lay_out(str(folder / "case.toml"), run, (), False, forced=True)
        launch(run, 1, lambda row: None)
        energies.append(open_results(run).data["kinetic_energy"].values)
    assert energies[1] == pytest.approx(energies[0], rel=1e-9)
