"""Scenes of a stability study, the indicators that judge them, and where explicit drag gives up."""

from __future__ import annotations

import csv
import json
import math
from functools import cache
from pathlib import Path

import pytest

from fbcouple.case.load import load_case
from fbcouple.case.preflight import require_fit
from fbcouple.case.source import find_case
from fbcouple.errors import CaseError
from fbcouple.paths import CASES
from fbcouple.study.indicators import INDICATORS, judge, read_indicators
from fbcouple.study.scenes import list_scenes
from fbcouple.study.schema import Stability
from fbcouple.study.source import format_settings, read_study
from fbcouple.study.stability import confuse, find_limits, predict, run_scenes

ROOT = Path(__file__).resolve().parents[2]

STABILITY = """
title = "beads"
base = "case.toml"
span = "particles"
[set]
gas.max_courant = 10.0
[scenes.steps]
gas.max_step = [1e-3, 2e-3]
forms = ["explicit", "exponential"]
[scenes.meshes]
domain.cells = [[1, 1, 6], [2, 2, 12]]
forms = ["exponential"]
times = 3
[scenes.box]
domain.cells = [1, 1, 3]
span = "passage"
times = 1000
forms = ["exponential"]
"""


def expand(path):
    return list_scenes(*read_study(str(path), Stability))


def test_scenes_are_every_combination_for_each_form(write):
    scenes = expand(write(text=STABILITY))
    assert [s.name for s in scenes] == [
        "steps-0.001-explicit",
        "steps-0.001-exponential",
        "steps-0.002-explicit",
        "steps-0.002-exponential",
        "meshes-1x1x6-exponential",
        "meshes-2x2x12-exponential",
        "box-exponential",
    ]
    assert scenes[1].varied == {"gas.max_step": 1e-3} and scenes[-1].varied == {}
    assert scenes[3].settings["exchange.scheme"] == "exponential"


def test_end_is_so_many_characteristic_times_and_steps(write):
    scenes = {s.name: s for s in expand(write(text=STABILITY))}
    for name, step in (("steps-0.001-explicit", 1e-3), ("steps-0.002-explicit", 2e-3)):
        assert scenes[name].settings["end_time"] > 200 * step * 0.999
    assert scenes["box-exponential"].settings["end_time"] == pytest.approx(1000 * 0.06 / 0.6)


@pytest.mark.parametrize(
    ("old", "new", "key", "fix"),
    [
        ("gas.max_step =", "gas.max_stp =", "scenes.steps.gas.max_stp", "did you mean `gas.max_step`"),
        ("times = 3", "times = -3", "scenes.meshes.times", "a number from 0"),
        ('span = "passage"', 'span = "pasage"', "scenes.box.span", "allowed are"),
        ('["explicit", "exponential"]', '["explizit"]', "scenes.steps.forms", "did you mean `explicit`"),
        ("[1e-3, 2e-3]", "[1e-3, -2e-3]", "gas.max_step", "above 0"),
        ('span = "particles"', 'span = "particle"', "span", 'did you mean "particles"'),
    ],
)
def test_mistake_names_key_and_mend(write, old, new, key, fix):
    with pytest.raises(CaseError) as caught:
        expand(write((old, new), text=STABILITY))
    assert any(key in problem and fix in problem for problem in caught.value.problems), caught.value.problems


GOOD = {"steps": 1, "time": 1e-3, "substeps": 10, "max_courant": 0.05, "momentum_error": 1e-14, "min_voidage": 0.99}
GOOD |= {"kinetic_energy": 1e-12, "solids_centre_z": 0.02, "max_overlap": 0.0, "cells_over_packed": 0}
GOOD |= {"pressure_drop": 1.0, "gas_mass_error": 1e-9}


@pytest.mark.parametrize(
    ("changes", "verdict", "indicator"),
    [
        ({}, "stable", ""),
        ({"pressure_drop": math.nan}, "unstable", "not finite"),
        ({"gas_flux_error": math.nan}, "stable", ""),
        ({"momentum_error": 5e-10}, "inaccurate", "momentum error"),
        ({"min_voidage": -0.1}, "unstable", "solids fraction"),
        ({"cells_over_packed": 2}, "inaccurate", "over-packed"),
        ({"max_overlap": 0.2}, "inaccurate", "overlap"),
        ({"max_overlap": 0.7}, "unstable", "overlap"),
        ({"max_courant": 100.0}, "unstable", "gas speed"),
        ({"kinetic_energy": 1.0}, "unstable", "kinetic energy"),
        ({"gas_mass_error": 0.01}, "inaccurate", "gas mass error"),
    ],
)
def test_each_indicator_judges(changes, verdict, indicator):
    case = load_case(str(CASES / "studies/single-particle/case.toml"))
    rows = [GOOD | {"steps": 0, "time": 0.0}, GOOD, GOOD | {"steps": 2, "time": 2e-3} | changes]
    found, why = judge(read_indicators(case, rows))
    assert found == verdict and indicator in why


def test_energy_gain_needs_a_scene_without_gas():
    case = load_case(str(CASES / "studies/single-particle/case.toml"))
    alone = case.model_copy(update={"gas": None, "exchange": None})
    rows = [{"kinetic_energy": 0.0, "solids_centre_z": 0.02}, {"kinetic_energy": 0.0, "solids_centre_z": 0.05}]
    assert math.isnan(INDICATORS["energy gained"].function(case, rows))
    assert INDICATORS["energy gained"].function(alone, rows) == pytest.approx(0.5)


def test_residual_speed_is_what_moves_long_after_a_bed_without_gas_fell():
    """504 beads of 1.309e-6 kg at 3 mm/s, sqrt(g d) = 0.099 m/s; the box is fallen through in 0.061 s."""
    case = load_case(str(CASES / "studies/stability/settled.toml"))
    energy = 0.5 * 504 * 1.309e-6 * 3e-3**2
    late = [{"time": t, "kinetic_energy": energy} for t in (0.1, 0.26, 0.27, 0.28, 0.29, 0.3)]
    residual = INDICATORS["residual speed"].function
    assert residual(case, late) == pytest.approx(3e-3 / math.sqrt(9.81e-3), rel=1e-3)
    assert judge({"residual speed": residual(case, late)})[0] == "inaccurate"
    assert math.isnan(residual(case, late[:1])), "it still falls"
    assert math.isnan(residual(load_case(str(CASES / "studies/stability/case.toml")), late)), "gas keeps a bed moving"


def test_residual_speed_of_parcels_is_over_their_own_diameter():
    sets = ["particles.coarse_graining=2.0", "contact.scale_restitution=false"]
    parcels = load_case(str(CASES / "studies/stability/settled.toml"), sets)
    late = [{"time": t, "kinetic_energy": 1e-9} for t in (0.26, 0.27, 0.28, 0.29, 0.3)]
    speed = math.sqrt(2e-9 / (63 * 8 * 1.309e-6))
    residual = INDICATORS["residual speed"].function(parcels, late)
    assert residual == pytest.approx(speed / math.sqrt(2 * 9.81e-3), rel=1e-3)


def test_mass_error_counts_only_while_gas_flows_in():
    case = load_case(str(CASES / "studies/stability/ramp.toml"))
    rows = [{"time": t, "gas_mass_error": e} for t, e in [(0.0, 0.0), (0.005, 0.5), (0.011, 0.3), (0.012, 1e-7)]]
    assert INDICATORS["gas mass error"].function(case, rows) == 1e-7


def test_confusion_and_limits():
    key = "dt/tau_g of the lattice"
    rows = [
        {"scene": "s", "form": "explicit", "predicted": p, "verdict": v, key: r}
        for p, v, r in [("fit", "stable", 0.5), ("fit", "stable", 1.6), ("unfit", "unstable", 2.5)]
    ]
    assert confuse(rows)[0] == {
        "form": "explicit", "predicted": "fit", "stable": 2, "inaccurate": 0, "unstable": 0, "unfinished": 0
    }  # fmt: skip
    (limit,) = find_limits(rows)
    assert limit["limit"] == pytest.approx(2.0) and limit["last stable"] == 1.6


def test_explicit_drag_gives_up_within_a_fifth_of_two(tmp_path):
    """A held bed at a fixed step: |1 - dt/tau_g| > 1 makes a disturbance grow."""
    study, source = read_study("explicit-limit", Stability)
    two = {"gas-stiffness": {"forms": ["explicit"], "gas": {"max_step": [8.1e-4, 1.22e-3]}}}
    rows = run_scenes(study.model_copy(update={"scenes": two}), source, tmp_path, lambda text: None)
    ratios = [row["dt/tau_g of the lattice"] for row in rows]
    assert ratios[0] == pytest.approx(1.6, rel=0.01) and ratios[1] == pytest.approx(2.4, rel=0.01)
    assert [row["verdict"] for row in rows] == ["stable", "unstable"]
    assert "gas speed" in rows[1]["indicators"]


def test_prediction_is_the_worst_number():
    case = load_case("patil/c2")
    assert predict(case)[0] in ("fit", "warn")
    explicit = load_case("patil/c2", ["exchange.scheme=explicit", "gas.max_courant=10", "gas.max_fourier=10"])
    verdict, doubts = predict(explicit)
    assert verdict == "unfit" and "fluid step/tau_g" in doubts


@cache
def list_shipped(name):
    """Every scene of a shipped study, its case, its folder, and what `check` says of it."""
    scenes = list_scenes(*read_study(name, Stability))
    cases = [(load_case(scene.base, format_settings(scene.settings)), find_case(scene.base).parent) for scene in scenes]
    return [
        (scene, case, folder, predict(case, folder)[0]) for scene, (case, folder) in zip(scenes, cases, strict=True)
    ]


@pytest.mark.parametrize("name", ["stability", "explicit-limit"])
def test_what_check_calls_unfit_is_refused(name):
    """Every shipped scene: `setup` without --force takes what is called fit or warned of, and nothing else."""
    refused = 0
    for _, case, folder, predicted in list_shipped(name):
        if predicted == "unfit":
            refused += 1
            with pytest.raises(CaseError, match="--force"):
                require_fit(case, folder=folder)
        else:
            require_fit(case, folder=folder)
    assert refused


def test_the_published_confusion_has_no_miss_and_says_what_check_says_today():
    with (ROOT / "docs/results/studies/stability/scenes.csv").open() as file:
        rows = {(row["scene"], row["varied"], row["form"]): row for row in csv.DictReader(file)}
    for scene, _, _, predicted in list_shipped("stability"):
        varied = ", ".join(f"{key} = {value}" for key, value in scene.varied.items())
        row = rows.pop((scene.group, varied, scene.form))
        assert row["predicted"] == predicted, scene.name
        assert row["verdict"] == "stable" or row["predicted"] != "fit", scene.name
        assert row["verdict"] != "unstable" or row["predicted"] == "unfit", scene.name
    assert not rows, "scenes that the study no longer has"


RESTARTED = """
title = "beads"
base = "case.toml"
span = "particles"
times = 1
restart = true
[set]
gas.max_courant = 10.0
gas.max_step = 1e-3
output.record_every = 1e-3
[scenes.goes-on]
forms = ["exponential"]
[scenes.blows-up]
gas.max_step = 1e-2
particles.density = 2.5
contact.stiffness = 0.0018
forms = ["explicit"]
"""


def test_a_scene_that_goes_on_from_its_middle_has_the_same_verdict_and_rows(write, tmp_path):
    study, source = read_study(str(write(text=RESTARTED)), Stability)
    whole, broken = run_scenes(study, source, tmp_path / "out", lambda text: None, jobs=2)
    assert (whole["verdict"], whole["restart"], whole["same rows"]) == ("stable", "stable", True)
    assert (broken["verdict"], broken["restart"]) == ("unstable", ""), "it is over before its middle"
    places = tmp_path / "out/scenes/goes-on-exponential", tmp_path / "out/restarts/goes-on-exponential"
    begun = [json.loads((place / "logs/run.jsonl").read_text().splitlines()[0])["time"] for place in places]
    assert begun == [0.0, 0.0], "the history of the first half is part of the checkpoint"
    step = min(int(place.name.split("-")[1]) for place in (places[0] / "checkpoints").glob("step-*"))
    steps = [json.loads(line)["steps"] for line in (places[0] / "logs/run.jsonl").read_text().splitlines()]
    assert 0.4 < step / steps[-1] < 0.65
    times = [(place / "results.nc").stat().st_mtime_ns for place in places]
    assert run_scenes(study, source, tmp_path / "out", lambda text: None)[0] == whole
    assert [(place / "results.nc").stat().st_mtime_ns for place in places] == times, "nothing is run again"
