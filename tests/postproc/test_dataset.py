"""Opening results.nc, what it says about the case, depth average and interpolation."""

import numpy as np
import pytest
import xarray as xr

from fbcouple.errors import CaseError
from fbcouple.postproc.scales import flux_scale
from fbcouple.results.depth_means import at_height, depth_average
from fbcouple.results.reader import NotDrawableError, open_results


def test_missing_results_say_what_to_do(tmp_path):
    with pytest.raises(
        CaseError, match=r"results\.nc does not exist, and .* is not a run folder\. .*\(`fbcouple setup CASE -o RUN`"
    ):
        open_results(tmp_path)


def test_a_file_that_is_not_netcdf_is_named(tmp_path):
    (tmp_path / "results.nc").write_text("no NetCDF")
    with pytest.raises(CaseError, match=r"results\.nc cannot be read as NetCDF"):
        open_results(tmp_path)


def test_results_without_the_case_are_refused(dataset, write):
    del dataset.attrs["case"]
    with pytest.raises(CaseError, match="no attribute `case`"):
        open_results(write(dataset))


@pytest.mark.parametrize("how", ["absent", "not a number"])
def test_a_run_that_has_not_begun_to_average_says_so(dataset, write, how):
    means = [name for name in dataset if "x" in dataset[name].dims]
    data = (
        dataset.drop_vars(means)
        if how == "absent"
        else dataset.assign({name: dataset[name] * np.nan for name in means})
    )
    results = open_results(write(data))
    with pytest.raises(
        NotDrawableError, match=r"averaging starts at t = 1 s .*last record is at t = 0\.02 s.*--resume"
    ):
        results.mean("solids_flux")


def test_time_stays_in_seconds(run):
    assert open_results(run).data["time"].values == pytest.approx([0.01, 0.02])


def test_scales_of_the_paper(run):
    """Table 3 of the paper: rho U_f = 1.398 kg m-2 s-1 at 1.20 m/s; a 75 g bed floats at 612.8 Pa."""
    results = open_results(run)
    assert flux_scale(results)[0] == pytest.approx(1.398)
    assert results.weight_per_area == pytest.approx(612.8, abs=0.1)
    assert results.size == (0.08, 0.015, 0.25)
    assert results.window == (1.0, 20.0)


def test_weight_from_the_count_of_particles(dataset, write):
    dataset.attrs["case"] = dataset.attrs["case"].replace("mass = 0.075", "count = 57296")
    assert open_results(write(dataset)).weight_per_area == pytest.approx(612.8, abs=0.1)


def test_weight_as_the_run_wrote_it_down(dataset, write):
    """A mixture: 60 g in 3e-5 m3."""
    dataset.attrs |= {"solids_mass": 0.06, "solids_volume": 3e-5}
    expected = (0.06 - 1.165 * 3e-5) * 9.81 / (0.08 * 0.015)
    assert open_results(write(dataset)).weight_per_area == pytest.approx(expected, rel=1e-12)


def test_weight_follows_what_comes_and_goes(dataset, write):
    """60 g at the end, of which 20 g came in between the two rows and 10 g left; the window is later than both."""
    dataset.attrs |= {"solids_mass": 0.06, "solids_volume": 2.4e-5, "averaging_start": 0.0, "averaging_end": 1.0}
    traffic = {"mass_fed": ("time", [0.01, 0.03]), "mass_removed": ("time", [0.0, 0.01])}
    results = open_results(write(dataset.assign(traffic)))
    each = np.array([0.05, 0.06]) * (1.0 - 1.165 / 2500.0) * 9.81 / (0.08 * 0.015)
    assert results.weight_history == pytest.approx(each) and results.weight_per_area == pytest.approx(each.mean())


def test_a_bed_that_drained_has_no_weight(dataset, write):
    dataset.attrs |= {"solids_mass": 0.0, "solids_volume": 0.0}
    assert open_results(write(dataset)).weight_per_area is None


def test_fluxes_stay_in_si_units_without_inlet_flow(dataset, write):
    dataset.attrs["case"] = dataset.attrs["case"].replace("inlet_velocity = 1.2", "inlet_velocity = 0.0")
    scale, symbol, unit = flux_scale(open_results(write(dataset)))
    assert (scale, symbol) == (1.0, "")
    assert unit.startswith("kg m")


def test_depth_average_is_the_mean_over_y():
    field = xr.DataArray(np.arange(6.0).reshape(1, 3, 2), dims=("z", "y", "x"))
    assert depth_average(field).values == pytest.approx(np.array([[2.0, 3.0]]))


@pytest.mark.parametrize("height", [0.1, 0.12, 0.25, 0.3, 0.6])
def test_interpolation_is_exact_for_a_linear_field_on_any_layers(height):
    z = np.array([0.1, 0.2, 0.3, 0.6])
    field = xr.DataArray(np.outer(5.0 - 7.0 * z, [1.0, 2.0]), dims=("z", "x"), coords={"z": z})
    assert at_height(field, height).values == pytest.approx((5.0 - 7.0 * height) * np.array([1.0, 2.0]), rel=1e-14)


@pytest.mark.parametrize("height", [0.09, 0.61])
def test_nothing_is_extrapolated(height):
    field = xr.DataArray([1.0, 2.0], dims="z", coords={"z": [0.1, 0.6]})
    with pytest.raises(NotDrawableError, match=r"outside the cell centres \(0\.1 to 0\.6 m\)"):
        at_height(field, height)


def test_a_hole_in_a_mean_is_counted_not_hidden(dataset, write):
    dataset["solids_flux"][2, 0, 0, :2] = np.nan
    with pytest.raises(NotDrawableError, match="2 of 1800 values are not finite"):
        open_results(write(dataset)).mean("solids_flux")


@pytest.mark.parametrize(("ramp", "flux"), [("[[0, 0.5], [1, 2.0]]", 2.33), ("[[0, 0.5], [1, 0.0]]", None)])
def test_the_gas_flux_of_a_ramp_is_that_of_the_averaging_window(dataset, write, ramp, flux):
    dataset.attrs["case"] = dataset.attrs["case"].replace("inlet_velocity = 1.2", f"inlet_ramp = {ramp}")
    found = open_results(write(dataset)).gas_flux
    assert found is None if flux is None else found == pytest.approx(flux)
