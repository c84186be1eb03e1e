"""Fluid steps that runs take, and those that they are told before: slow gas whose steps the Fourier number holds."""

from __future__ import annotations

import json

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
    early, late = rows[2], rows[3]
    assert (late["time"] - early["time"]) / (late["steps"] - early["steps"]) == pytest.approx(told, rel=1e-6)
