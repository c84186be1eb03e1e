"""Spectra of sines and noise whose frequency and power are known."""

import numpy as np
import pytest

from fbcouple.postproc.figures.spectrum import find_spectrum, spectra_of, spectrum
from fbcouple.results.reader import NotDrawableError, open_results
from tests.postproc.test_statistics import autoregressive


@pytest.mark.parametrize("frequency", [0.8, 2.37, 7.1])
@pytest.mark.parametrize("length", [4.0, 20.0])
def test_peak_is_at_the_frequency_of_a_sine_in_noise_on_uneven_rows(frequency, length):
    rng = np.random.default_rng(1)
    time = np.arange(0.0, length, 0.01) + rng.uniform(0.0, 2e-4, round(length / 0.01))
    found = find_spectrum(
        "p", time, 600.0 + 10.0 * np.sin(2 * np.pi * frequency * time) + rng.standard_normal(len(time))
    )
    assert found.peak == pytest.approx(frequency, abs=0.1 * found.resolution)


def test_power_adds_up_to_the_variance():
    """White noise of variance 4: the density is 4/(f_s/2) everywhere; a sine of amplitude 3 has a variance of 4.5."""
    rng = np.random.default_rng(2)
    time = np.arange(0.0, 200.0, 0.01)
    noise = find_spectrum("p", time, 2.0 * rng.standard_normal(len(time)))
    assert noise.power[noise.frequency > 1.0].mean() == pytest.approx(4.0 / 50.0, rel=0.05)
    sine = find_spectrum("p", time, 3.0 * np.sin(2 * np.pi * 2.0 * time))
    assert np.sum(sine.power) * sine.frequency[1] == pytest.approx(4.5, rel=0.01)


def test_resolution_is_one_over_the_segment():
    time = np.arange(0.0, 40.0, 0.01)
    long = find_spectrum("p", time, np.sin(time))
    assert long.resolution == pytest.approx(0.1) and long.segments == 7
    short = find_spectrum("p", time[:200], np.sin(time[:200]))
    assert short.resolution == pytest.approx(0.5) and short.segments == 1


def test_a_slow_drift_is_no_peak():
    time = np.arange(0.0, 20.0, 0.01)
    found = find_spectrum("p", time, 50.0 * time + np.sin(2 * np.pi * 3.0 * time))
    assert found.peak == pytest.approx(3.0, abs=0.05)


@pytest.mark.parametrize("count", [150, 400, 2000])
def test_noise_has_seldom_a_peak_that_stands_out(count):
    """Red and white noise, in one segment and in several."""
    rng = np.random.default_rng(4)
    for phi in (0.0, 0.9):
        series = [autoregressive(rng, count, phi) for _ in range(100)]
        found = [find_spectrum("p", 0.01 * np.arange(count), values).stands_out for values in series]
        assert np.mean(found) <= 0.05


def test_a_sine_stands_out_of_the_noise_it_is_in():
    time = np.arange(0.0, 20.0, 0.01)
    noise = autoregressive(np.random.default_rng(5), len(time), 0.9)
    assert find_spectrum("p", time, 3.0 * np.sin(2 * np.pi * 2.5 * time) + noise).stands_out


def test_the_band_holds_the_density_of_noise_as_often_as_it_should():
    rng = np.random.default_rng(6)
    spectra = [find_spectrum("p", 0.01 * np.arange(4000), rng.standard_normal(4000)) for _ in range(40)]
    true = 1.0 / 50.0
    inside = [
        (found.power[2:-1] * found.band[0] < true) & (true < found.power[2:-1] * found.band[1]) for found in spectra
    ]
    assert np.mean(inside) == pytest.approx(0.95, abs=0.015)


def test_no_more_points_are_drawn_than_the_record_tells_apart():
    time = np.arange(0.0, 2.0, 0.01)
    found = find_spectrum("p", time, np.sin(2 * np.pi * 2.5 * time))
    assert found.frequency[1] == pytest.approx(found.resolution) and found.segments == 1
    assert found.band[1] / found.band[0] > 100.0, "a single segment tells next to nothing of the height"


def test_a_short_record_is_told():
    with pytest.raises(NotDrawableError, match="10 steady rows"):
        find_spectrum("p", np.arange(10.0), np.arange(10.0))


def test_spectra_of_a_run_leave_its_start_up_out(dataset, write):
    """2.5 Hz in the pressure and 1.5 Hz in the height after a start-up of 3 s at 6 Hz."""
    time = 0.01 * np.arange(2001)
    rng = np.random.default_rng(3)
    early = np.where(time < 3.0, 300.0 * (2.0 + np.sin(2 * np.pi * 6.0 * time)), 0.0)
    pressure = 600.0 + early + 20.0 * np.sin(2 * np.pi * 2.5 * time) + rng.standard_normal(2001)
    height = 0.06 + early * 1e-4 + 2e-3 * np.sin(2 * np.pi * 1.5 * time) + 1e-4 * rng.standard_normal(2001)
    fields = dataset.drop_vars([*(name for name in dataset if "time" in dataset[name].dims), "time"])
    run = fields.assign_coords(time=time).assign(pressure_drop=("time", pressure), bed_height=("time", height))
    results = open_results(write(run))
    peaks = {found.name: found.peak for found in spectra_of(results)}
    assert peaks["pressure_drop"] == pytest.approx(2.5, abs=0.05) and peaks["bed_height"] == pytest.approx(
        1.5, abs=0.05
    )
    titles = [axes.get_title(loc="left") for axes in spectrum(results).axes]
    assert titles[0].startswith("Bed height: peak at 1.5") and titles[1].startswith("Pressure drop: peak at 2.5")
