"""Fluid steps that runs take, and those that they are told before: slow gas whose steps the Fourier number holds."""

from __future__ import annotations

import json
import math

import pytest

from fbcouple.case.bed.fluid_step import gas_step
from fbcouple.case.bed.step_limits import measure_limits
from fbcouple.case.cost.work import count_work
from fbcouple.case.load import load_case
from fbcouple.decks.set_up import lay_out
from fbcouple.geometry.cylinder import make_cylinder
from fbcouple.geometry.foam_files import write_polymesh
from fbcouple.launcher.launch import launch

CASE = """
title = "slow gas"
end_time = 1.0
[domain]
DOMAIN
[gas]
density = 1.2
viscosity = 1.8e-5
inlet_velocity = 0.02
"""
DOMAINS = {
    "box": 'size = [0.003, 0.003, 0.006]\ncells = [5, 1, 8]\nperiodic = ["x"]\n',
    "cylinder": 'size = [0.006, 0.006, 0.006]\ncells = [6, 6, 5]\nshape = "cylinder"\nelements = "prisms"\n',
    "mesh": 'shape = "file"\nmesh = "mesh"\n',
}


@pytest.mark.parametrize("name", DOMAINS)
def test_a_step_that_the_fourier_number_holds_is_as_long_as_told(tmp_path, name):
    write_polymesh(make_cylinder(0.004, 0.008, 4, 6, "tetrahedra"), tmp_path / "mesh")
    (tmp_path / "case.toml").write_text(CASE.replace("DOMAIN", DOMAINS[name]))
    case = load_case(str(tmp_path))
    told = gas_step(case, limits=measure_limits(case, tmp_path))
    sets = [f"end_time={40 * told}", f"output.record_every={5 * told}"]
    assert count_work(load_case(str(tmp_path), sets), tmp_path).fluid_steps == pytest.approx(40.0, rel=1e-9)
    lay_out(str(tmp_path / "case.toml"), tmp_path / "run", sets, False, forced=True)
    launch(tmp_path / "run", 1, lambda row: None)
    rows = [json.loads(line) for line in (tmp_path / "run/logs/run.jsonl").read_text().splitlines()]
    if name != "mesh":  # the first step of a mesh from a file is that of its sampling grid
        assert rows[1]["time"] <= rows[1]["steps"] * told * (1.0 + 1e-9), "nor is the first step longer"
    early, late = rows[2], rows[3]
    assert (late["time"] - early["time"]) / (late["steps"] - early["steps"]) == pytest.approx(told, rel=1e-6)


JET = """[[gas.inlets]]
circle = [0.004, 0.004, 0.0005]
ramp = [[0.0, 60.0], [1.0, 60.0001]]
"""


def test_a_run_with_a_jet_within_a_cell_takes_the_steps_that_its_faces_let_it(tmp_path):
    """2.9 m/s through four faces, for 60 as given: a ramp held the steps to what these would need."""
    domain = "size = [0.008, 0.008, 0.016]\ncells = [8, 8, 16]\n"
    text = CASE.replace("DOMAIN", domain).replace("inlet_velocity = 0.02\n", "max_fourier = 10.0\n" + JET)
    (tmp_path / "case.toml").write_text(text)
    case = load_case(str(tmp_path))
    told = gas_step(case, limits=measure_limits(case, tmp_path))
    assert told == pytest.approx(0.2 * 1e-3 / (60.0 * math.pi / 16.0 * 0.25), rel=1e-5)
    sets = [f"end_time={20 * told}", f"output.record_every={5 * told}"]
    lay_out(str(tmp_path / "case.toml"), tmp_path / "run", sets, False, forced=True)
    launch(tmp_path / "run", 1, lambda row: None)
    rows = [json.loads(line) for line in (tmp_path / "run/logs/run.jsonl").read_text().splitlines()]
    found = (rows[-1]["time"] - rows[0]["time"]) / rows[-1]["steps"]
    print(f"steps of {found / told:.3g} of the one told")
    assert 0.5 * told < found < 1.5 * told
