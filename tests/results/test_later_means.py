"""Means of the later blocks of a window: what averaging would have given that had started then."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.errors import CaseError
from fbcouple.results.block_means import COLUMNS, lay_out_blocks
from fbcouple.results.pools import write_pool
from fbcouple.results.reader import open_results

sys.path.append(str(Path(__file__).parents[1] / "postproc"))
from whole_run import write_whole

C2 = Path(__file__).parents[2] / "docs/results/paper/c2.nc"
CELLS = (8, 3, 25)
STARTS = 5.0 + 1.25 * np.arange(12)
SAMPLES = np.array([625] * 11 + [100])


@pytest.fixture
def rows():
    """Rows (blocks, COLUMNS, z, x): fraction, mass, flux in x, y, z, and energy; places without solids on top."""
    rng = np.random.default_rng(3)
    found = rng.uniform(0.5, 1.0, (len(STARTS), COLUMNS, CELLS[2], CELLS[0]))
    found[:, 5] += 3.0
    found[:, :, -4:] = 0.0
    return found


@pytest.fixture
def run(tmp_path, rows):
    run = tmp_path / "run"
    write_whole(run, CELLS)
    with xr.open_dataset(run / "results.nc", decode_times=False) as data:
        made = data.load()
    made = made.drop_dims("block", errors="ignore").assign(lay_out_blocks(STARTS, SAMPLES, rows))
    about = {"averaging_start": 5.0, "averaging_end": 20.0, "averaging_samples": int(SAMPLES.sum())}
    made.assign_attrs(about).to_netcdf(run / "results.nc")
    return run


def test_means_are_those_of_the_blocks_that_begin_later(run, rows, tmp_path):
    data = write_pool([run], tmp_path / "later.nc", start=STARTS[4] + 1e-9)
    weight = SAMPLES[4:] / SAMPLES[4:].sum()
    fraction, mass, *flux, energy = np.tensordot(weight, rows[4:], 1)
    velocity = np.divide(flux, mass, out=np.zeros((3, *mass.shape)), where=mass > 0.0)
    agitation = np.divide(energy, mass, out=np.zeros_like(mass), where=mass > 0.0) - (velocity**2).sum(axis=0)
    ratios = {"agitation": agitation, "solids_velocity": velocity}
    for name, wanted in ({"solids_fraction": fraction, "solids_flux": np.array(flux)} | ratios).items():
        known = np.where(mass > 0.0, wanted, np.nan) if name in ratios else wanted
        np.testing.assert_allclose(data[name].values[..., 0, :], known, rtol=1e-6, atol=1e-12, err_msg=name)
    assert data.attrs["averaging_start"] == STARTS[4] and data.attrs["averaged_seconds"] == 20.0 - STARTS[4]
    assert data.attrs["averaging_samples"] == SAMPLES[4:].sum()
    assert "pressure" not in data and "granular_temperature" not in data
    results = open_results(tmp_path / "later.nc")
    height, time = results.data["bed_height"], results.data["time"].values
    assert results.window_mean("bed_height")[0] == pytest.approx(float(height[time > STARTS[4]].mean()), rel=1e-3)


def test_errors_are_those_of_whole_blocks(run, rows, tmp_path):
    data = write_pool([run], tmp_path / "later.nc", start=STARTS[4])
    whole = rows[4:11]
    told = data["solids_fraction_stderr"].values[:, 0] / (whole[:, 0].std(axis=0, ddof=1) / np.sqrt(len(whole)) + 1e-30)
    assert np.ptp(told[:-4]) < 1e-3 and 0.7 < told[:-4].mean() < 1.4, "one correlation for the whole map"
    assert (data["solids_fraction_stderr"].values[-4:] == 0.0).all()
    assert np.isnan(data["solids_velocity_stderr"].values[:, -4:]).all()


def test_too_few_blocks_and_none_are_refused(run, tmp_path):
    with pytest.raises(CaseError, match=r"run: 18 s is given, and 1 of its blocks .* \(12 blocks begin at 5 to"):
        write_pool([run], tmp_path / "later.nc", start=18.0)
    with xr.open_dataset(run / "results.nc", decode_times=False) as data:
        made = data.load()
    made.drop_dims("block").to_netcdf(run / "results.nc")
    with pytest.raises(CaseError, match="run: has no blocks of its averaging window"):
        write_pool([run], tmp_path / "later.nc", start=6.0)
    assert not (tmp_path / "later.nc").exists()


def test_all_blocks_give_the_means_of_the_window_back(tmp_path):
    """Blocks are kept to 1.6 % each; their errors are rounding, which averages out."""
    write_pool([C2], tmp_path / "all.nc", start=0.0)
    own, found = open_results(C2), open_results(tmp_path / "all.nc")
    filled = own.data["solids_fraction"].values > 0.02
    for name in ("solids_fraction", "solids_flux", "solids_velocity", "agitation"):
        before, now = (np.broadcast_to(one.data[name].values, own.data[name].shape) for one in (own, found))
        places = np.broadcast_to(filled, before.shape)
        assert np.abs(now - before)[places].max() < 0.02 * np.abs(before[places]).max(), name
        told = found.data[f"{name}_stderr"].values[places] / own.data[f"{name}_stderr"].values[places]
        assert 0.9 < np.nanmedian(told) < 1.1, name
    assert found.window_mean("bed_height") == own.window_mean("bed_height")
    later = write_pool([tmp_path / "all.nc"], tmp_path / "later.nc", start=1.8)
    assert 1.8 <= later.attrs["averaging_start"] < 2.4
