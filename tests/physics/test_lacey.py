"""Lacey's index against its limits, and the mean over ways to mark particles that are counted out."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from fbcouple.physics.mixing import find_lacey_index, number_samples


def test_segregated_is_nothing_and_alike_is_more_than_chance():
    samples = np.repeat(np.arange(10), 20)
    assert find_lacey_index(samples < 5, samples) == pytest.approx(0.0, abs=1e-15)
    alternating = np.arange(200) % 2 == 0
    assert find_lacey_index(alternating, samples) == pytest.approx(1.0 / (1.0 - 9.0 / 199.0), rel=1e-14)


def test_by_hand_with_samples_of_different_size():
    marked = np.array([1, 1, 0, 1, 0, 0, 0, 0], bool)
    samples = np.array([4, 4, 4, 4, 9, 9, 9, 2])
    # p = 3/8; s^2 = 1/2 (3/4 - 3/8)^2 + 1/2 (3/8)^2 = 9/64; s0^2 = 15/64; sr^2 = 15/64 2/7
    assert find_lacey_index(marked, samples) == pytest.approx((6 / 64) / (15 / 64 * 5 / 7), rel=1e-14)


@pytest.mark.parametrize("sizes", [(3, 3, 3), (1, 2, 5)])
def test_mean_over_all_ways_to_mark_is_one(sizes):
    samples, count = np.repeat(np.arange(3), sizes), sum(sizes)
    found = [
        find_lacey_index(np.isin(np.arange(count), ways), samples) for ways in itertools.combinations(range(count), 4)
    ]
    assert np.mean(found) == pytest.approx(1.0, rel=1e-13) and np.std(found) > 0.1


def test_equal_samples_of_many_are_laceys_own():
    """Half of a bed mixed: p_c of 0.25 and 0.75 in turn, n = 1000."""
    samples = np.repeat(np.arange(100), 1000)
    marked = np.tile(np.arange(1000), 100) < np.where(samples % 2, 250, 750)
    lacey = (0.25 - 0.0625) / (0.25 - 0.25 / 1000)
    assert find_lacey_index(marked, samples) == pytest.approx(lacey, rel=1e-4)


@pytest.mark.parametrize(
    ("marked", "samples"),
    [([0, 0], [0, 1]), ([1, 1, 1], [0, 0, 1]), ([1, 0, 1], [0, 0, 0]), ([1, 0], [0, 1]), ([], [])],
)
def test_what_has_no_index(marked, samples):
    assert np.isnan(find_lacey_index(np.array(marked, bool), np.array(samples, int)))


def test_samples_are_cubes():
    positions = np.array([[0.1, 0.1, 0.1], [0.9, 0.2, 0.3], [1.1, 0.2, 0.3], [0.9, 0.2, 2.3], [0.1, 0.1, -0.1]])
    numbers = number_samples(positions, np.zeros(3), 1.0)
    assert numbers[0] == numbers[1] and len(np.unique(numbers)) == 4
