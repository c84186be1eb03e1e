"""The onset of fluidization on a curve whose numbers are known."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.postproc.figures.fluidization_curve import find_onset

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


def test_rows_of_an_overshoot_and_of_noise_move_it_little():
    rng = np.random.default_rng(3)
    velocity = np.linspace(0.0, 1.5, 151)
    pressure = bed(velocity, 400.0, 1000.0) + 5.0 * rng.standard_normal(151)
    pressure[(velocity > 0.58) & (velocity < 0.66)] = 1.15 * WEIGHT
    onset = find_onset(velocity, pressure, WEIGHT)
    assert onset is not None and onset.velocity == pytest.approx(0.6, rel=0.01)


def test_no_onset_without_a_packed_bed():
    velocity = np.linspace(1.0, 1.5, 50)
    assert find_onset(velocity, np.full(50, WEIGHT), WEIGHT) is None
