"""Inlets in metres that cut cells, below and beside a bed, on 1, 2 and 4 ranks over 20 coupling steps: the same."""

import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.launcher.launch import launch

sys.path.append(str(Path(__file__).parents[1] / "faults"))
from small_bed import BED, prepare
from test_resume_scenes import INLETS, SHORT_FORM

SETS = [*INLETS, "end_time=1.2e-3", "averages.start=0.0", "averages.every=1e-5", "gas.pressure_tolerance=1e-13"]
SETS += ["gas.max_step=5e-5"]
FIELDS = ["solids_fraction", "solids_flux", "voidage", "gas_velocity", "gas_flux", "pressure"]


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Ranks -> results, and the steps that a run took."""
    results = {}
    for ranks in (1, 2, 4):
        run = prepare(tmp_path_factory.mktemp("openings") / f"n{ranks}", SETS, BED.replace(SHORT_FORM, ""))
        rows = []
        launch(run, ranks, rows.append)
        with xr.open_dataset(run / "results.nc") as opened:
            results[ranks] = opened.load(), rows[-1]["steps"]
    return results


@pytest.mark.parametrize("ranks", [2, 4])
@pytest.mark.parametrize("name", FIELDS)
def test_fields_do_not_depend_on_ranks(found, ranks, name):
    one, many = (found[n][0][name].values for n in (1, ranks))
    assert np.abs(one).max() > 0 and np.abs(one - many).max() < 1e-9 * np.abs(one).max()


@pytest.mark.parametrize("ranks", [1, 2, 4])
def test_the_gas_of_the_case_comes_in_and_passes(found, ranks):
    data, steps = found[ranks]
    assert steps >= 20
    assert float(data["gas_inflow_error"].max()) < 1e-12 and float(data["gas_mass_error"].max()) < 1e-6
    assert data["gas_backflow"].values == pytest.approx(found[1][0]["gas_backflow"].values, rel=1e-9, abs=1e-12)
    parts, wanted = (found[n][0]["outlet_backflow"].values for n in (ranks, 1))
    assert parts.shape == (data.sizes["time"], 2) and parts == pytest.approx(wanted, rel=1e-9, abs=1e-12)
    whole = data["gas_backflow"].values
    assert np.all((parts.min(axis=1) <= whole + 1e-12) & (whole <= parts.max(axis=1) + 1e-12))
    assert float(data["inlet_velocity"][-1]) == pytest.approx(float(found[1][0]["inlet_velocity"][-1]), rel=1e-9)
