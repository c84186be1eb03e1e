"""Centres of mass of the species of a mixture, in the history of a run with LIGGGHTS, on any number of ranks."""

from __future__ import annotations

import numpy as np
import pytest

import fbcouple

CASE = """
title = "Three heights of two species"
end_time = 2e-4
gravity = 0.0
[domain]
size = [0.02, 0.02, 0.02]
cells = [2, 2, 2]
[particles]
diameter = 1e-3
density = 2500.0
count = 4
positions = "beads.csv"
{mixture}
[contact]
stiffness = 1000.0
restitution = 0.9
wall_restitution = 0.9
friction = 0.0
wall_friction = 0.0
[output]
record_every = 1e-4
"""
MIXTURE = 'mixture = [[2e-3, 1000.0, 0.5]]\nfractions = "number"'
BEADS = """x,y,z,vx,vy,vz,kind
0.005,0.01,0.004,0,0,1.0,1
0.015,0.01,0.008,0,0,1.0,1
0.005,0.01,0.012,0,0,0.0,2
0.015,0.01,0.016,0,0,-2.0,2
"""


def run(tmp_path, mixture, ranks):
    (tmp_path / "case.toml").write_text(CASE.format(mixture=mixture))
    beads = BEADS if mixture else "\n".join(line.rpartition(",")[0] for line in BEADS.splitlines()) + "\n"
    (tmp_path / "beads.csv").write_text(beads)
    made = fbcouple.setup(tmp_path / "case.toml", tmp_path / "run")
    made.start(ranks=ranks, progress=False)
    return made.results()


@pytest.mark.parametrize("ranks", [1, 2])
def test_each_species_has_its_centre(tmp_path, ranks):
    """Free flight: species 1 at 6 mm and 1 m/s up, species 2 at 14 mm and 1 m/s down."""
    data = run(tmp_path, MIXTURE, ranks)
    assert data["species_centre_z"].dims == ("time", "species") and data["species"].values.tolist() == [1, 2]
    time = data["time"].values
    expected = np.stack([0.006 + time, 0.014 - time], axis=1)
    assert data["species_centre_z"].values == pytest.approx(expected, abs=1e-12) and len(time) >= 3
    assert data["species_centre_z"].attrs["units"] == "m"


def test_one_species_has_no_trace_of_it(tmp_path):
    data = run(tmp_path, "", 1)
    assert "species_centre_z" not in data and "species" not in data
