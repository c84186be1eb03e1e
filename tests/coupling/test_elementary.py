"""The branch-free elementary functions against NumPy's, over all that a drag law can ask for."""

import numpy as np
import pytest

from fbcouple.physics.elementary import arctangent, decay, exponential, logarithm, power
from fbcouple.physics.jit import compiled


@compiled
def fill_logarithm(x, result):
    for n in range(len(x)):
        result[n] = logarithm(x[n])


@compiled
def fill_exponential(x, result):
    for n in range(len(x)):
        result[n] = exponential(x[n])


@compiled
def fill_arctangent(x, result):
    for n in range(len(x)):
        result[n] = arctangent(x[n])


@compiled
def fill_decay(x, result):
    for n in range(len(x)):
        result[n] = decay(x[n])


@compiled
def fill_power(x, exponent, result):
    for n in range(len(x)):
        result[n] = power(x[n], exponent)


def compute(fill, x, *more):
    result = np.empty_like(x)
    fill(x, *more, result)
    return result


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def test_logarithm(rng):
    x = np.concatenate([10.0 ** rng.uniform(-300, 300, 100_000), np.linspace(0.3, 3.0, 10_001), [0.5**0.5, 2**0.5]])
    assert compute(fill_logarithm, x) == pytest.approx(np.log(x), rel=4e-15, abs=4e-16)
    assert compute(fill_logarithm, np.ones(1))[0] == 0.0


@pytest.mark.parametrize(("most", "tolerance"), [(20.0, 5e-15), (690.0, 1e-13)])
def test_exponential(rng, most, tolerance):
    """The argument's own rounding counts: half a unit in the last place of 690 is 6e-14 of the result."""
    x = np.concatenate([rng.uniform(-most, most, 100_000), [0.0, -0.0]])
    assert compute(fill_exponential, x) == pytest.approx(np.exp(x), rel=tolerance, abs=0.0)
    assert compute(fill_exponential, np.zeros(1))[0] == 1.0


def test_decay(rng):
    """Of either sign: a step of a drag that pushes the wrong way grows, and is to be seen as it is."""
    sizes = 10.0 ** rng.uniform(-12, 2.8, 50_000)
    x = np.concatenate([sizes, -sizes, [0.0, 1e-2, -1e-2, 700.0, -700.0, -5.0]])
    assert compute(fill_decay, x) == pytest.approx(-np.expm1(-x), rel=2e-13, abs=0.0)
    assert compute(fill_decay, np.array([1e6]))[0] == 1.0


def test_arctangent(rng):
    x = np.concatenate([rng.uniform(-300, 300, 100_000), rng.uniform(-2, 2, 100_000), [0.0, 1.0, -1.0, 1e15, -1e15]])
    assert compute(fill_arctangent, x) == pytest.approx(np.arctan(x), rel=4e-15, abs=1e-300)


@pytest.mark.parametrize(
    ("exponent", "low", "high"), [(0.687, -12, 6), (-2.7, -1.5, 0.1), (-2.65, -1.5, 0.1), (3.7, -2, 2)]
)
def test_power(rng, exponent, low, high):
    """The exponent multiplies the logarithm's rounding: some ten times the rounding of a double over this range."""
    x = 10.0 ** rng.uniform(low, high, 100_000)
    assert compute(fill_power, x, exponent) == pytest.approx(x**exponent, rel=2e-14)


def test_power_of_zero():
    assert compute(fill_power, np.zeros(1), 0.687)[0] < 1e-200
