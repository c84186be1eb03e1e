"""Calibration finds the costs of a step again that the times of its scenes are made with, and its scenes run."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

from fbcouple.bench.calibrate import QUIETEST, find_coefficients, list_scenes, make_scene, tabulate
from fbcouple.bench.step_costs import StepCosts
from fbcouple.bench.suite import measure_prepared
from fbcouple.bench.turns import OTHERS
from fbcouple.case.bed.derived import dem_step
from fbcouple.case.checks.registry import find_problems
from fbcouple.case.cost.coefficients import FORMAT, LAWS, SHIPPED, find_file, load_coefficients, save_coefficients
from fbcouple.case.cost.prediction import time_stages
from fbcouple.case.cost.work import count_work, name_law, share_ghosts
from fbcouple.cli.main import cli

MACHINE = replace(
    SHIPPED,
    particle=15e-9,
    neighbour=27e-9,
    rebuild=15e-9 * SHIPPED.rebuild / SHIPPED.particle,
    dem_step=3e-6,
    cell=0.4e-6,
    corrector=0.7e-6,
    fluid_step=0.6e-3,
    exchange_particle=50e-9,
    exchange_cell=120e-9,
    exchange_step=0.2e-3,
    start_up=2.5,
    rank_memory=3e8,
    contact={"hooke": 25e-9, "hooke history": 70e-9, "hertz history": 95e-9},
    subgrid={"smagorinsky": 0.1e-6, "keqn": 0.2e-6, "dynamic-lagrangian": 0.4e-6, "localized-dynamic": 0.5e-6},
    shared={"dem": 1.08, "cfd": 1.15, "exchange": 1.1},
    spread=1.3,
)
LISTS = {"later": 200.0, "hooke history": 4.0, "hertz history": 6.0}
CONTACTS = {"dilute": 0.0, "tiny": 0.0, "later": 0.2, "hooke history": 2.2, "hertz history": 2.2}
STEPS = {"fluid_steps": 50, "dem_steps": 2000}


def make_times(machine):
    """What the scenes take on a machine of which all costs are known."""
    found = {}
    for name, scene in list_scenes().items():
        case, ranks, seconds = scene.case, scene.ranks, scene.seconds
        contacts, lists = CONTACTS.get(name, 0.6), LISTS.get(name, 80.0)
        work = replace(count_work(case), contacts=contacts, is_bed=contacts > 0.0, rebuilds=lists, **STEPS)
        found[name] = StepCosts(
            ranks=ranks,
            particles=round(work.particles),
            cells=work.cells,
            seconds=seconds,
            rebuilds=lists,
            contacts=contacts * work.particles,
            phases=time_stages(work, machine, ranks, share_ghosts(case, ranks)),
            phases_left=0.0,
            setting_up=machine.start_up,
            memory=machine.rank_memory * ranks,
            spread={"dem": 1.3**2, "cfd": 1.0, "exchange": 1.0},
            **STEPS,
        )
    return found


def test_costs_are_found_again():
    found, wanted = find_coefficients(make_times(MACHINE)), MACHINE
    for name in (
        "particle",
        "neighbour",
        "dem_step",
        "cell",
        "corrector",
        "fluid_step",
        "exchange_particle",
        "exchange_cell",
    ):
        assert getattr(found, name) == pytest.approx(getattr(wanted, name), rel=1e-6), name
    assert found.exchange_step == pytest.approx(wanted.exchange_step, rel=1e-6)
    assert found.contact == pytest.approx(wanted.contact, rel=1e-6)
    assert found.subgrid == pytest.approx(wanted.subgrid, rel=1e-6)
    assert found.shared == pytest.approx(wanted.shared, rel=1e-6)
    assert (found.start_up, found.rank_memory) == (2.5, 3e8) and found.spread == pytest.approx(1.3)


def test_a_quiet_minute_is_no_certainty():
    times = {
        name: replace(costs, spread=dict.fromkeys(costs.spread, 1.0)) for name, costs in make_times(MACHINE).items()
    }
    assert find_coefficients(times).spread == QUIETEST


def test_a_cost_that_would_be_below_zero_is_none():
    """A tiny bed that took less than nothing is left leaves the others as they are."""
    times = make_times(replace(MACHINE, fluid_step=0.0))
    tiny = times["tiny"]
    times["tiny"] = replace(tiny, phases=tiny.phases | {"cfd": 0.5 * tiny.phases["cfd"]})
    found = find_coefficients(times)
    assert found.fluid_step == 0.0 and min(found.cell, found.corrector) >= 0.0
    assert found.cell + 2.0 * found.corrector == pytest.approx(1.8e-6, rel=0.3)


@pytest.mark.parametrize("name", list_scenes())
def test_scenes_are_cases_without_a_mistake(name):
    case = list_scenes()[name].case
    assert find_problems(case) == []
    if name in LAWS:
        assert name_law(case) == name


def test_steps_on_the_clock_are_those_of_the_case():
    """A scene of 60 particles: DEM steps are its time over the constant step, and something was timed in each phase."""
    case = make_scene(cells=(4, 4, 8), count=60, spacing=2.0)
    told = measure_prepared("costs", case, 1, 0.002, 0.01)
    told.pop(OTHERS, None)
    costs = StepCosts(**told)
    assert costs.dem_steps == round(costs.seconds / dem_step(case.contact, case.particles))
    assert costs.seconds == pytest.approx(0.01, rel=0.2) and costs.fluid_steps >= 6
    assert (costs.ranks, costs.particles, costs.cells) == (1, 60, 128)
    assert all(costs.phases[phase] > 0.0 for phase in ("dem", "cfd", "exchange"))
    assert 1e8 < costs.memory < 1e9 and costs.setting_up > 0.1


def test_damaged_costs_are_measured_anew(tmp_path, monkeypatch):
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path))
    find_file().write_text('{"format": 1}')
    monkeypatch.setattr("fbcouple.bench.calibrate.calibrate", lambda say: (replace(MACHINE, measured="now"), []))
    done = CliRunner().invoke(cli, ["bench", "calibrate"])
    assert done.exit_code == 0 and "It is written anew." in done.stderr, done.output
    assert load_coefficients().measured == "now"


def test_a_machine_that_was_measured_is_not_measured_again(tmp_path, monkeypatch):
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path))
    save_coefficients(replace(MACHINE, measured="this host, once"), {})
    output = CliRunner().invoke(cli, ["bench", "calibrate"]).output
    assert f"{find_file()}: the costs of this host, once; --fresh measures again" in output.replace("\n", " ")
    assert load_coefficients().contact["hooke"] == 25e-9
    assert json.loads(find_file().read_text())["format"] == FORMAT
    rows = {row["cost"]: row for row in tabulate(MACHINE)}
    assert rows["contact.hooke"]["here"] == 25e-9 and rows["rank_memory"]["unit"] == "bytes"
