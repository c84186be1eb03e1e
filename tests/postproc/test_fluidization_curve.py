"""The onset of fluidization on a curve whose numbers are known."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.case.bed.drag_balance import minimum_fluidization, tabulate_onset
from fbcouple.case.load import load_case
from fbcouple.postproc.figures.fluidization_curve import find_onset, fluidization_curve, list_branches
from fbcouple.postproc.report.tables import tabulate_onsets
from fbcouple.results.reader import NotDrawableError, NotMeantError, open_results

WEIGHT = 600.0


def bed(velocity: np.ndarray, linear: float, square: float) -> np.ndarray:
    """Packed up to the weight, fluidized beyond it."""
    return np.minimum(linear * velocity + square * velocity**2, WEIGHT)


@pytest.mark.parametrize(
    ("linear", "square", "expected"), [(1000.0, 0.0, 0.6), (400.0, 1000.0, 0.6), (0.0, 600.0, 1.0)]
)
def test_onset_of_known_curves(linear, square, expected):
    velocity = np.linspace(0.0, 1.5, 76)
    onset = find_onset(velocity, bed(velocity, linear, square), WEIGHT)
    assert onset is not None
    assert onset.velocity == pytest.approx(expected, rel=1e-9)
    assert (onset.linear, onset.square) == pytest.approx((linear, square), abs=1e-6)
    assert onset.error < 1e-9 and 20 < onset.rows.sum() < 76


def test_rows_of_an_overshoot_and_of_noise_move_it_little():
    rng = np.random.default_rng(3)
    velocity = np.linspace(0.0, 1.5, 151)
    pressure = bed(velocity, 400.0, 1000.0) + 5.0 * rng.standard_normal(151)
    pressure[(velocity > 0.58) & (velocity < 0.66)] = 1.15 * WEIGHT
    onset = find_onset(velocity, pressure, WEIGHT)
    assert onset is not None and onset.velocity == pytest.approx(0.6, rel=0.01)


def test_rows_of_a_bed_that_falls_back_are_none_of_a_packed_one():
    """Half of its weight is carried while it falls, at velocities above the onset and below."""
    velocity = np.linspace(1.0, 0.0, 101)
    falls = (velocity > 0.5) & (velocity < 0.9)
    pressure = np.where(falls, 0.5 * WEIGHT, bed(velocity, 1000.0, 0.0))
    pressure[velocity >= 0.9] = 0.8 * WEIGHT
    centre = np.where(velocity > 0.5, 0.012, 0.01)
    onset = find_onset(velocity, pressure, WEIGHT, centre)
    assert onset is not None and onset.velocity == pytest.approx(0.6, rel=1e-9) and onset.error < 1e-9
    misled = find_onset(velocity, pressure, WEIGHT)
    assert misled is not None and misled.velocity > 0.7


def test_no_onset_without_a_packed_bed():
    velocity = np.linspace(1.0, 1.5, 50)
    assert find_onset(velocity, np.full(50, WEIGHT), WEIGHT) is None


@pytest.mark.parametrize("rows", [12, 60, 300])
def test_the_standard_error_is_the_scatter_of_the_onset(rows):
    """Of 200 curves with noise of 2 % of the weight."""
    rng = np.random.default_rng(rows)
    velocity = np.linspace(0.0, 1.2, 2 * rows)
    noise = 0.02 * WEIGHT * rng.standard_normal((200, 2 * rows))
    found = [find_onset(velocity, bed(velocity, 600.0, 600.0) + part, WEIGHT) for part in noise]
    scatter = np.std([onset.velocity for onset in found])
    told = np.sqrt(np.mean([onset.error**2 for onset in found]))
    print(f"{rows} rows: scatter {scatter:.2g} m/s, told {told:.2g} m/s")
    assert 0.7 < told / scatter < 1.5


UP, DOWN, VOIDAGE = 0.50, 0.60, 0.42
"""U_mf of the two branches, as a bed that was packed more densely at the start has it, and the voidage then."""


@pytest.fixture
def ramped(dataset, write):
    """Results of a bed whose gas was turned up and down again; returns what opens them, with changes."""
    time = np.linspace(0.0, 8.0, 161)
    speed = 1.2 * np.minimum(time, 8.0 - time) / 4.0
    dataset = dataset.drop_vars([name for name in dataset.data_vars if "time" in dataset[name].dims])
    dataset = dataset.assign_coords(time=("time", time))
    results = open_results(write(dataset))
    weight = results.weight_per_area
    area = 0.08 * 0.015
    solids = 0.075 / 2500.0
    onset = np.where(time <= 4.0, UP, DOWN)
    dataset["inlet_velocity"] = ("time", speed)
    dataset["pressure_drop"] = ("time", np.minimum(weight * speed / onset, weight))
    dataset["solids_centre_z"] = ("time", np.full(161, 0.5 * solids / area / (1.0 - VOIDAGE)))
    dataset.attrs |= {"solids_volume": solids, "bed_section": area, "solids_mass": 0.075}

    def make(change=lambda data: data):
        return open_results(write(change(dataset)))

    return make


def tabulate(dataset):
    """With U_mf by a law, 2 m/s times the voidage."""
    voidage = np.linspace(0.3, 0.6, 31)
    return dataset.assign_coords(packed_voidage=voidage).assign(drag_onset_velocity=("packed_voidage", 2.0 * voidage))


def test_both_branches_of_a_run_with_the_law_at_the_voidage_of_the_bed(ramped):
    results = ramped(tabulate)
    branches = {branch.name: branch for branch in list_branches(results)}
    assert list(branches) == ["up", "down"]
    for name, expected in (("up", UP), ("down", DOWN)):
        assert branches[name].onset.velocity == pytest.approx(expected, rel=2e-3)
        assert branches[name].voidage == pytest.approx(VOIDAGE, rel=1e-6)
        assert branches[name].by_drag == pytest.approx(2.0 * VOIDAGE, rel=1e-6)
    rows = tabulate_onsets(results)
    assert [row["branch"] for row in rows] == ["up", "down"] and rows[0]["rows of the packed bed"] > 20
    picture = fluidization_curve(results)
    picture.canvas.draw()
    (legend,) = picture.legends
    assert "voidage 0.420: 0.84 m/s" in " ".join(text.get_text() for text in legend.get_texts())


def test_without_the_law_there_is_no_comparison(ramped):
    results = ramped()
    assert all(np.isnan(branch.by_drag) for branch in list_branches(results))
    fluidization_curve(results).canvas.draw()


def test_gas_that_does_not_change_has_no_branch(ramped):
    with pytest.raises(NotDrawableError, match="does not change"):
        list_branches(ramped(lambda data: data.assign(inlet_velocity=0.0 * data["inlet_velocity"] + 1.0)))
    with pytest.raises(NotMeantError, match="no ramp"):
        list_branches(ramped(lambda data: data.drop_vars("inlet_velocity")))


def test_u_mf_by_drag_is_tabled_for_ramps_alone():
    plain = load_case("mueller/0.9")
    assert tabulate_onset(plain).shape == (0, 2)
    ramp = ((0.0, 0.0), (1.0, 1.2))
    gas = plain.gas.model_copy(update={"inlet_velocity": None, "inlet_ramp": ramp})
    table = tabulate_onset(plain.model_copy(update={"gas": gas}))
    assert (np.diff(table[:, 1]) > 0.0).all() and table[10].tolist() == [
        pytest.approx(0.40),
        pytest.approx(minimum_fluidization(plain), rel=1e-9),
    ]
    resting = plain.model_copy(update={"gas": gas, "gravity": 0.0})
    assert tabulate_onset(resting).shape == (0, 2)
