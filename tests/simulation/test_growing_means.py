"""Means over a window whose end is not known: blocks that join, and what they tell."""

import numpy as np
import pytest

from fbcouple.results.block_errors import estimate_errors
from fbcouple.simulation.tasks.growing_means import GrowingMeans
from fbcouple.simulation.tasks.samplers import sample_gas


@pytest.fixture
def rng():
    return np.random.default_rng(42)


def alone(sums):
    return sums


def sample(pressure):
    return sample_gas(np.ones(len(pressure)), np.zeros((len(pressure), 3)), pressure)


def test_blocks_join_in_pairs_and_hold_every_sample(rng):
    series = rng.standard_normal((133, 6))
    means = GrowingMeans("gas", 6, 8)
    for n, pressure in enumerate(series, 1):
        means.add(sample(pressure), 0.1 * n)
        assert means.samples == n and means.full <= 16 and (n < 8 or means.full >= 8)
    assert (means.full, means.per_block) == (8, 16)
    mean, error = means.collect(True, alone)["pressure"]
    assert mean[:, 0] == pytest.approx(series.mean(axis=0), rel=1e-12)
    blocks = series[:128].reshape(8, 16, 6).mean(axis=1)[..., None]
    assert error == pytest.approx(estimate_errors(blocks), rel=1e-9)


def test_saved_means_go_on_bit_for_bit(rng):
    series = rng.standard_normal((50, 6))
    whole, first = GrowingMeans("gas", 6, 8), GrowingMeans("gas", 6, 8)
    for n, pressure in enumerate(series):
        whole.add(sample(pressure), n)
        if n == 20:
            counts, sums = first.save()
            kept = {name: rows.copy() for name, rows in sums.items()}
            first = GrowingMeans("gas", 6, 8)
            first.load(dict(counts), kept)
        first.add(sample(pressure), n)
    one, other = (means.judge("pressure", alone) for means in (whole, first))
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other, strict=True))


def test_blocks_one_after_another_are_those_of_the_window(rng):
    """The last one is open; blocks before the first of the window are not told."""
    series = rng.standard_normal((45, 6))
    means = GrowingMeans("gas", 6, 8)
    for n, pressure in enumerate(series):
        means.add(sample(pressure), 0.1 * n)
    means.first = 2
    blocks = list(means.split_window())
    assert [block.samples for block in blocks] == [4] * 9 + [1] and means.samples == 37
    assert [block.start for block in blocks] == pytest.approx([0.4 * n for n in range(2, 12)])
    assert blocks[1].rows[:, 7] == pytest.approx(series[12:16].mean(axis=0), rel=1e-12)
    assert blocks[-1].rows[:, 7] == pytest.approx(series[44], rel=1e-12)


def test_memory_does_not_grow_with_the_window():
    means = GrowingMeans("gas", 3, 8)
    before = means.save()[1]["blocks"].shape
    for n in range(1000):
        means.add(sample(np.ones(3)), n)
    assert means.save()[1]["blocks"].shape == before == (3, 17, 8)


def test_the_window_begins_where_it_is_told_to(rng):
    """Blocks of the time before stay, join with the others, and count neither for the mean nor for its error."""
    series = rng.standard_normal((150, 6))
    means = GrowingMeans("gas", 6, 8)
    for n, pressure in enumerate(series[:96]):
        means.add(sample(pressure), 0.1 * n)
    assert (means.full, means.per_block) == (12, 8) and means.is_look
    assert means.begins == pytest.approx(0.8 * np.arange(12))
    means.first = 3
    assert means.samples == 72
    mean, error = means.collect(False, alone)["pressure"]
    blocks = series[24:96].reshape(9, 8, 6).mean(axis=1)[..., None]
    assert mean[:, 0] == pytest.approx(series[24:96].mean(axis=0), rel=1e-12)
    assert error == pytest.approx(estimate_errors(blocks), rel=1e-9, nan_ok=True)
    assert means.list_blocks("pressure") == pytest.approx(series[:96].reshape(12, 8, 6).mean(axis=1), rel=1e-9)
    for n, pressure in enumerate(series[96:], 96):
        means.add(sample(pressure), 0.1 * n)
    assert (means.full, means.per_block, means.first) == (9, 16, 2), "of three old blocks, two new ones"
    assert means.begins == pytest.approx(1.6 * np.arange(10))
    assert means.collect(False, alone)["pressure"][0][:, 0] == pytest.approx(series[32:].mean(axis=0), rel=1e-12)


def test_looks_are_at_every_second_full_block_from_the_fewest_on():
    means, looks = GrowingMeans("gas", 1, 8), []
    for n in range(40):
        means.add(sample(np.ones(1)), n)
        looks += [n + 1] if means.is_look else []
    assert looks == [8, 10, 12, 14, 16, 20, 24, 28, 32, 40]
