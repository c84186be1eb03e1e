"""Standard errors from blocks, on series whose mean and correlation are known."""

import numpy as np
import pytest

from fbcouple.results.block_errors import compare_with_map, estimate_errors, find_gain, join_pairs

TAU = 8.0


@pytest.fixture
def rng():
    return np.random.default_rng(42)


def make_series(rng, length, cells):
    """AR(1) series (length, cells) of mean 1 and variance 1 with a correlation time of TAU values."""
    decay = np.exp(-1.0 / TAU)
    noise = rng.standard_normal((length, cells))
    noise[1:] *= np.sqrt(1.0 - decay**2)
    for n in range(1, length):
        noise[n] += decay * noise[n - 1]
    return 1.0 + noise


def cut(series, blocks):
    length = len(series) // blocks
    return series[: blocks * length].reshape(blocks, length, -1).mean(axis=1)[..., None]


def cover(times, blocks, pieces=40, cells=40):
    """Part of the cells whose two-sigma bars hold the true mean, of pieces that tell an error, and how many do."""
    rng = np.random.default_rng(5)
    hits = []
    for _ in range(pieces):
        parts = cut(make_series(rng, int(times * TAU), cells), blocks)
        errors = estimate_errors(parts)[:, 0]
        if np.isfinite(errors).all():
            hits.append(np.abs(parts.mean(axis=0)[:, 0] - 1.0) <= 2.0 * errors)
    return (float(np.mean(hits)) if hits else np.nan), len(hits) / pieces


@pytest.mark.parametrize("times", [20, 40, 100, 200])
@pytest.mark.parametrize("blocks", [10, 20])
def test_two_sigma_bars_hold_the_mean(times, blocks):
    part, told = cover(times, blocks)
    print(f"{times} correlation times in {blocks} blocks: {100 * part:.1f} % within two standard errors, told {told:g}")
    assert 0.90 <= part <= 0.98 and told > (0.4 if times == 20 else 0.99)


def test_blocks_that_are_taken_as_independent_would_be_too_sure():
    """What the correction is for: the plain error of 20 blocks of a correlation time holds too few means."""
    parts = cut(make_series(np.random.default_rng(5), int(20 * TAU), 2000), 20)[..., 0]
    plain = parts.std(axis=0, ddof=1) / np.sqrt(20)
    assert np.mean(np.abs(parts.mean(axis=0) - 1.0) <= 2.0 * plain) < 0.8


@pytest.mark.parametrize("times", [2, 5])
def test_of_a_window_that_is_too_short_no_error_is_told(times):
    assert cover(times, 10)[1] == 0.0


def test_unseen_correlation_leaves_the_plain_error(rng):
    parts = rng.standard_normal((16, 3000, 1))
    plain = parts.std(axis=0, ddof=1) / 4.0
    assert estimate_errors(parts) == pytest.approx(plain, rel=0.03)


def test_the_chance_of_a_cell_is_a_margin():
    """Two correlation times a block are enough, but one cell alone is too little to be sure of it."""
    assert find_gain(0.17, 1.0, 16) > 1.0 / 16 and np.isnan(find_gain(0.3, 1.0, 16, surely=True))
    assert find_gain(0.0, 0.0, 16) == 1.0 / 16


def test_a_cell_counts_the_blocks_in_which_it_has_a_value(rng):
    parts = rng.standard_normal((12, 500, 1))
    parts[3, 0] = parts[7, 0] = np.nan
    parts[1:, 1] = np.nan
    errors = estimate_errors(parts)[:, 0]
    own = parts[np.isfinite(parts[:, 0, 0]), 0, 0]
    assert errors[0] == pytest.approx(own.std(ddof=1) / np.sqrt(10), rel=0.1)
    assert np.isnan(errors[1]) and np.isfinite(errors[2:]).all()
    assert np.isnan(estimate_errors(parts[:2])).all()


def test_joined_pairs_and_the_number_of_a_map():
    assert join_pairs(np.arange(5.0)).tolist() == [0.5, 2.5]
    assert compare_with_map(np.array([3.0, -4.0]), np.array([0.3, 0.4])) == pytest.approx(0.1)
    assert np.isnan(compare_with_map(np.zeros(2), np.ones(2))) and np.isnan(
        compare_with_map(np.ones(2), np.full(2, np.nan))
    )
