"""A bed under less and less gas until it is at rest: the velocity in the history, and U_mf on the curve."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.case.bed.adopt_inlets import adopt_inlets
from fbcouple.case.schema.sections import Case
from fbcouple.decks.render import set_up
from fbcouple.launcher.launch import launch
from fbcouple.postproc.figures.fluidization_curve import list_branches
from fbcouple.results.reader import open_results

RAMP = [[0.0, 0.8], [0.05, 0.8], [0.4, 0.1]]
CASE = {
    "title": "A column of 720 beads under a ramp of its inlet",
    "end_time": 0.4,
    "domain": {"size": [0.006, 0.006, 0.04], "cells": [1, 1, 20], "periodic": ["x", "y"]},
    "gas": {
        "density": 1.2,
        "viscosity": 1.8e-5,
        "inlets": [{"rectangle": [[0.0, 0.0], [0.006, 0.006]], "ramp": RAMP}],
    },
    "particles": {"diameter": 1e-3, "density": 2500.0, "count": 720},
    "contact": {
        "restitution": 0.9,
        "wall_restitution": 0.9,
        "friction": 0.1,
        "wall_friction": 0.1,
        "stiffness": 100.0,
    },
    "start": {},
    "exchange": {"drag": "ergun"},
    "output": {"record_every": 5e-3},
}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    run = tmp_path_factory.mktemp("ramp") / "run"
    set_up(adopt_inlets(Case.model_validate(CASE), run), run)
    launch(run, 1, lambda row: None)
    return open_results(run)


def test_the_history_has_the_velocity_of_the_ramp(results):
    time, found = (results.history(name).values for name in ("time", "inlet_velocity"))
    fine = np.linspace(0.0, 0.4, 400_001)
    flowed = np.interp(time, fine, np.cumsum(np.interp(fine, *np.transpose(RAMP))) * 1e-6)
    assert found[1:] == pytest.approx(np.diff(flowed) / np.diff(time), abs=2e-3)


def test_u_mf_is_where_ergun_has_it_at_the_voidage_of_the_bed(results):
    """One branch, no rows of the time in which the gas was held; the bed is 20 diameters high, of ten cells."""
    (branch,) = list_branches(results)
    assert branch.name == "down" and branch.onset is not None
    text = f"U_mf {branch.onset.velocity:.3f} +- {branch.onset.error:.3f} m/s, by Ergun {branch.by_drag:.3f}"
    print(f"{text} at voidage {branch.voidage:.3f}, {branch.onset.rows.sum()} rows")
    assert 0.36 < branch.voidage < 0.44 and branch.onset.rows.sum() >= 20
    assert branch.onset.velocity == pytest.approx(branch.by_drag, rel=0.1)
    assert 0.0 < branch.onset.error < 0.05 * branch.onset.velocity
