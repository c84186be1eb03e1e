"""Where a particle is out, and where the gas's outlet is a wall for particles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fbcouple.case.schema.sections import Case
from fbcouple.geometry.grid import Grid
from fbcouple.simulation.exits import make_exits
from fbcouple.simulation.tasks.outlet import _cut_outlet

SIZE = (0.02, 0.01, 0.03)
PORT = {"rectangle": [[0.012, 0.0], [0.02, 0.01]]}
GAS = {"density": 1.2, "viscosity": 2e-5, "inlets": [{"rectangle": [[0.0, 0.0], [0.01, 0.01]], "velocity": 1.0}]}


def make_case(outlets, gas=None):
    particles = {"diameter": 1e-3, "density": 2500.0, "count": 10, "outlets": outlets}
    domain = {"size": list(SIZE), "cells": [10, 5, 15]}
    sections = {"title": "exits", "end_time": 1.0, "domain": domain, "particles": particles}
    return Case.model_validate(sections | ({"gas": GAS | gas} if gas else {}))


@pytest.mark.parametrize(("gas", "reach"), [(None, 0.5e-3), ({"outlets": [{"face": "floor"} | PORT]}, 0.0)])
def test_a_particle_is_out_behind_the_opening_that_is_nearest(gas, reach):
    hole = {"face": "floor", "circle": [0.005, 0.005, 0.004]}
    outlets = [{"face": "floor"} | PORT, hole, {"face": "right", "depth": 4e-3}]
    exits = make_exits(make_case(outlets, gas), Grid((10, 5, 15), SIZE), Path(), None)
    just, not_yet = reach + 1e-6, reach - 1e-6
    below = [[0.015, 0.005, -just], [0.005, 0.005, -just], [0.015, 0.005, -not_yet]]
    positions = np.array([*below[:2], [0.02 + just, 0.005, 0.01], below[2]])
    distances = np.array([way.measure(positions) for way in exits])
    assert distances.argmin(axis=0)[:3].tolist() == [0, 1, 2] and (distances.min(axis=0)[:3] == 0.0).all()
    assert np.isinf(distances[:, 3]).all(), "not all of it has passed"
    assert distances[0, 1] == pytest.approx(0.007) and np.isinf(distances[0, 2])


def test_the_outlet_of_the_gas_is_a_wall_where_particles_do_not_leave():
    gas = {"outlets": [{"face": "floor"} | PORT]}
    counts = {}
    for name, outlets in {
        "all": [{"face": "floor"} | PORT],
        "half": [{"face": "floor", "rectangle": [[0.012, 0.0], [0.016, 0.01]]}],
        "elsewhere": [{"face": "left"} | {"rectangle": [[0.0, 0.0], [0.01, 0.01]]}],
    }.items():
        counts[name] = len(_cut_outlet(make_case(outlets, gas), Path()))
    assert counts == {"all": 0, "half": 40, "elsewhere": 80}
