"""History panels and cost bars."""

import pytest

from postproc.cost import cost, stage_seconds
from postproc.dataset import open_results
from postproc.history import PANELS, history


def test_every_panel_shades_the_window_and_draws_its_variable(run):
    panels = {axes.get_ylabel(): axes for axes in history(open_results(run)).axes}
    assert len(panels) == len(PANELS) == 4
    assert panels["Bed height\n[mm]"].lines[0].get_ydata() == pytest.approx([50.0, 60.0])
    assert panels["Pressure drop\n[Pa]"].lines[1].get_ydata() == pytest.approx([612.8, 612.8], abs=0.1)
    assert panels["DEM steps\nper fluid step"].lines[0].get_ydata() == pytest.approx([7, 8])
    assert panels["Largest Courant\nnumber [–]"].lines[1].get_ydata() == pytest.approx([0.2, 0.2])
    for axes in panels.values():
        left, right = axes.patches[0].get_bbox().intervalx
        assert (left, right) == (1.0, 20.0)


def test_panels_without_a_variable_are_left_out(dataset, write):
    drawn = history(open_results(write(dataset.drop_vars(["pressure_drop", "max_courant"])))).axes
    assert len(drawn) == 2


def test_cost_is_the_sum_over_time_largest_first(run):
    assert list(stage_seconds(open_results(run)).items()) == [("gas", 4.5), ("grains", 3.0), ("map", 0.5)]


def test_bars_carry_share_and_time(run):
    axes = cost(open_results(run)).axes[0]
    assert [text.get_text() for text in axes.texts] == ["56.2 % (4.5 s)", "37.5 % (3 s)", "6.2 % (0.5 s)"]
    assert [bar.get_width() for bar in axes.patches] == pytest.approx([4.5, 3.0, 0.5])
