"""The end of the start-up, on series whose correlation and start-up are known."""

import math

import numpy as np
import pytest

from fbcouple.results.start_up import FORGOTTEN, LATEST, average_rows, find_start, measure_drift

TAU = 8.0
BLOCKS = 30


def make_series(rng, length, cells, mean=1.0):
    """AR(1) series (length, cells) of variance 1 with a correlation time of TAU values."""
    decay = np.exp(-1.0 / TAU)
    noise = rng.standard_normal((length, cells))
    noise[1:] *= np.sqrt(1.0 - decay**2)
    for n in range(1, length):
        noise[n] += decay * noise[n - 1]
    return mean + noise


def cut(series, blocks=BLOCKS):
    length = len(series) // blocks
    return series[: blocks * length].reshape(blocks, length, -1).mean(axis=1)


def make_map(rng, length, size=0.0, dying=1.0, cells=60):
    """A series (length, cells) that begins by `size` deviations off, which die in `dying` correlation times; the sign
    is another from cell to cell."""
    off = size * np.exp(-np.arange(length) / (dying * TAU))[:, None]
    return make_series(rng, length, cells) + off * rng.choice([-1.0, 1.0], cells)


@pytest.mark.parametrize("times", [40, 90, 300])
def test_the_drift_of_a_steady_map_is_one(times):
    rng = np.random.default_rng(1)
    found = [measure_drift(cut(make_map(rng, int(times * TAU)))) for _ in range(40)]
    drifts, lengths = np.array(found).T
    print(f"{times} correlation times: drift {drifts.mean():.3f} +- {drifts.std():.3f}, seen as {lengths.mean():.0f}")
    assert drifts.mean() == pytest.approx(1.0, abs=0.08)
    assert np.median(lengths) == pytest.approx(times, rel=0.15)


def test_a_bias_as_large_as_the_error_makes_a_drift_of_two():
    """Of 90 correlation times the standard error of the mean is sqrt(2/90); the first half is off by twice that."""
    rng = np.random.default_rng(2)
    off = np.where(np.arange(BLOCKS) < BLOCKS // 2, 2.0 * math.sqrt(2.0 / 90.0), 0.0)[:, None]
    drifts = [measure_drift(cut(make_map(rng, int(90 * TAU))) + off)[0] for _ in range(60)]
    assert np.mean(drifts) == pytest.approx(2.0, abs=0.15)


def test_what_nothing_moves_in_is_still():
    assert measure_drift(np.full((20, 3), 0.6)) == (0.0, math.inf)
    assert measure_drift(np.zeros((20, 3))) == (0.0, math.inf)
    falling = 1.0 + 5e-4 * np.linspace(1.0, 0.0, 20)[:, None]
    assert measure_drift(falling)[0] == 0.0
    assert math.isnan(measure_drift(1.0 + 100.0 * (falling - 1.0))[0]), (
        "a fall by a twentieth is none of a steady record"
    )
    assert measure_drift(np.repeat([0.0, 1.0], 10)[:, None])[0] == math.inf


def test_of_a_record_shorter_than_the_correlation_nothing_is_told():
    rng = np.random.default_rng(3)
    drift, times = measure_drift(cut(make_map(rng, int(4 * TAU))))
    assert math.isnan(drift) and times < 20.0


def look(make, times):
    """As a run looks: at 20, 22, ... 40 blocks of a series of `times` correlation times; the first look by which the
    start-up is over and how many correlation times it has seen, or the last."""
    series = make(int(times * TAU))
    length = len(series[0]) // 40
    for count in range(20, 41, 2):
        maps = [cut(values[: count * length], count) for values in series]
        start = find_start(maps[:1], maps[1:])
        if start.is_over:
            break
    return start, count * length / TAU, length / TAU


@pytest.mark.parametrize(("size", "dying"), [(0.0, 1.0), (1.0, 5.0), (3.0, 5.0), (10.0, 5.0), (10.0, 20.0)])
def test_a_start_up_that_dies_away_is_left_out(size, dying):
    """It is seen to be over where at most a third of the record is left out, and what is left of it takes the mean by
    less than its standard error away."""
    rng = np.random.default_rng(4)
    found = [look(lambda n: [make_map(rng, n, size, dying)], 400) for _ in range(20)]
    begins, ends = np.array([(start.block * length, seen) for start, seen, length in found]).T
    left = size * dying * (np.exp(-begins / dying) - np.exp(-ends / dying)) / (ends - begins)
    worst = (left / np.sqrt(2.0 / (ends - begins))).max()
    print(
        f"{size:g}, {dying:g}: begins at {np.median(begins):.0f} of {np.median(ends):.0f}, bias over error {worst:.2f}"
    )
    assert np.mean([start.is_over for start, _, _ in found]) >= 0.9 and worst < 1.0
    assert (begins >= FORGOTTEN).all() and (begins <= LATEST * ends).all()


@pytest.mark.parametrize("dying", [150.0, 1000.0])
def test_a_map_that_still_drifts_is_told_so(dying):
    """What seems to stand in no cell alone does not in all of them together."""
    rng = np.random.default_rng(5)
    found = [find_start([cut(make_map(rng, int(200 * TAU), 5.0, dying), 40)]) for _ in range(20)]
    assert np.mean([start.is_over for start in found]) <= 0.05


def test_a_ramp_is_no_steady_map_and_the_best_guess_is_the_latest():
    rng = np.random.default_rng(6)
    start = find_start([cut(make_map(rng, 2400)) + np.linspace(0.0, 5.0, BLOCKS)[:, None]])
    assert not start.is_over and start.block == int(LATEST * BLOCKS)


def test_a_map_tells_what_histories_do_not():
    """As in patil/c1: height and pressure stood, the pattern of the flow did not."""
    rng = np.random.default_rng(7)

    def make(size):
        return lambda n: [make_map(rng, n, size, 150.0), *(make_series(rng, n, 1, mean=50.0) for _ in range(3))]

    assert np.mean([look(make(0.0), 250)[0].is_over for _ in range(20)]) >= 0.8
    assert np.mean([look(make(5.0), 250)[0].is_over for _ in range(20)]) <= 0.05


def test_histories_that_drift_count_on_average_and_those_that_stand_do_not():
    rng = np.random.default_rng(8)

    def make(rise):
        rising = 20.0 + np.linspace(0.0, rise, int(300 * TAU))[:, None]
        return lambda n: [make_map(rng, n), np.full((n, 1), 60.0), make_series(rng, n, 1, mean=0.0) + rising]

    assert np.mean([look(make(0.0), 300)[0].is_over for _ in range(20)]) >= 0.8
    assert np.mean([look(make(10.0), 300)[0].is_over for _ in range(20)]) <= 0.05


def test_rows_of_a_history_are_averaged_between_edges():
    times, values = np.array([0.0, 0.1, 0.3, 0.4]), np.array([np.nan, 1.0, 4.0, 2.0])
    found = average_rows(times, values, np.array([0.0, 0.2, 0.3, 0.5]))[:, 0]
    assert found == pytest.approx([0.5 * (1.0 + 4.0), 4.0, 2.0])
    constant = average_rows(np.linspace(0.0, 1.0, 101), np.full(101, 0.1), np.linspace(0.0, 1.0, 8))
    assert (constant == 0.1).all(), "a history that stands does so to the last bit"
