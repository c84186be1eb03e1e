"""Runs without gas: what is asked for comes when it is asked for, however seldom rows are recorded."""

from __future__ import annotations

from pathlib import Path

import pytest

from fbcouple.case.bed.feeds import find_clearing_time
from fbcouple.case.schema.sections import Case
from fbcouple.decks.set_up import lay_out
from fbcouple.launcher.launch import launch
from fbcouple.results.reader import open_results

CASE = """
title = "a feed of more particles a step than are placed at once"
end_time = 4e-3
[domain]
size = [0.04, 0.04, 0.06]
cells = [4, 4, 6]
[particles]
diameter = 1e-3
density = 2500.0
count = 0
[[particles.feeds]]
low = [0.0, 0.0, 0.03]
high = [0.04, 0.04, 0.06]
rate = 4e5
velocity = [0.0, 0.0, -0.5]
[contact]
stiffness = 100.0
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[output]
particles_every = 1e-3
[[output.probes]]
name = "middle"
points = [[0.02, 0.02, 0.04]]
quantities = ["solids_fraction"]
every = 2e-3
"""


def test_frames_and_feeds_do_not_hang_on_how_often_rows_are_recorded(tmp_path: Path):
    (tmp_path / "case.toml").write_text(CASE)
    run = tmp_path / "run"
    lay_out(str(tmp_path / "case.toml"), run, (), False, forced=True)
    launch(run, 1, lambda row: None)
    results = open_results(run).data
    assert results["particles_fed"].values[-1] == pytest.approx(4e5 * results["time"].values[-1], abs=1)
    assert results["particles_owed"].values[-1] == 0
    assert len(list((run / "frames").glob("*"))) == 5


def test_grains_below_a_tenth_of_a_millimetre_come_in(tmp_path: Path):
    """LIGGGHTS refuses templates below 1e-12 m3, 0.124 mm, unless it is given a lower limit."""
    fine = CASE.replace("1e-3\ndensity", "6e-5\ndensity").replace("rate = 4e5", "rate = 1e5")
    fine = fine.replace("0.04, 0.04, 0.06]\ncells", "0.004, 0.004, 0.006]\ncells").replace(
        "stiffness = 100", "stiffness = 10"
    )
    fine = fine.replace(
        "low = [0.0, 0.0, 0.03]\nhigh = [0.04, 0.04, 0.06]", "low = [0.0, 0.0, 0.003]\nhigh = [0.004, 0.004, 0.006]"
    )
    (tmp_path / "case.toml").write_text(
        fine.replace("[0.02, 0.02, 0.04]", "[0.002, 0.002, 0.004]").replace("4e-3", "1e-3")
    )
    run = tmp_path / "run"
    lay_out(str(tmp_path / "case.toml"), run, (), False, forced=True)
    launch(run, 1, lambda row: None)
    results = open_results(run).data
    assert results["particles_fed"].values[-1] == pytest.approx(100, abs=1)
    assert results["particles"].values[-1] == results["particles_fed"].values[-1]


@pytest.mark.parametrize(
    ("velocity", "gravity", "time"),
    [((0.0, 0.0, -2.0), 0.0, 0.5e-3), ((0.0, 0.0, 0.0), 10.0, 2e-4**0.5), ((0.0, 0.0, 0.0), 0.0, float("inf"))],
)
def test_a_feed_is_asked_again_once_its_particles_can_have_left_their_place(velocity, gravity, time):
    feed = {"low": [0, 0, 0], "high": [0.01, 0.01, 0.01], "rate": 1.0, "velocity": velocity}
    case = Case.model_validate(
        {
            "title": "feed",
            "end_time": 1.0,
            "gravity": gravity,
            "domain": {"size": [0.01, 0.01, 0.04], "cells": [2, 2, 8]},
            "particles": {"diameter": 1e-3, "density": 2500.0, "count": 0, "feeds": [feed]},
        }
    )
    assert find_clearing_time(case) == pytest.approx(time)
