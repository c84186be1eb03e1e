"""Temperatures at the start: of a file of start positions, or of another run's particles."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.case.bed.positions import start_temperatures
from fbcouple.case.load import load_case
from fbcouple.decks.set_up import lay_out
from fbcouple.errors import CaseError
from fbcouple.launcher.launch import launch
from fbcouple.paths import TEMPERATURES
from fbcouple.results.frames import read_frame

CASE = """
title = "warm particles"
end_time = 2e-3
[domain]
size = [0.01, 0.006, 0.02]
cells = [5, 3, 10]
[particles]
diameter = 1e-3
density = 2500.0
count = 3
positions = "beads.csv"
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.3
wall_friction = 0.3
stiffness = 100.0
[output]
record_every = 1e-4
particles_every = 1e-3
[checkpoint]
moment_steps = 5
[heat]
particle_temperature = 300.0
particle_specific_heat = 840.0
particle_conductivity = 50.0
contact_conduction = "batchelor-obrien"
wall_temperature = 280.0
"""
BEADS = "x,y,z,temperature\n0.002,0.003,0.0004999,310.5\n0.005,0.003,0.0004999,350.25\n0.008,0.003,0.01,400.125\n"


def write(folder, text=CASE, beads=BEADS):
    (folder / "case.toml").write_text(text)
    (folder / "beads.csv").write_text(beads)
    return folder


def last_temperatures(run):
    return read_frame(max((run / "frames").iterdir())).temperatures


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    folder = write(tmp_path_factory.mktemp("source"))
    (run,) = lay_out(str(folder), folder / "run", (), False, True)
    launch(run, 1, lambda row: None)
    return run


def test_temperatures_of_a_table(source):
    """Two touch the floor and lose heat to it, one falls."""
    assert np.loadtxt(source / TEMPERATURES).tolist() == [310.5, 350.25, 400.125]
    first = read_frame(min((source / "frames").iterdir())).temperatures
    assert first.tolist() == [310.5, 350.25, 400.125]
    cooled = 1.0 - (last_temperatures(source) - 280.0) / (first - 280.0)
    assert cooled[0] == pytest.approx(cooled[1], rel=1e-3) and cooled[0] > 1e-4 and cooled[2] == 0.0


def test_without_a_column_all_are_alike(tmp_path):
    beads = "\n".join(row.rpartition(",")[0] for row in BEADS.splitlines())
    folder = write(tmp_path, beads=beads)
    (run,) = lay_out(str(folder), folder / "run", (), False, True)
    assert not (run / TEMPERATURES).exists()


@pytest.mark.parametrize("time", ["", "start.time=1e-3"])
def test_temperatures_of_another_run(source, tmp_path, time):
    """Of its checkpoint to the last bit, of a frame in single precision."""
    text = CASE.replace('positions = "beads.csv"\n', "") + "[start]\n"
    folder = write(tmp_path, text)
    sets = (f'start.run="{source}"', *([time] if time else ()))
    ((run, case),) = lay_out(str(folder), folder / "run", sets, False, True).items()
    frames = sorted((source / "frames").iterdir())
    expected = read_frame(frames[1] if time else frames[-1]).temperatures
    found = start_temperatures(case, run)
    assert found.astype(np.float32).tolist() == expected.tolist()
    assert (found != expected).any() == (not time)


def test_a_case_without_heat_takes_none_over(source, tmp_path):
    text = CASE.replace('positions = "beads.csv"\n', "").partition("[heat]")[0] + "[start]\n"
    folder = write(tmp_path, text)
    ((run, case),) = lay_out(str(folder), folder / "run", (f'start.run="{source}"',), False, True).items()
    assert start_temperatures(case, run) is None and not (run / TEMPERATURES).exists()


@pytest.mark.parametrize(("value", "words"), [("-3.0", "temperature"), ("x", "`x` for temperature; give a number")])
def test_temperatures_that_are_none(tmp_path, value, words):
    folder = write(tmp_path, beads=BEADS.replace("310.5", value))
    with pytest.raises(CaseError) as caught:
        load_case(str(folder))
    (problem,) = caught.value.problems
    assert "particles.positions: beads.csv" in problem and words in problem


@pytest.mark.parametrize(("change", "words"), [("", "is missing"), ("300.0\n" * 3, "has been changed since set-up")])
def test_temperatures_that_were_changed_start_no_run(tmp_path, change, words):
    folder = write(tmp_path)
    (run,) = lay_out(str(folder), folder / "run", (), False, True)
    (run / TEMPERATURES).write_text(change) if change else (run / TEMPERATURES).unlink()
    with pytest.raises(CaseError) as caught:
        launch(run, 1, lambda row: None)
    assert any(TEMPERATURES in problem and words in problem for problem in caught.value.problems)
