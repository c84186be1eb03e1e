"""What the maps show: the numbers behind the colours, the arrows and the ends of the colour bar."""

from dataclasses import replace

import numpy as np
import pytest

from fbcouple.postproc.figures.arrows import sample_arrows
from fbcouple.postproc.figures.depth import slices
from fbcouple.postproc.figures.heights import SCARCE, find_tops
from fbcouple.postproc.figures.maps import (
    ARROWS_ACROSS,
    PACKED,
    agitation,
    agitations,
    solids_flux,
    solids_fluxes,
    solids_fraction,
)
from fbcouple.postproc.style import extend
from fbcouple.results.reader import open_results
from fbcouple.results.view import View

GAS_FLUX = 1.165 * 1.2


def test_axes_have_the_true_proportions_of_the_bed(run):
    picture = solids_fraction(open_results(run))
    box = picture.axes[0].get_window_extent()
    top = picture.axes[0].get_ylim()[1]
    assert box.height / box.width == pytest.approx(top * 0.25 / 0.08, rel=1e-6)
    assert picture.axes[0].get_xlim() == (0.0, 1.0)


def test_maps_end_a_little_above_the_bed(run):
    """Solids fill 7 of 25 layers; with 15 % above them, up to the next layer, that is 9."""
    results = open_results(run)
    for make in (solids_fraction, solids_flux, slices):
        picture = make(results)
        assert picture.axes[0].get_ylim() == (0.0, 9 / 25)
        assert "up to z = 90 mm of 250 mm" in picture.texts[1].get_text().replace("\n", " ")
    full = solids_fraction(replace(results, view=View(full_height=True)))
    assert full.axes[0].get_ylim() == (0.0, 1.0) and "up to" not in full.texts[1].get_text()


def test_maps_of_runs_end_at_the_same_height(dataset, write):
    """One bed is 70 mm high and one 100 mm, which asks for 12 of 25 layers; a box twice as high shows half as much."""
    low = open_results(write(dataset))
    dataset["solids_fraction"][:10] = 0.5
    high = replace(low, data=dataset.copy(deep=True))
    tall = replace(low, data=low.data.assign_coords(z=2.0 * low.data["z"]))
    assert find_tops([low, high]) == [12 / 25, 12 / 25]
    assert find_tops([high, tall]) == [pytest.approx(18 / 25), pytest.approx(9 / 25)]


def test_what_the_colour_bar_does_not_tell_is_in_the_legend(dataset, write):
    """The edge of the bed, values above the scale, and places without particles; of each only what is there."""

    def entries(picture):
        return [text.get_text() for legend in picture.legends for text in legend.get_texts()]

    results = open_results(write(dataset))
    assert entries(solids_fraction(results)) == ["edge of the dense bed, 0.2"]
    assert entries(solids_flux(results)) == []
    dataset["solids_fraction"][0, :, 0] = 0.7
    over = replace(results, data=dataset)
    assert entries(solids_fraction(over)) == ["edge of the dense bed, 0.2", "above 0.6, the end of the scale"]
    grains = dataset.assign(agitation=(dataset["solids_fraction"] > 0) * 0.1)
    grains["agitation"] = grains["agitation"].where(dataset["solids_fraction"] > 0)
    hardly = "hardly any particles, solids fraction below 0.001"
    assert entries(agitation(replace(results, data=grains))) == [hardly]


def test_agitation_of_hardly_any_particles_is_not_shown(dataset, write):
    """A few that pass above the bed at 1e-4 are far beyond the scale of the bed, and no speckles."""
    results = open_results(write(dataset))
    some = dataset.assign(agitation=dataset["solids_fraction"] * 0.0 + 0.1)
    some["solids_fraction"][8] = 1e-4
    some["agitation"][8] = 9.0
    some["solids_fraction"][7, :, 3] = 0.5 * SCARCE
    shown = agitation(replace(results, data=some)).axes[0].collections[0].get_array()
    assert np.ma.getmaskarray(shown)[8].all() and not np.ma.getmaskarray(shown)[7, 3]
    assert float(shown.max()) == pytest.approx(0.1 / 1.44)


def test_maps_of_runs_share_the_scale_of_others(dataset, write):
    one = open_results(write(dataset.assign(agitation=dataset["solids_fraction"] * 0.0 + 0.1)))
    more = {name: 2.0 * one.data[name] for name in ("agitation", "solids_flux")}
    other = replace(one, data=one.data.assign(more))
    for draw in (agitations, solids_fluxes):
        ends = [draw(*runs).axes[0].collections[0].get_clim()[1] for runs in (([one],), ([one], [other]), ([other],))]
        assert ends[1] == ends[2] == pytest.approx(2.0 * ends[0])
        assert len(draw([one], [other]).axes) == len(draw([one]).axes)


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


def test_arrows_stand_wherever_all_around_them_is_known():
    """One unknown place, outside of a mesh, takes its own arrow and no other."""
    across, up = np.ones((5, 4)), np.full((5, 4), 2.0)
    across[0, 0] = up[0, 0] = np.nan
    _, _, sideways, upward = sample_arrows(across, up, (0.04, 0.05), 4)
    assert np.isnan(sideways[0, 0]) and np.isnan(upward[0, 0])
    assert np.isfinite(sideways).sum() == sideways.size - 1
    assert np.nanmin(sideways) == pytest.approx(1.0) == pytest.approx(np.nanmax(sideways))
    assert np.nanmin(upward) == pytest.approx(2.0) == pytest.approx(np.nanmax(upward))
