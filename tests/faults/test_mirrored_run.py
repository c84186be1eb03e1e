"""Means with mirror images of a real run: those of the run without, turned round and averaged, on any ranks."""

import numpy as np
import pytest
import xarray as xr
from small_bed import find_differences, prepare, stop_at_next_moment

from fbcouple.launcher.launch import launch

MIRROR = ('averages.mirror=["x"]',)
QUANTITIES = ("solids_fraction", "solids_flux", "gas_flux", "voidage", "pressure", "block_solids_flux")


def run_through(folder, sets=(), ranks=1):
    run = prepare(folder, sets)
    launch(run, ranks, lambda row: None)
    return run


def read(run):
    return xr.load_dataset(run / "results.nc")


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return read(run_through(tmp_path_factory.mktemp("plain")))


@pytest.mark.parametrize("ranks", [1, 2])
def test_means_are_those_of_both_sides(plain, tmp_path, ranks):
    mirrored = read(run_through(tmp_path, MIRROR, ranks))
    for name in QUANTITIES:
        turned = plain[name].copy(data=np.flip(plain[name].values, plain[name].get_axis_num("x")))
        if "component" in turned.dims:
            turned = turned * xr.DataArray([-1.0, 1.0, 1.0], dims="component")
        expected = 0.5 * (plain[name] + turned).transpose(*mirrored[name].dims).values
        size = np.abs(expected).max()
        assert mirrored[name].values == pytest.approx(expected, abs=3e-6 * size), name
    velocity = mirrored["solids_flux"] / mirrored["solids_fraction"].where(mirrored["solids_fraction"] > 0.0) / 2500.0
    assert np.allclose(mirrored["solids_velocity"], velocity, rtol=1e-4, atol=1e-7, equal_nan=True)
    assert np.array_equal(mirrored["bed_height"].values[:3], plain["bed_height"].values[:3])


def test_it_goes_on_bit_for_bit(tmp_path):
    whole, stopped = run_through(tmp_path / "whole", MIRROR, 2), prepare(tmp_path / "stopped", MIRROR)
    stop_at_next_moment(stopped, 2, [])
    launch(stopped, 2, lambda row: None, resume=True)
    assert find_differences(whole, stopped) == []
