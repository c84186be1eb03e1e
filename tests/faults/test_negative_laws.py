"""A law that is followed far beyond its range, where drag or heat go the wrong way, ends the step in words."""

from __future__ import annotations

import re

import pytest
from small_bed import prepare

from fbcouple.decks.set_up import lay_out
from fbcouple.errors import DivergedError
from fbcouple.launcher.launch import launch

SPHERE = """
title = "a sphere of 50 mm in a storm"
end_time = 2e-3
gravity = 0.0
[domain]
size = [1.0, 1.0, 2.0]
cells = [4, 4, 8]
[particles]
diameter = 0.05
density = 2500.0
count = 1
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
stiffness = 1e5
[start]
[gas]
density = 1.2
viscosity = 1.8e-5
inlet_velocity = 150.0
[exchange]
drag = "tang"
filter_passes = 1
"""
HOT = """
[heat]
gas_temperature = 300.0
particle_temperature = 350.0
gas_specific_heat = 1005.0
gas_conductivity = 0.026
particle_specific_heat = 840.0
nusselt = "own"
nusselt_file = "nusselt.py"
"""
NUSSELT = "def nusselt(voidage, reynolds, prandtl):\n    return -7.0 if 0.999 < voidage < 0.99999 else 2.0\n"
"""Negative at a voidage between those that own laws are tried at."""
POINT = r"\([-\d.e]+, [-\d.e]+, [-\d.e]+\) m"
WHERE = rf"it acts on the particle at {POINT} in cell \(\d, \d, \d\) at {POINT} against its direction; take another law"


@pytest.mark.parametrize("scheme", ["exponential", "semi-implicit"])
def test_drag_against_the_slip(tmp_path, scheme):
    run = prepare(tmp_path, [f"exchange.scheme={scheme}"], SPHERE)
    with pytest.raises(DivergedError) as caught:
        launch(run, 1, lambda row: None)
    words = r"`tang` gives a drag coefficient of (-[\d.e+-]+) kg/s at slip ([\d.]+) m/s, Re ([\d.e+]+), voidage 0\.\d+"
    found = re.search(words + rf", which is beyond what it was made for \(exchange.drag\): {WHERE}", str(caught.value))
    assert found, caught.value
    beta, slip, reynolds = map(float, found.groups())
    assert beta < 0.0 and slip == pytest.approx(150.0, rel=0.1) and 4.5e5 < reynolds < 5.5e5


def test_heat_against_the_difference(tmp_path):
    (tmp_path / "nusselt.py").write_text(NUSSELT)
    (tmp_path / "case.toml").write_text(SPHERE + HOT)
    run = tmp_path / "run"
    lay_out(str(tmp_path), run, ["exchange.drag=schiller-naumann"], trusted=True, forced=True)
    with pytest.raises(DivergedError) as caught:
        launch(run, 1, lambda row: None, trusted=True)
    words = rf"`own` gives a Nusselt number of -7 at Re \d\.\d+e\+05, voidage 0\.999\d+, .*\(heat.nusselt\): {WHERE}"
    assert re.search(words, str(caught.value)), caught.value
