"""A state that went wrong ends the run with exit code 4, the reason, the place and the checkpoint of before."""

from __future__ import annotations

import re

import pytest
from poisoned_worker import POISONS
from small_bed import find_differences, poison, prepare

from fbcouple.errors import DivergedError
from fbcouple.launcher.launch import launch
from fbcouple.run_folder.checkpoint import list_checkpoints

SETS = ["end_time=3e-3", "averages.start=0.0", "checkpoint.every=5e-4", "output.record_every=5e-4"]
STEP = 12
"""Here neither a row (steps 11, 14) nor a checkpoint (10, 15) is due: what is wrong is found by its limit."""
ROW, MOMENT = 14, 15
STEPS = {"nan_velocity": ROW, "overlap": ROW, "solids_volume": ROW, "gas_flux": ROW}
"""Steps of poisons that do not last, or that LIGGGHTS fixes."""
MORE = {"courant": ["monitors.courant=1.025"], "substeps": ["monitors.substeps=4"]}
"""Limits that a poison breaks before the run is over."""
FAST = ("nan_drag", "outside")
POINT = r"\([-\d.e]+, [-\d.e]+, [-\d.e]+\) m"
CELL = rf"cell \(\d+, \d+, \d+\) at {POINT}"
WORDS = {
    "nan_velocity": rf"the gas velocity is not finite: first of 1 of a rank is {CELL}",
    "nan_drag": rf"the drag is not finite: first of 1 cells of a rank is {CELL}",
    "nan_particle": r"a particle at \(nan, [-\d.e]+, [-\d.e]+\) m is outside the cells",
    "outside": rf"particle 17 at {POINT} is outside the box|particle 17, last seen at {POINT}",
    "far_outside": rf"a particle at {POINT} is outside|particle 17, last seen at {POINT} at t = ",
    "shot": rf"particle 17.* {POINT}|a particle at {POINT} is outside",
    "overlap": rf"two particles overlap by 0\.\d+ of their mean diameter, allowed 0.3: one is particle \d+ at {POINT}",
    "packed_voidage": rf"the voidage is 0.05 in {CELL}, above 0.1 is allowed",
    "negative_voidage": rf"the voidage is -0.2 in {CELL}, above 0.1 is allowed",
    "voidage_over_one": rf"the voidage is 1 \+ 0.001 in {CELL}",
    "lost_momentum": r"disagree on the momentum exchanged: .* of the impulse, allowed 1e-09",
    "solids_volume": r"the solids that the gas sees are .* of their volume off",
    "gas_flux": r"the gas flux at z = [\d.]+ m is 0\.\d+ of the inflow off",
    "courant": rf"the Courant number is 1\.\d+ times gas.max_courant, allowed 1.025; fastest gas: .* m/s in {CELL}",
    "substeps": r"a fluid step has 5 DEM steps, allowed 4",
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The run without poison."""
    run = prepare(tmp_path_factory.mktemp("whole"), SETS)
    launch(run, 1, lambda row: None)
    return run


def test_every_poison_has_its_words():
    assert set(WORDS) == set(POISONS)


@pytest.mark.parametrize(
    "name", [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in POISONS]
)
def test_what_went_wrong_ends_the_run(tmp_path, monkeypatch, whole, name):
    run = prepare(tmp_path, SETS + MORE.get(name, []))
    poison(monkeypatch, name, STEPS.get(name, STEP))
    with pytest.raises(DivergedError, match=f"(?s){WORDS[name]}") as caught:
        launch(run, 1, lambda row: None)
    print(f"{name}: {caught.value}")
    newest = list_checkpoints(run)
    assert newest and int(re.sub(r"\D", "", newest[0].name)) == 10
    monkeypatch.undo()
    launch(run, 1, lambda row: None, resume=True)
    assert find_differences(whole, run) == []


def test_no_checkpoint_is_written_of_a_broken_state(tmp_path, monkeypatch):
    """At a moment without a row: the state is looked at because it would be saved."""
    run = prepare(tmp_path, [*SETS, "output.record_every=1.0"])
    poison(monkeypatch, "overlap", MOMENT)
    with pytest.raises(DivergedError, match="two particles overlap"):
        launch(run, 1, lambda row: None)
    assert [folder.name for folder in list_checkpoints(run)] == ["step-000000000010", "step-000000000005"]


@pytest.mark.slow
def test_limit_may_be_raised_between_checkpoint_and_resume(tmp_path, monkeypatch):
    run = prepare(tmp_path, [*SETS, "monitors.courant=1.005", "end_time=4e-3"])
    poison(monkeypatch, "courant", STEP)
    with pytest.raises(DivergedError, match="Courant"):
        launch(run, 1, lambda row: None)
    case = run / "case.toml"
    case.write_text(case.read_text().replace("courant = 1.005", "courant = 250.0"))
    rows: list[dict] = []
    launch(run, 1, rows.append, resume=True)
    assert rows[-1]["time"] >= 4e-3 * (1 - 1e-9)
