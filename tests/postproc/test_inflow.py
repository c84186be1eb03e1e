"""The velocity that others are put in proportion to: never with a sign, never one that does not blow in the window."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.postproc.figures.maps import solids_flux
from fbcouple.postproc.figures.profiles import vertical_flux
from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.postproc.report.tables import tabulate_solved
from fbcouple.postproc.scales import flux_scale, format_scale, velocity_scale
from fbcouple.results.inlet_speed import find_fastest, find_mean
from fbcouple.results.reader import NotDrawableError, open_results

FALLING = [[0.0, 0.3], [0.05, 0.6], [0.25, 0.6], [0.25, 0.3], [0.3, -0.3]]


@pytest.mark.parametrize(
    ("start", "end", "fastest", "mean"),
    [
        (0.05, 0.3, 0.6, (0.2 * 0.6) / 0.25),
        (0.25, 0.3, 0.3, 0.0),
        (0.0, 0.25, 0.6, (0.05 * 0.45 + 0.2 * 0.6) / 0.25),
        (0.3, 0.4, 0.3, -0.3),
        (0.275, 0.3, 0.3, -0.15),
    ],
)
def test_fastest_and_mean_of_a_ramp_are_those_of_the_window(start, end, fastest, mean):
    """Of the jump at 0.25 s from 0.6 to 0.3 m/s only the side within the window counts."""
    gas = {"inlet_ramp": FALLING}
    assert find_fastest(gas, start, end) == pytest.approx(fastest)
    assert find_mean(gas, start, end) == pytest.approx(mean, abs=1e-12)


def test_a_constant_inflow_is_its_own_scale():
    assert find_fastest({"inlet_velocity": 1.2}, 1.0, 9.0) == find_mean({"inlet_velocity": 1.2}, 1.0, 9.0) == 1.2


def test_a_thousand_rows_of_a_sine():
    times = np.linspace(0.0, 1.0, 1001)
    gas = {"inlet_ramp": [[float(t), float(0.5 + np.sin(2 * np.pi * t))] for t in times]}
    assert find_fastest(gas, 0.0, 1.0) == pytest.approx(1.5)
    assert find_mean(gas, 0.0, 1.0) == pytest.approx(0.5) and find_mean(gas, 0.0, 0.5) == pytest.approx(
        0.5 + 2 / np.pi, rel=1e-5
    )


@pytest.fixture
def ramped(dataset, write):
    def make(ramp):
        dataset.attrs["case"] = dataset.attrs["case"].replace("inlet_velocity = 1.2", f"inlet_ramp = {ramp}")
        return open_results(write(dataset))

    return make


@pytest.mark.parametrize("last", [-0.3, 0.0, 1e-3])
def test_the_end_of_a_ramp_neither_turns_arrows_nor_blows_them_up(ramped, last):
    """Solids rise in the synthetic bed; the ramp ends below zero, at zero, or at a millimetre a second."""
    results = ramped([[0.0, 0.6], [19.0, 0.6], [20.0, last]])
    assert velocity_scale(results)[0] == pytest.approx(0.6) and flux_scale(results)[0] == pytest.approx(1.165 * 0.6)
    figure = solids_flux(results)
    arrows = figure.axes[0].collections[1]
    assert (arrows.V > 0.0).all() and vertical_flux(results, 0.023).value.min() > 0.0
    assert "fastest inflow" in figure.texts[1].get_text().replace("\n", " ")


def test_solids_that_fall_have_arrows_down_under_gas_that_flows_down(dataset, ramped):
    dataset["solids_flux"].loc[{"component": "z"}] *= -1.0
    results = ramped([[0.0, -0.5]])
    assert (solids_flux(results).axes[0].collections[1].V < 0.0).all()
    assert vertical_flux(results, 0.023).value.max() < 0.0 and results.inlet_speed == 0.5


def test_without_inflow_in_the_window_the_units_are_plain(ramped):
    results = ramped([[0.0, 0.6], [0.5, 0.0]])
    assert results.inlet_speed is None and flux_scale(results)[:2] == (1.0, "") and format_scale([results]) == ""
    assert "kg m" in solids_flux(results).axes[-1].get_ylabel()
    rows = {row["what"]: row["value"] for row in tabulate_solved(results)}
    assert rows["superficial velocity U_f [m s-1]"] == "2 rows in time, 0.6 to 0; none flows in the averaging window"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[particles]\n", "[particles]\nfeeds = [{rate = 1.0}]\n", "particles come or go"),
        (
            "[gas]\n",
            '[gas]\ninlet_section = 1.2e-3\ninlets = [{face = "left", area = 1.2e-3, velocity = 1.2}]\n',
            "above the floor",
        ),
        ("[gas]\n", '[gas]\noutlets = [{face = "left"}]\n', "below the top"),
        ("[gas]\n", '[heat]\ngas_density = "ideal"\n[gas]\n', "expands"),
    ],
)
def test_a_flow_that_is_another_one_higher_up_is_not_held_against_the_inlets(dataset, write, old, new, words):
    dataset["gas_flux"] = dataset["solids_flux"] * 0.0 + 1.2
    assert MONITORS["gas_flux"](open_results(write(dataset))).wanted == "1 within 1 %"
    text = dataset.attrs["case"]
    assert text.count(old) == 1
    dataset.attrs["case"] = text.replace(old, new)
    with pytest.raises(NotDrawableError, match=words):
        MONITORS["gas_flux"](open_results(write(dataset)))


def test_the_gas_of_a_ramp_is_held_against_its_own_mean(dataset, ramped):
    dataset["gas_flux"] = dataset["solids_flux"] * 0.0 + 0.5
    watched = MONITORS["gas_flux"](ramped([[0.0, 0.0], [1.0, 0.0], [20.0, 1.0]]))
    assert watched.value == pytest.approx(1.0) and watched.wanted == "near 1"
