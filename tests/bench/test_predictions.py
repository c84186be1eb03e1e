"""What a bed took beside what was predicted: ratios of known times, and a bed that is run."""

from __future__ import annotations

from dataclasses import replace

import pytest
from click.testing import CliRunner

from fbcouple.bench.predictions import compare
from fbcouple.bench.step_costs import StepCosts
from fbcouple.case.cost.coefficients import SHIPPED
from fbcouple.case.cost.prediction import time_stages
from fbcouple.case.cost.work import Work
from fbcouple.cli.main import cli

WORK = Work(
    seconds=10.0,
    particles=1e4,
    contacts=2.0,
    is_bed=True,
    law="hooke",
    dem_steps=400_000,
    rebuilds=40_000.0,
    turnovers=0.0,
    cells=5000,
    fluid_steps=8000.0,
    correctors=2,
    digits=4.5,
    subgrid="none",
    is_box=True,
)


def take(work, factor=1.0):
    """A tenth of `work`, on a machine `factor` times as slow as is shipped."""
    phases = time_stages(work, SHIPPED)
    return StepCosts(
        ranks=1,
        particles=round(work.particles),
        cells=work.cells,
        seconds=1.0,
        fluid_steps=round(work.fluid_steps / 10),
        dem_steps=work.dem_steps // 10,
        rebuilds=work.rebuilds / 10,
        contacts=work.contacts * work.particles,
        phases={phase: factor * value / 10 for phase, value in phases.items()},
        phases_left=0.0,
        setting_up=1.0,
        memory=3e8,
        spread={},
    )


def test_what_came_as_it_was_told_is_one():
    row = compare(WORK, take(WORK), SHIPPED)
    for name in ("found over predicted", "dem over predicted", "cfd over predicted", "over known work"):
        assert row[name] == pytest.approx(1.0), name
    assert row["predicted"] == row["found"] == pytest.approx(sum(time_stages(WORK, SHIPPED).values()) / 10)
    assert row["DEM steps over predicted"] == row["fluid steps over predicted"] == 1.0


def test_a_slow_machine_and_a_livelier_bed_are_told_apart():
    """Twice as slow: twice what was told, also of the known work. Half the contacts: less, and of the known work 1."""
    slow = compare(WORK, take(WORK, 2.0), SHIPPED)
    assert (slow["found over predicted"], slow["over known work"]) == pytest.approx((2.0, 2.0))
    lively = compare(WORK, take(replace(WORK, contacts=1.0, fluid_steps=12_000.0)), SHIPPED)
    assert lively["over known work"] == pytest.approx(1.0) and lively["dem over predicted"] < 0.85
    assert lively["fluid steps over predicted"] == pytest.approx(1.5)
    assert lively["cfd over predicted"] == pytest.approx(1.5)


BED = """
title = "small bed"
end_time = 1.0
[domain]
size = [0.01, 0.01, 0.02]
cells = [4, 4, 8]
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 1.2
[particles]
diameter = 1e-3
density = 2500.0
count = 300
[contact]
stiffness = 400.0
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
"""


def test_a_bed_is_run_and_held_against_its_prediction(tmp_path):
    (tmp_path / "bed.toml").write_text(BED)
    case, folder = str(tmp_path / "bed.toml"), tmp_path / "found"
    arguments = ["bench", "predictions", case, "--warm", "0.002", "--seconds", "0.01", "-o", str(folder)]
    result = CliRunner().invoke(cli, arguments)
    assert result.exit_code == 0, result.output
    head, row = (line.split(",") for line in (folder / "predictions.csv").read_text().splitlines())
    told = dict(zip(head, row, strict=True))
    assert told["particles"] == "300" and float(told["DEM steps over predicted"]) == pytest.approx(1.0, abs=0.01)
    assert 0.05 < float(told["found over predicted"]) < 20.0
