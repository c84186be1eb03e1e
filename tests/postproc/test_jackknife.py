"""Standard errors of numbers made of maps, against records whose true mean is known."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.postproc.jackknife import estimate_number_error, is_own_mirror_image, mirror_flux
from fbcouple.results.block_means import join_blocks, lay_out_blocks
from fbcouple.results.reader import NotDrawableError, Results

NX, NZ = 8, 6
BOX = {"title": "a box", "domain": {"size": [0.08, 0.02, 0.06], "shape": "box"}, "gas": {"inlet_velocity": 1.0}}
UP = np.where(np.abs(np.arange(NX) - 3.5) < 2.0, 60.0, -60.0)
"""Mean flux [kg m-2 s-1] across the bed: up in the middle."""


def make(rng, blocks=16, length=4.0, slow=0.0, case=BOX, last=40):
    """Blocks of `length` correlation times of a flux that scatters in every cell, with a pattern as large as `slow`
    that is odd in x and turns round once in the whole window; the last block is of `last` of 40 samples."""
    steps = 20
    decay = np.exp(-length / steps)
    noise = rng.standard_normal((blocks * steps, NZ, NX))
    series = np.empty_like(noise)
    series[0] = noise[0]
    for step in range(1, len(series)):
        series[step] = decay * series[step - 1] + np.sqrt(1.0 - decay**2) * noise[step]
    odd = slow * np.cos(2.0 * np.pi * np.arange(len(series)) / len(series) + rng.random() * 6.0)
    flux = UP + 20.0 * series + odd[:, None, None] * np.linspace(-1.0, 1.0, NX)
    rows = np.zeros((blocks, 6, NZ, NX))
    rows[:, 0], rows[:, 1] = 0.3, 750.0
    rows[:, 4] = flux.reshape(blocks, steps, NZ, NX).mean(axis=1)
    rows[:, 5] = 750.0 * 0.1 + rows[:, 4] ** 2 / 750.0
    coords = {axis: (np.arange(n) + 0.5) * 0.01 for axis, n in (("x", NX), ("y", 2), ("z", NZ))}
    samples = [40] * (blocks - 1) + [last]
    data = xr.Dataset(lay_out_blocks(np.arange(blocks), samples, rows), coords | {"component": ["x", "y", "z"]})
    return Results(Path("results.nc"), data, case)


def middle(run):
    """A number that is linear in the means."""
    return float(run.data["solids_flux"].sel(component="z").values[:, :, 2:6].mean())


def size(run):
    """One that is not."""
    flux = run.data["solids_flux"].values
    return float(np.hypot(*mirror_flux(run, flux[[0, 2]].mean(axis=2))).mean())


@pytest.mark.parametrize("slow", [0.0, 40.0])
@pytest.mark.parametrize(("number", "truth"), [(middle, 60.0), (size, 60.0)])
def test_bars_of_two_standard_errors_hold_the_truth(number, truth, slow):
    """In 19 of 20 records; also where most of the scatter is a pattern from side to side that the number does not see,
    and that is slower than the record is long."""
    rng = np.random.default_rng(1)
    held, errors = [], []
    for _ in range(200):
        run = make(rng, slow=slow)
        flux = np.average(run.data["block_solids_flux"].values, axis=0)[:, :, None]
        means = xr.Dataset({"solids_flux": (("component", "z", "y", "x"), flux)}, {"component": ["x", "y", "z"]})
        value = number(Results(run.path, means, BOX))
        errors.append(estimate_number_error(run, number))
        held.append(abs(value - truth) <= 2.0 * errors[-1])
    assert 0.88 <= np.mean(held) <= 0.99
    # 16 blocks of 4 correlation times, 24 or 48 cells: the variance of a mean is 2/64 of that of a value
    exact = 20.0 * np.sqrt(2.0 / 64.0 / (24 if number is middle else 48))
    assert np.mean(errors) == pytest.approx(exact, rel=0.15)


def test_without_a_mirror_a_slow_pattern_makes_the_error_unknown():
    """An inlet at the side: the bed is no mirror image of itself, and the pattern may mean something."""
    aside = BOX | {"gas": {"inlets": [{"velocity": 1.0}]}}
    run = make(np.random.default_rng(2), slow=400.0, case=aside)
    assert not is_own_mirror_image(run)
    with pytest.raises(NotDrawableError, match="too short against the correlation"):
        estimate_number_error(run, middle)


def test_a_short_last_block_counts_as_little():
    """A number that is linear has the error of the weighted blocks."""
    whole, part = (estimate_number_error(make(np.random.default_rng(3), last=last), middle) for last in (40, 1))
    assert part == pytest.approx(whole, rel=0.25)


def test_replicas_count_as_one_record():
    """Four windows have half of the error of one."""
    rng = np.random.default_rng(4)
    runs = [make(rng) for _ in range(4)]
    single = np.mean([estimate_number_error(run, middle) for run in runs])
    pooled = runs[0].data.drop_dims("block").assign(join_blocks([run.data for run in runs]))
    assert estimate_number_error(Results(Path("pool.nc"), pooled, BOX), middle) == pytest.approx(0.5 * single, rel=0.15)


def test_results_without_blocks_have_no_error():
    run = make(np.random.default_rng(5))
    with pytest.raises(NotDrawableError, match="no standard error; run it again"):
        estimate_number_error(Results(run.path, run.data.drop_dims("block"), BOX), middle)


@pytest.mark.parametrize(
    "change",
    [
        {"domain": {"size": [0.08, 0.02, 0.06], "shape": "file"}},
        {"gas": {"outlets": [{"face": "left"}]}},
        {"particles": {"feeds": [{"rate": 10.0}]}},
        {"heat": {"walls": [{"face": "left", "temperature": 500.0}]}},
    ],
)
def test_what_comes_or_goes_at_one_side_makes_no_mirror_image(change):
    run = make(np.random.default_rng(6))
    assert is_own_mirror_image(run)
    assert not is_own_mirror_image(Results(run.path, run.data, BOX | change))
