"""The flux profile of figure 13 against a flux that is linear in x, y and z."""

import numpy as np
import pytest

from fbcouple.postproc.figures.profiles import PROFILE_HEIGHT, flux_profile, vertical_flux
from fbcouple.results.reader import open_results

GAS_FLUX = 1.165 * 1.2


def test_profile_is_exact_for_a_linear_flux(run):
    """z/H = 0.092 is z = 23 mm, between the layers at 15 and 25 mm; the part linear in y averages to nothing."""
    profile = vertical_flux(open_results(run))
    x = (np.arange(8) + 0.5) * 0.01
    assert pytest.approx(0.023) == PROFILE_HEIGHT * 0.25
    assert profile.position == pytest.approx(x / 0.08)
    assert profile.value == pytest.approx((2.0 + 100.0 * x + 40.0 * 0.023) / GAS_FLUX, rel=1e-12)


def test_band_is_the_interpolated_standard_error_over_the_gas_flux(run):
    profile = vertical_flux(open_results(run))
    assert profile.stderr == pytest.approx(np.full(8, (1.0 + 10.0 * 0.023) / GAS_FLUX), rel=1e-12)


def test_profile_at_another_height(run):
    profile = vertical_flux(open_results(run), height=0.5)
    assert profile.value[0] == pytest.approx((2.0 + 100.0 * 0.005 + 40.0 * 0.125) / GAS_FLUX, rel=1e-12)


def test_profile_without_standard_errors_has_no_band(dataset, write):
    assert vertical_flux(open_results(write(dataset.drop_vars("solids_flux_stderr")))).stderr is None


def test_profile_of_a_run_whose_second_block_is_not_full_is_drawn_without_a_band(dataset, write):
    dataset["solids_flux_stderr"] = dataset["solids_flux_stderr"] * np.nan
    results = open_results(write(dataset))
    assert vertical_flux(results).stderr is None
    assert [text.get_text()[:9] for text in flux_profile(results).axes[0].get_legend().get_texts()] == ["time mean"]
