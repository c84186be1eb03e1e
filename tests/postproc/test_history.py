"""History panels and cost bars."""

from dataclasses import replace

import numpy as np
import pytest

from fbcouple.postproc.figures.cost import cost, stage_seconds
from fbcouple.postproc.figures.history import PANELS, history
from fbcouple.results.reader import open_results


def test_every_panel_shades_the_window_and_draws_its_variable(run):
    panels = {axes.get_ylabel(): axes for axes in history(open_results(run)).axes}
    assert len(panels) == 4 and len(PANELS) == 7, "a bed without heat has no temperatures to show"
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


def test_temperatures_of_both_phases_stand_in_one_panel(dataset, write):
    heated = dataset.assign(
        mean_particle_temperature=("time", [363.15, 360.0]), mean_gas_temperature=("time", [293.15, 341.0])
    )
    panels = {axes.get_ylabel(): axes for axes in history(open_results(write(heated))).axes}
    axes = panels["Mean temperature\n[K]"]
    assert [line.get_ydata().tolist() for line in axes.lines] == [[363.15, 360.0], [293.15, 341.0]]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["particles", "gas"]


def test_each_way_that_heat_takes_is_a_line_and_those_without_any_are_none(dataset, write):
    rows = {"heat_given": [0.0, 3.0, 4.0], "heat_by_walls": [0.0] * 3, "heat_by_inlets": [0.0, 9.0, 8.0]}
    rows |= {"heat_by_outlets": [0.0, -5.0, -4.0], "heat_by_contacts": [0.0] * 3}
    (axes,) = history(open_results(write(with_rows(dataset, [np.nan, 600.0, 610.0], **rows)))).axes[:1]
    assert axes.get_ylabel() == "Heat\n[W]"
    drawn = {line.get_label(): line.get_ydata().tolist() for line in axes.lines}
    assert drawn == {"gas to particles": [3.0, 4.0], "in by inlets": [9.0, 8.0], "in by outlets": [-5.0, -4.0]}


def test_cost_is_the_sum_over_time_largest_first(run):
    assert list(stage_seconds(open_results(run)).items()) == [("cfd", 4.5), ("dem", 3.0), ("map", 0.5)]


def test_bars_carry_share_and_time(run):
    axes = cost(open_results(run)).axes[0]
    assert [text.get_text() for text in axes.texts] == ["56.2 % (4.5 s)", "37.5 % (3 s)", "6.2 % (0.5 s)"]
    assert [bar.get_width() for bar in axes.patches] == pytest.approx([4.5, 3.0, 0.5])


def with_rows(dataset, pressure, **others):
    lean = dataset.drop_vars([*(name for name in dataset if "time" in dataset[name].dims), "time"])
    rows = {"pressure_drop": ("time", pressure)} | {name: ("time", values) for name, values in others.items()}
    return lean.assign_coords(time=0.01 * np.arange(len(pressure))).assign(rows)


def test_the_first_row_of_a_jet_does_not_set_the_axis_and_is_told(dataset, write):
    """A jet that starts takes -4500 Pa in its first step, the bed carries 600 Pa."""
    pressure = 600.0 + 20.0 * np.sin(np.arange(500.0))
    pressure[:2] = np.nan, -4500.0
    results = open_results(write(with_rows(dataset, pressure)))
    (axes,) = history(results).axes
    low, high = axes.get_ylim()
    assert 500.0 < low < 580.0 and 620.0 < high < 700.0
    (text,) = [text.get_text() for text in axes.texts if "beyond" in text.get_text()]
    assert text == "1 row beyond, farthest -4.5e+03 at 0.01 s"


def test_a_history_without_such_a_row_is_shown_whole(dataset, write):
    pressure = 600.0 + 20.0 * np.sin(np.arange(500.0))
    (axes,) = history(open_results(write(with_rows(dataset, pressure)))).axes
    assert axes.get_ylim()[0] < pressure.min() and axes.get_ylim()[1] > pressure.max()
    assert not any("beyond" in text.get_text() for text in axes.texts)


def test_the_row_before_any_step_has_no_steps_to_show(dataset, write):
    data = with_rows(dataset, [np.nan, 600.0, 610.0], substeps=[0, 7, 8], max_courant=[0.0, 0.2, 0.2])
    panels = {axes.get_ylabel(): axes for axes in history(open_results(write(data))).axes}
    assert panels["DEM steps\nper fluid step"].lines[0].get_ydata() == pytest.approx([7, 8])
    assert panels["Largest Courant\nnumber [–]"].lines[0].get_xdata() == pytest.approx([0.01, 0.02])


def test_the_velocity_at_the_inlet_is_shown_and_gas_alone_has_no_steps_of_particles(dataset, write):
    data = with_rows(dataset, [600.0, 610.0], substeps=[7, 8], inlet_velocity=[np.nan, 0.2])
    panels = {axes.get_ylabel(): axes for axes in history(open_results(write(data))).axes}
    assert panels["Superficial\nvelocity [m s$^{-1}$]"].lines[0].get_ydata().tolist() == [0.2]
    alone = replace(open_results(write(data)), case={"title": "air", "gas": {}})
    assert not any("DEM" in axes.get_ylabel() for axes in history(alone).axes)


def test_twice_the_centre_of_mass_stands_beside_the_bed_height(dataset, write):
    """The height of the top dense layer jumps where that layer thins out; the centre of mass does not."""
    data = with_rows(dataset, [1.0, 1.0], bed_height=[0.103, 0.037], solids_centre_z=[0.03, 0.029])
    axes = next(axes for axes in history(open_results(write(data))).axes if axes.get_ylabel().startswith("Bed height"))
    assert [line.get_ydata().tolist() for line in axes.lines] == [
        pytest.approx([103.0, 37.0]),
        pytest.approx([60.0, 58.0]),
    ]
    assert len(axes.get_legend().get_texts()) == 2
