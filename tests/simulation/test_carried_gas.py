"""With virtual mass the particles carry gas along: what results tell of solids is of the particles alone, in runs of
both solvers."""

from __future__ import annotations

import numpy as np
import pytest

import fbcouple

CASE = """
title = "Beads in water"
end_time = 2e-3
[domain]
size = [0.02, 0.02, 0.02]
cells = [4, 4, 4]
[gas]
density = 1000.0
viscosity = 1e-3
inlet_velocity = 0.0
[particles]
diameter = 1e-3
density = 2500.0
count = 8
positions = "beads.csv"
{mixture}
[contact]
stiffness = 1000.0
restitution = 0.9
wall_restitution = 0.9
friction = 0.0
wall_friction = 0.0
[exchange]
drag = "schiller-naumann"
virtual_mass = true
[averages]
start = 0.0
every = 2e-4
[[output.probes]]
name = "axis"
points = [[0.0125, 0.0125, 0.0125]]
quantities = ["solids_flux", "solids_fraction", "solids_velocity"]
every = 1e-3
[output]
record_every = 1e-3
"""
PLACES = [(x, y, z) for x in (0.008, 0.013) for y in (0.008, 0.013) for z in (0.008, 0.013)]
MIXTURE = 'mixture = [[2e-3, 1500.0, 0.5]]\nfractions = "number"'


def run(tmp_path, rows, mixture=""):
    (tmp_path / "case.toml").write_text(CASE.format(mixture=mixture))
    (tmp_path / "beads.csv").write_text("\n".join(rows) + "\n")
    made = fbcouple.setup(tmp_path / "case.toml", tmp_path / "run")
    made.start(progress=False)
    return made.results()


def test_the_flux_of_a_falling_cloud_is_that_of_its_solids(tmp_path):
    data = run(tmp_path, ["x,y,z,vx,vy,vz", *(f"{x},{y},{z},0,0,-0.1" for x, y, z in PLACES)])
    mass = 2500.0 * np.pi / 6.0 * 1e-9
    assert float(data["kinetic_energy"][0]) == pytest.approx(8 * 0.5 * mass * 0.1**2, rel=1e-9)
    for name in ("solids_{}", "probe_axis_solids_{}"):
        flux, velocity = (data[name.format(word)].sel(component="z").values for word in ("flux", "velocity"))
        solids = data[name.format("fraction")].values
        there = solids > 0.0
        assert there.any() and flux[there] == pytest.approx(2500.0 * (solids * velocity)[there], rel=1e-9)


def test_heavy_beads_on_the_floor_are_carried_by_buoyancy_and_weigh_what_they_are(tmp_path):
    """At rest the gas carries what it is displaced of: the centre of mass and the weight are of the beads alone."""
    kinds = [1 + n % 2 for n in range(8)]
    places = [f"{0.0025 + 0.005 * (n % 4)},{0.005 + 0.01 * (n // 4)},{0.5e-3 * k},{k}" for n, k in enumerate(kinds)]
    data = run(tmp_path, ["x,y,z,kind", *places], MIXTURE)
    volumes = np.array([1.0, 8.0])
    masses = volumes * [2500.0, 1500.0]
    centre = masses @ [0.5e-3, 1e-3] / masses.sum()
    assert float(data["solids_centre_z"][0]) == pytest.approx(centre, rel=1e-9)
    assert float(data["gas_support"][-1]) == pytest.approx(1000.0 * volumes.sum() / masses.sum(), rel=0.02)
