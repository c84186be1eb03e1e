"""A bed that is cooled by gas and walls, on 1, 2 and 4 ranks from the same start: the same temperatures."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from fbcouple.case.load import load_case
from fbcouple.decks.render import set_up
from fbcouple.launcher.launch import launch

# 20 steps of the coarse bed; pressure and temperature are solved to rounding: what is left is the order of sums.
SETTINGS = [
    *("contact.stiffness=1000", "end_time=1.55e-3", "gas.pressure_tolerance=1e-13"),
    *("averages.start=0.0", "averages.every=1e-5", "averages.blocks=2", "output.record_every=1e-4"),
    *("heat.gas_temperature=293.15", "heat.gas_specific_heat=1010.0", "heat.prandtl=0.8"),
    *("heat.particle_temperature=363.15", "heat.particle_specific_heat=840.0", "heat.particle_conductivity=1.4"),
    *("heat.wall_temperature=293.15", "heat.walls=[{face='left',temperature=320.0,coefficient=350.0}]"),
    *("heat.bed_conduction=zehner-schlunder", "heat.gas_density=ideal"),
]


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Ranks -> results of the bed."""
    bed = tmp_path_factory.mktemp("bed") / "bed.toml"
    bed.write_text('base = "patil/c1"\nunset = ["averages.until_error", "averages.earliest_end"]\n')
    found = {}
    for ranks in (1, 2, 4):
        run = tmp_path_factory.mktemp("ranks") / f"n{ranks}"
        set_up(load_case(str(bed), SETTINGS), run)
        launch(run, ranks, lambda row: None)
        with xr.open_dataset(run / "results.nc") as data:
            found[ranks] = data.load()
    return found


@pytest.mark.parametrize("ranks", [2, 4])
@pytest.mark.parametrize("name", ["gas_temperature", "solids_temperature"])
def test_temperatures_do_not_depend_on_ranks(results, name, ranks):
    one, many = results[1][name].values, results[ranks][name].values
    scale = np.nanmax(one) - np.nanmin(one)
    difference = np.nanmax(np.abs(one - many)) / scale
    print(f"{name} on {ranks} ranks: {difference:.2e} of {scale:.3g} K")
    assert scale > 1e-3
    assert difference < 1e-9


@pytest.mark.parametrize("ranks", [2, 4])
@pytest.mark.parametrize("name", ["heat_given", "heat_by_walls", "heat_by_outlets"])
def test_flows_of_heat_do_not_depend_on_ranks(results, name, ranks):
    one, many = results[1][name].values, results[ranks][name].values
    assert np.abs(one).max() > 0.0
    assert np.abs(one - many).max() < 1e-9 * np.abs(one).max()


@pytest.mark.parametrize("ranks", [1, 2, 4])
def test_the_ledger_closes_on_any_ranks(results, ranks):
    assert results[ranks]["heat_error"].values.max() < 1e-12
    assert results[ranks]["mean_particle_temperature"].values[-1] < 363.15
