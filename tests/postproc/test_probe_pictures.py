"""Probes in figures: series of points, maps of lines, means that leave out what is not there."""

import numpy as np
import pytest

from fbcouple.postproc.figures.probes import MOST_COLUMNS, probes, thin
from fbcouple.results.reader import NotDrawableError, NotMeantError, open_results
from tests.postproc.whole_run import write_whole


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return open_results(write_whole(tmp_path_factory.mktemp("whole") / "run"))


def test_points_are_lines_and_a_line_is_a_map_with_its_mean(results):
    picture = probes(results)
    picture.canvas.draw()
    titles = [axes.get_title(loc="left") for axes in picture.axes if axes.get_title(loc="left")]
    assert titles == ["axis: solids velocity", "axis: solids fraction", "tap: pressure"]
    series = next(axes for axes in picture.axes if axes.get_title(loc="left") == "tap: pressure")
    assert [text.get_text() for text in series.get_legend().get_texts()] == ["40, 0, 10", "40, 0, 50"]
    assert series.lines[0].get_ydata().mean() == pytest.approx(500.0, abs=0.2)
    (image,) = (mesh for mesh in picture.axes[0].collections)
    values = np.ma.filled(image.get_array(), np.nan)
    assert values.shape == (11, 500) and MOST_COLUMNS >= 500
    upward = np.sin(0.02 * np.arange(1, 1001)).reshape(500, 2).mean(axis=1)
    assert values[0] == pytest.approx(upward) and np.isnan(values[-1]).all()
    assert picture.axes[2].lines[0].get_xdata()[0] == pytest.approx(upward.mean())


def test_thinned_rows_are_means_of_what_is_known():
    times = np.arange(10.0)
    values = np.column_stack([times, np.where(times < 7, np.nan, times), np.full(10, np.nan)])
    found, means = thin(times, values, 4)
    assert found.tolist() == [1.0, 4.0, 7.0, 9.0] and means[:, 0].tolist() == found.tolist()
    assert means[2:, 1].tolist() == [7.5, 9.0] and np.isnan(means[:2, 1]).all() and np.isnan(means[:, 2]).all()


def test_results_without_probes_or_without_a_sample(dataset, write, results):
    with pytest.raises(NotMeantError, match=r"no probes \(output\.probes\)"):
        probes(open_results(write(dataset)))
    none = slice(0, 0)
    empty = results.data.isel(probe_tap_time=none, probe_axis_time=none, probe_cut_time=none)
    with pytest.raises(NotDrawableError, match="no sample of its probes yet"):
        probes(type(results)(results.path, empty, results.case))


def test_a_section_of_the_voidage_is_left_to_its_own_figure(results):
    alone = {"output": {"probes": [one for one in results.case["output"]["probes"] if one["name"] == "cut"]}}
    with pytest.raises(NotMeantError, match="they are in `sections`"):
        probes(type(results)(results.path, results.data, results.case | alone))
