"""What the maps show: the numbers behind the colours, the arrows and the ends of the colour bar."""

import numpy as np
import pytest

from fbcouple.postproc.figures.maps import ARROWS_ACROSS, PACKED, solids_flux, solids_fraction
from fbcouple.postproc.style import extend
from fbcouple.results.reader import open_results

GAS_FLUX = 1.165 * 1.2


def test_axes_have_the_true_proportions_of_the_bed(run):
    picture = solids_fraction(open_results(run))
    box = picture.axes[0].get_window_extent()
    assert box.height / box.width == pytest.approx(0.25 / 0.08, rel=1e-6)
    assert picture.axes[0].get_xlim() == picture.axes[0].get_ylim() == (0.0, 1.0)


def test_colours_are_the_depth_average_of_every_cell(dataset, write):
    dataset["solids_fraction"][0, :, 0] = [0.1, 0.2, 0.6]
    mesh = solids_fraction(open_results(write(dataset))).axes[0].collections[0]
    shown = np.asarray(mesh.get_array())
    assert shown.shape == (25, 8)
    assert shown[0, :2] == pytest.approx([0.3, 0.5])


@pytest.mark.parametrize(("value", "ends"), [(0.5, "neither"), (0.7, "max"), (-0.1, "min")])
def test_values_beyond_the_limits_open_the_colour_bar(dataset, write, value, ends):
    dataset["solids_fraction"][0, :, 0] = value
    mesh = solids_fraction(open_results(write(dataset))).axes[0].collections[0]
    assert mesh.get_clim() == (0.0, PACKED)
    assert mesh.colorbar.extend == ends


def test_both_ends_at_once():
    assert extend(np.array([-1.0, 2.0]), 0.0, 1.0) == "both"


def test_flux_is_normalised_and_no_value_is_beyond_the_limits(run):
    mesh, arrows = solids_flux(open_results(run)).axes[0].collections
    upward = 2.0 + 100.0 * 0.075 + 40.0 * 0.245
    largest = np.hypot(3.0, upward) / GAS_FLUX
    assert np.asarray(mesh.get_array())[-1, -1] == pytest.approx(largest)
    assert mesh.get_clim() == pytest.approx((0.0, largest))
    assert mesh.colorbar.extend == "neither"
    assert pytest.approx(np.full(arrows.U.size, 3.0 / GAS_FLUX)) == arrows.U


def test_arrows_stand_at_fixed_places_and_are_exact_for_a_linear_flux(fine_dataset, write):
    _, arrows = solids_flux(open_results(write(fine_dataset))).axes[0].collections
    across, above = arrows.XY.T
    assert np.unique(across) == pytest.approx((np.arange(ARROWS_ACROSS) + 0.5) / ARROWS_ACROSS)
    assert pytest.approx((2.0 + 8.0 * across + 10.0 * above) / GAS_FLUX, rel=1e-9) == arrows.V
