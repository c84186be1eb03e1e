"""The gas that a run has at its inlet is the case's, or the run ends; what reaches the outlet is told."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from small_bed import BED, prepare

from fbcouple.decks.set_up import lay_out
from fbcouple.errors import DivergedError
from fbcouple.launcher.launch import launch

sys.path.append(str(Path(__file__).parents[1] / "case"))
from test_speeds import write, write_jet

SHORT = ["end_time=2e-3", "averages.start=0.0", "output.record_every=5e-4"]


def run_it(run):
    launch(run, 1, lambda row: None)
    with xr.open_dataset(run / "results.nc") as results:
        return results.load()


def test_gas_comes_in_along_the_normal_of_an_inlet_that_is_no_floor(tmp_path):
    """A column that lies on its side, its up along y: the gas flows along y, as much of it as the case says."""
    write_jet(tmp_path, lambda p: p[:, [0, 2, 1]] * [1, 1, -1] + [0, 0, 0.012])
    mesh = 'shape = "file"\nmesh = "mesh"\ninlet = "inlet"\nsize = [0.012, 0.036, 0.012]\ncells = [3, 9, 3]'
    tail = "[exchange]\n[averages]\nstart = 0.0\nevery = 1e-4\nblocks = 2\n[output]\nrecord_every = 5e-4"
    write(
        tmp_path,
        ("size = [0.012, 0.012, 0.036]\ncells = [6, 6, 18]", mesh),
        ("end_time = 0.01", "end_time = 2e-3"),
        ("count = 1500", "count = 60"),
        ("[exchange]", tail),
        ("filter_passes = 1\n", ""),
    )
    lay_out(str(tmp_path / "case.toml"), tmp_path / "run", (), False, forced=True)
    results = run_it(tmp_path / "run")
    assert float(results["gas_inflow_error"].max()) < 1e-12
    assert float(results["gas_flux_error"][1:].max()) < 1e-6
    flux = (results["gas_flux"] * results["cell_volume"]).sum("cell") / 0.036
    assert flux.values[1] == pytest.approx(0.5 * 0.012**2 / 9, rel=0.05)
    assert abs(flux.values[[0, 2]]).max() < 0.05 * flux.values[1]


def test_a_run_whose_inlet_is_not_the_cases_ends(tmp_path):
    run = prepare(tmp_path, SHORT)
    deck = run / "CFD/0/U"
    deck.write_text(deck.read_text().replace("inletVelocity   uniform (0 0 1.2)", "inletVelocity uniform (0 0 1.1999)"))
    words = r"by the inlet at 1\.1999 m/s over its area and the case asks for 1\.2 m/s: 8\.33e-05 .*monitors\.inflow"
    with pytest.raises(DivergedError, match=words):
        launch(run, 1, lambda row: None, trusted=True)


def test_under_a_lid_the_gas_that_is_lost_is_told_of_all_of_it(tmp_path):
    results = run_it(prepare(tmp_path, [*SHORT, "gas.inlet_velocity=0.0", "gas.top=closed", "start.spacing=1.2"]))
    assert float(results["gas_mass_error"].max()) < 1e-12 and float(results["gas_inflow_error"].max()) == 0.0
    assert "particles_at_outlet" not in results


def test_particles_at_the_outlet_are_counted_and_told(tmp_path):
    """Nothing leaves: a wind of three times their fall carries light particles up, and they stay below the outlet."""
    light = ["particles.density=20.0", "particles.count=30", "gas.inlet_velocity=3.0", "end_time=0.02"]
    sets = [*light, "averages.start=0.0", "output.record_every=2e-3", "output.tracked=[1]", "contact.stiffness=10.0"]
    results = run_it(prepare(tmp_path, sets))
    at_outlet = results["particles_at_outlet"].values
    assert at_outlet[0] == 0 and at_outlet[-1] > 0 and (results["particles"] == 30).all()
    assert float(results["tracked_position"].max()) < 0.02


ACROSS = [
    "gas.inlets=[{face='left', rectangle=[[0.001, 0.007], [0.005, 0.013]], velocity=1.0}, "
    "{face='right', rectangle=[[0.001, 0.007], [0.005, 0.013]], ramp=[[0.0, -1.0]]}]",
    *("heat.gas_temperature=400.0", "heat.gas_specific_heat=1010.0", "heat.prandtl=0.7"),
    *("heat.particle_temperature=300.0", "heat.particle_specific_heat=840.0"),
]


def test_gas_that_is_sucked_off_as_fast_as_it_comes_in_is_held_to_the_case(tmp_path):
    """From the left to the right, none of it in sum: it comes in warm, and leaves colder through the bed."""
    results = run_it(prepare(tmp_path, [*SHORT, *ACROSS], BED.replace("inlet_velocity = 1.2\n", "")))
    assert results.attrs["complete"] and float(results["gas_inflow_error"].max()) < 1e-12
    assert float(results["gas_mass_error"].max()) < 1e-6
    carried = 1.165 * 1010.0 * 1.0 * 2.4e-5  # W for each K
    cooling = float(results["heat_by_inlets"][-1]) / carried
    assert 1.0 < cooling < 100.0, "what leaves is colder than 400 K, and no colder than the bed"


@pytest.mark.slow
def test_the_ramp_of_many_rows_runs(tmp_path):
    """More rows than fit into a line of OpenFOAM; the gas of each recorded step is the table's at its end."""
    times = np.linspace(0.0, 2e-3, 400)
    rows = np.column_stack([times, 1.0 + 0.2 * np.sin(9e3 * times)]).tolist()
    text = BED.replace("inlet_velocity = 1.2", f"inlet_ramp = {rows}")
    results = run_it(prepare(tmp_path, SHORT, text))
    assert float(results["gas_inflow_error"].max()) < 1e-9 and int(results.attrs["complete"])
