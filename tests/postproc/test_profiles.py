"""Profiles of the flux against a flux that is linear in x, y and z, and the heights at which they are taken."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from fbcouple.errors import CaseError
from fbcouple.postproc.figures.heights import find_centre, format_height, list_heights
from fbcouple.postproc.figures.profiles import _format_mean, flux_profile, flux_profiles, vertical_flux
from fbcouple.results.reader import NotDrawableError, open_results
from fbcouple.results.view import View
from tests.postproc.whole_run import leave_out

GAS_FLUX = 1.165 * 1.2


def read_note(picture: Figure) -> str:
    return " ".join(picture.texts[1].get_text().split())


def test_profile_is_exact_for_a_linear_flux(run):
    """z = 23 mm lies between the layers at 15 and 25 mm; the part linear in y averages to nothing."""
    profile = vertical_flux(open_results(run), 0.023)
    x = (np.arange(8) + 0.5) * 0.01
    assert profile.position == pytest.approx(x / 0.08)
    assert profile.value == pytest.approx((2.0 + 100.0 * x + 40.0 * 0.023) / GAS_FLUX, rel=1e-12)


def test_band_is_the_interpolated_standard_error_over_the_gas_flux(run):
    profile = vertical_flux(open_results(run), 0.023)
    assert profile.stderr == pytest.approx(np.full(8, (1.0 + 10.0 * 0.023) / GAS_FLUX), rel=1e-12)


def test_profile_at_another_height(run):
    profile = vertical_flux(open_results(run), 0.125)
    assert profile.value[0] == pytest.approx((2.0 + 100.0 * 0.005 + 40.0 * 0.125) / GAS_FLUX, rel=1e-12)


def test_profile_without_standard_errors_has_no_band(dataset, write):
    assert vertical_flux(open_results(write(dataset.drop_vars("solids_flux_stderr"))), 0.023).stderr is None


def test_profile_of_a_run_whose_second_block_is_not_full_is_drawn_without_a_band(dataset, write):
    dataset["solids_flux_stderr"] = dataset["solids_flux_stderr"] * np.nan
    results = open_results(write(dataset))
    assert vertical_flux(results, 0.023).stderr is None
    picture = flux_profile(results)
    assert [text.get_text()[:9] for text in picture.axes[0].get_legend().get_texts()] == ["time mean"]
    assert "standard error not known: no band" in read_note(picture)


def test_of_several_runs_it_is_said_which_has_no_band(dataset, write):
    known = replace(open_results(write(dataset)), label="known")
    bare = dataset["solids_flux_stderr"] * np.nan
    unsure = replace(known, data=known.data.assign(solids_flux_stderr=bare), label="unsure")
    picture = flux_profiles([known, unsure])
    assert len(picture.axes[0].collections) == 1
    assert "standard error of unsure not known: no band" in read_note(picture)
    assert "not known" not in read_note(flux_profiles([known, known]))


def test_profile_counts_what_is_inside_of_a_mesh_alone(dataset, write):
    """The first of eight places lies outside: seven have a band, and their mean flux is that of x = 45 mm."""
    results = open_results(write(dataset))
    results = replace(results, data=leave_out(results.data, dataset["x"] < 0.01))
    profile = vertical_flux(results, 0.023)
    assert profile.stderr is not None and np.isfinite(profile.stderr).sum() == 7
    view = replace(results, view=View(heights=(0.023,)))
    (line,) = flux_profile(view).axes[0].get_legend().get_texts()
    mean = (2.0 + 100.0 * 0.045 + 40.0 * 0.023) / GAS_FLUX
    assert line.get_text() == f"time mean (average over $x$: {mean:+.2g})"


@pytest.mark.parametrize(("flux", "text"), [(-3.2e2, "−320"), (1234.0, "+1200"), (0.0123, "+0.012")])
def test_the_mean_of_a_profile_is_written_out(flux, text):
    assert _format_mean(np.full(5, flux)) == text


def test_without_a_word_the_height_is_that_of_the_centre_of_mass(run):
    """Solids fill the seven layers of 10 mm above the floor: their centre lies at 35 mm."""
    results = open_results(run)
    assert list_heights(results) == pytest.approx((0.035,)) and find_centre(results) == pytest.approx(0.035)
    assert format_height(0.035, results) == "$z$ = 35 mm ($z/H$ = 0.14)"
    assert "$z$ = 35 mm" in flux_profile(results).texts[1].get_text()


def test_heights_of_the_case_and_those_that_are_asked_for_come_first(dataset, write):
    dataset.attrs["case"] += "[output]\nprofile_heights = [0.023, 0.04]\n"
    results = open_results(write(dataset))
    assert list_heights(results) == (0.023, 0.04)
    labels = [text.get_text() for text in flux_profile(results).axes[0].get_legend().get_texts()]
    assert [label.partition(" (")[0] for label in labels] == ["$z$ = 23 mm", "$z$ = 40 mm"]
    asked = replace(results, view=View((0.1,)))
    assert list_heights(asked) == (0.1,)
    assert flux_profile(asked).axes[0].lines[0].get_ydata() == pytest.approx(vertical_flux(results, 0.1).value)


def test_runs_are_compared_at_the_heights_of_the_first(dataset, write):
    results = open_results(write(dataset))
    runs = [replace(results, label="one", view=View((0.05, 0.06))), replace(results, label="other")]
    panels = flux_profiles(runs).axes
    assert [axes.get_title(loc="left").partition(" (")[0] for axes in panels] == ["$z$ = 50 mm", "$z$ = 60 mm"]
    assert [line.get_label() for line in panels[0].lines[:2]] == ["one", "other"]


@pytest.mark.parametrize("given", ["7", '["a"]', "[-0.1]", "[inf]"])
def test_heights_in_results_that_are_none_are_refused(dataset, write, given):
    dataset.attrs["case"] += f"[output]\nprofile_heights = {given}\n"
    with pytest.raises(CaseError, match=r"output\.profile_heights of its case is no list of heights"):
        list_heights(open_results(write(dataset)))


def test_a_height_above_the_cells_is_not_drawn(run):
    with pytest.raises(NotDrawableError, match="outside the cell centres"):
        flux_profile(replace(open_results(run), view=View((0.9,))))
