"""Start-up and standard error against series whose start-up and variance of the mean are known."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from fbcouple.postproc.figures.bubbles import find_bubbling
from fbcouple.postproc.figures.spectrum import spectra_of
from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.postproc.report.tables import NOT_REACHED, tabulate_statistics
from fbcouple.postproc.statistics import find_steady_time, summarise
from fbcouple.results.reader import NotDrawableError, open_results
from fbcouple.results.steady_part import FEWEST, estimate_error, find_correlation, find_start_up


def autoregressive(rng, count, phi, start=0.0):
    """x[n] = phi x[n-1] + a normal number; stationary from the first value on but for the part `start` phi^n."""
    noise = rng.standard_normal(count)
    noise[0] /= math.sqrt(1.0 - phi**2)
    return lfilter([1.0], [1.0, -phi], noise) + start * phi ** np.arange(count)


def true_error(count, phi):
    """Standard error of the mean of a stationary AR(1) series of unit noise, with its finite-length part."""
    variance = 1.0 / (1.0 - phi**2)
    lags = np.arange(1, count)
    return math.sqrt(variance / count * (1.0 + 2.0 * np.sum((1.0 - lags / count) * phi**lags)))


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.9, 0.97])
def test_standard_error_of_a_correlated_series(phi):
    """Mean over 200 series of 3000 values: within 10 %; as if uncorrelated it would be off by up to 8 times.

    With phi = 0.97 the 3000 values are worth 46 independent ones, and a tenth of the series get no error at all.
    """
    rng = np.random.default_rng(1)
    errors = [estimate_error(autoregressive(rng, 3000, phi)) for _ in range(200)]
    assert np.nanmean(errors) == pytest.approx(true_error(3000, phi), rel=0.1)
    assert np.isnan(errors).mean() < (0.15 if phi > 0.95 else 0.01)


def test_two_standard_errors_hold_the_true_mean_as_often_as_they_should():
    rng = np.random.default_rng(2)
    inside = [
        abs(series.mean()) < 2.0 * estimate_error(series)
        for series in (autoregressive(rng, 4000, 0.8) for _ in range(400))
    ]
    assert 0.91 < np.mean(inside) < 0.98


def test_a_series_too_short_for_its_correlation_has_no_standard_error():
    """200 values that are correlated over 66: better none than one that is far too small."""
    rng = np.random.default_rng(7)
    errors = [estimate_error(autoregressive(rng, 200, 0.97)) for _ in range(100)]
    assert np.isnan(errors).mean() > 0.9


def test_a_series_that_only_drifts_has_no_standard_error():
    assert math.isnan(estimate_error(np.linspace(0.0, 1.0, 500)))


def test_a_constant_has_none_to_speak_of():
    assert estimate_error(np.full(100, 3.0)) == 0.0


def test_start_up_ends_where_the_transient_has_died_away():
    """A step from 20 standard deviations above: MSER cuts it within a batch in at least 9 of 10 series."""
    rng = np.random.default_rng(3)
    cuts = []
    for _ in range(50):
        series = rng.standard_normal(600)
        series[:200] += 20.0
        cuts.append(find_start_up(series))
    assert np.mean([cut is not None and 200 <= cut <= 230 for cut in cuts]) >= 0.9


def test_an_exponential_start_up_is_left_out():
    """exp(-t/50) falls from 30 deviations to half of one after 205 values; what stays must not shift the mean."""
    rng = np.random.default_rng(4)
    cuts = [find_start_up(30.0 * np.exp(-np.arange(1000) / 50.0) + rng.standard_normal(1000)) for _ in range(50)]
    assert all(cut is not None and 120 <= cut <= 450 for cut in cuts)


def test_nothing_is_cut_from_a_series_that_is_steady_from_the_start():
    rng = np.random.default_rng(5)
    cuts = [find_start_up(rng.standard_normal(1000)) for _ in range(50)]
    assert np.median([500 if cut is None else cut for cut in cuts]) < 100


def test_a_series_that_drifts_to_the_end_is_never_steady():
    assert find_start_up(np.linspace(0.0, 1.0, 400)) is None


def with_history(dataset, values):
    times = 0.01 * np.arange(len(values))
    histories = [name for name in dataset if "time" in dataset[name].dims]
    fields = dataset.drop_vars([*histories, "time"])
    return fields.assign_coords(time=("time", times, {"units": "s"})).assign(
        bed_height=("time", values, {"units": "m"})
    )


def test_summary_of_a_history(dataset, write):
    rng = np.random.default_rng(6)
    values = 0.06 + 0.001 * autoregressive(rng, 2001, 0.8)
    values[:301] += 0.05
    values[0] = np.nan  # before the first step
    results = open_results(write(with_history(dataset, values)))
    found = summarise(results, "bed_height")
    assert found.start == pytest.approx(3.01, abs=0.16) and found.end == pytest.approx(20.0)
    assert found.unit == "m" and found.values == pytest.approx(1700, abs=16)
    assert abs(found.mean - 0.06) < 4.0 * found.stderr
    assert found.stderr == pytest.approx(0.001 * true_error(1700, 0.8), rel=0.3)
    assert found.deviation == pytest.approx(0.001 / math.sqrt(1 - 0.8**2), rel=0.1)
    assert find_steady_time(results) == found.start


def test_a_short_history_is_told(dataset, write):
    results = open_results(write(with_history(dataset, np.ones(FEWEST))))
    with pytest.raises(NotDrawableError, match=f"has {FEWEST - 1} rows, {FEWEST} are needed"):
        summarise(results, "bed_height")


def test_a_hole_in_a_history_is_told(dataset, write):
    values = np.ones(100)
    values[50] = np.nan
    with pytest.raises(NotDrawableError, match="not finite"):
        summarise(open_results(write(with_history(dataset, values))), "bed_height")


def pulse(rng, length, period, step=0.01):
    """A bed that pulsates with this period [s] in mean, its phase wandering, from a state that is none of its own."""
    count = round(length / step)
    phase = np.cumsum(2.0 * np.pi * step / period * (1.0 + rng.standard_normal(count)))
    return 600.0 + 100.0 * np.sin(phase) + 2.0 * rng.standard_normal(count)


@pytest.mark.parametrize("length", [0.5, 1.0, 1.5])
def test_a_few_strokes_of_a_bed_are_no_steady_part(length):
    """0.4 s a stroke: after one to four of them nobody can say that the start-up is over."""
    rng = np.random.default_rng(8)
    assert all(find_start_up(pulse(rng, length, 0.4)) is None for _ in range(20))


def test_the_start_up_of_a_bed_is_never_over_after_a_row():
    """At least five correlation times, about one stroke, even where MSER-5 would leave out nothing."""
    rng = np.random.default_rng(9)
    cuts = [find_start_up(pulse(rng, 10.0, 0.4)) for _ in range(20)]
    assert all(cut is not None and 25 <= cut <= 500 for cut in cuts)


def test_a_bed_that_still_lifts_off_is_not_steady():
    """It rises for the whole record, with the noise of its particles on it."""
    rng = np.random.default_rng(10)
    rise = 1.0 - np.exp(-np.arange(300) / 300.0)
    assert all(find_start_up(rise + 0.02 * rng.standard_normal(300)) is None for _ in range(20))


def test_a_history_that_comes_to_stand_still_is_steady_from_there():
    values = 38.5 * (1.0 - np.exp(-np.arange(400.0) / 10.0))
    cut = find_start_up(values)
    assert cut is not None and 60 <= cut <= 75, "exp(-69/10) is a thousandth"
    assert find_start_up(np.full(100, 3.0)) == 0


@pytest.mark.parametrize("phi", [0.5, 0.9, 0.97])
def test_correlation_time_of_a_series(phi):
    """phi^n is 1/e after -1/ln(phi) values."""
    series = autoregressive(np.random.default_rng(11), 200000, phi)
    assert find_correlation(series) == pytest.approx(-1.0 / math.log(phi), rel=0.2, abs=1.0)


def test_where_the_start_up_is_not_over_no_number_is_made_of_it(dataset, write):
    """A pressure of two strokes: no mean, no spectrum, no bubbles, no support of the bed, and the reason with each."""
    rng = np.random.default_rng(12)
    data = with_history(dataset, pulse(rng, 1.0, 0.4)).rename(bed_height="pressure_drop")
    data = data.assign_coords(snapshot_time=0.01 * np.arange(100)).assign(
        voidage_snapshots=(("snapshot_time", "z", "x"), np.full((100, 25, 8), 0.5))
    )
    results = open_results(write(data))
    rows, remarks = tabulate_statistics(results)
    (row,) = rows
    assert row["steady from [s]"] == NOT_REACHED and math.isnan(row["mean"]) and row["rows"] == 0
    assert "the start-up is not over at t = 0.99 s" in remarks[0]
    for wants in (find_steady_time, spectra_of, find_bubbling):
        with pytest.raises(NotDrawableError, match=r"start-up is not over at t = 0.99 s .*let the run go on"):
            wants(results)
    watched = MONITORS["pressure_drop"](results)
    assert math.isnan(watched.value) and watched.wanted == "no mean: start-up not over"


@pytest.mark.parametrize(("error", "verdict"), [(1e-12, "within"), (1e-6, "BEYOND")])
def test_heat_that_does_not_add_up_has_a_verdict(dataset, write, error, verdict):
    values = np.full(dataset.sizes["time"], 1e-13)
    values[1] = error
    case = dataset.attrs["case"] + "\n[monitors]\nheat = 1e-9\n"
    results = open_results(write(dataset.assign(heat_error=("time", values)).assign_attrs(case=case)))
    watched = MONITORS["heat_error"](results)
    assert (watched.value, watched.wanted, watched.verdict) == (error, "at most 1e-09", verdict)
