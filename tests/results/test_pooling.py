"""Means of replicas pooled: against sums that are known, and errors against scatter that is known."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

import fbcouple
from fbcouple.cli.main import cli
from fbcouple.errors import CaseError, LeftOutWarning
from fbcouple.postproc.measures import flux_magnitude
from fbcouple.results.depth_means import depth_average, mass_average
from fbcouple.results.pooling import combine, pool, tell_errors
from fbcouple.results.pools import write_pool
from fbcouple.results.reader import open_results
from fbcouple.results.reduced import ROWS
from fbcouple.results.replicas import estimate_window_error, open_replicas

sys.path.append(str(Path(__file__).parents[1] / "postproc"))
from whole_run import write_whole

CELLS = (8, 3, 25)
DENSITY = 2500.0


def scatter(run, seed, end=20.0, samples=9000, cells=CELLS):
    """A whole run with means of its own: fractions and velocities with noise, and cells where no particle came."""
    rng = np.random.default_rng(seed)
    write_whole(run, cells)
    data = xr.open_dataset(run / "results.nc", decode_times=False).load()
    data.close()
    shape = data["solids_fraction"].shape
    solids = 0.3 * rng.uniform(0.5, 1.0, shape) * (rng.uniform(size=shape) > 0.1)
    velocity = np.where(solids > 0.0, rng.normal(0.0, 0.2, (3, *shape)), np.nan)
    fields = {
        "solids_fraction": solids,
        "solids_velocity": velocity,
        "solids_flux": DENSITY * solids * np.nan_to_num(velocity),
        "agitation": np.where(solids > 0.0, rng.uniform(0.1, 0.2, shape), np.nan),
        "granular_temperature": np.where(solids > 0.0, rng.uniform(0.01, 0.02, shape), np.nan),
        "pressure": rng.normal(600.0, 10.0, shape),
    }
    case = data.attrs["case"].replace("[averages]", f"[start]\nseed = {seed}\njitter = 0.5\n[averages]\nblocks = 10")
    bed_height = data["bed_height"] + 0.01 * rng.normal()
    made = data.assign({name: (data[name].dims, values) for name, values in fields.items()})
    made = made.assign(bed_height=bed_height, max_courant=data["max_courant"] + 0.01 * seed)
    attributes = {"case": case, "averaging_end": end, "averaging_samples": samples, "source": "fbcouple"}
    made.assign_attrs(attributes).to_netcdf(run / "results.nc")
    (run / "case.toml").write_text(case, encoding="utf-8")
    return run


@pytest.fixture
def three(tmp_path):
    return [scatter(tmp_path / f"replica-{n}", n, samples=9000 // n) for n in (1, 2, 3)]


def test_means_are_ratios_of_pooled_sums(three):
    runs = [open_results(run).data for run in three]
    samples = np.array([9000, 4500, 3000])[:, None, None, None]
    pooled = pool(open_replicas(three))
    solids = np.array([run["solids_fraction"].values for run in runs])
    flux = np.array([run["solids_flux"].values for run in runs])
    fraction = (samples * solids).sum(axis=0) / samples.sum()
    assert pooled["solids_fraction"].values == pytest.approx(fraction, rel=1e-13)
    with np.errstate(invalid="ignore"):
        velocity = (samples[:, None] * flux).sum(axis=0) / (DENSITY * (samples * solids).sum(axis=0))
        agitation = np.array([run["agitation"].fillna(0.0).values for run in runs])
        expected = (samples * solids * agitation).sum(axis=0) / (samples * solids).sum(axis=0)
    assert pooled["solids_velocity"].values == pytest.approx(velocity, rel=1e-12, nan_ok=True)
    assert pooled["agitation"].values == pytest.approx(expected, rel=1e-12, nan_ok=True)
    assert pooled.attrs["averaging_samples"] == 16500 and pooled.attrs["averaged_seconds"] == 54.0


@pytest.fixture
def warm(tmp_path):
    """Two runs of equal samples, in a cell of which much is cold and little is warm: solids 0.5 at 300 K and 0.001 at
    400 K, gas 0.5 at 300 K and 0.999 at 400 K; no particle ever comes to the place behind it."""
    made = []
    for seed, (solids, kelvin) in enumerate([(0.5, 300.0), (0.001, 400.0)], start=1):
        run = scatter(tmp_path / f"warm-{seed}", seed)
        data = xr.open_dataset(run / "results.nc", decode_times=False).load()
        data.close()
        places = data["solids_fraction"].dims, np.full(data["solids_fraction"].shape, 1.0)
        fraction, velocity = places[1] * solids, np.full(data["solids_velocity"].shape, 0.1)
        fraction[:, -1], velocity[:, :, -1] = 0.0, np.nan
        warmth = np.where(fraction > 0.0, kelvin, np.nan)
        fields = {
            "solids_fraction": (places[0], fraction),
            "solids_velocity": (data["solids_velocity"].dims, velocity),
            "solids_flux": (data["solids_flux"].dims, DENSITY * fraction * np.nan_to_num(velocity)),
            "solids_temperature": (places[0], warmth),
            "solids_temperature_stderr": (places[0], np.where(fraction > 0.0, 1.0, np.nan)),
            "voidage": (places[0], 1.0 - solids * places[1]),
            "gas_temperature": (places[0], kelvin * places[1]),
        }
        data.assign(fields).to_netcdf(run / "results.nc")
        made.append(run)
    return made


@pytest.mark.parametrize("reduced", [False, True])
def test_temperatures_are_pooled_by_mass_and_by_voidage(warm, tmp_path, reduced):
    data = write_pool(warm, tmp_path / "warm.nc", reduced)
    middle = {name: data[name].isel(x=2, y=0, z=2).item() for name in ("solids_temperature", "gas_temperature")}
    assert middle["solids_temperature"] == pytest.approx((0.5 * 300.0 + 0.001 * 400.0) / 0.501, rel=1e-6)
    assert middle["gas_temperature"] == pytest.approx((0.5 * 300.0 + 0.999 * 400.0) / 1.499, rel=1e-6)


def test_temperatures_are_averaged_over_the_depth_by_mass_and_by_voidage(warm, tmp_path):
    """Of one run: 300 K where solids are 0.5 and 400 K in a place where they are 0.001; another one is empty."""
    data = xr.open_dataset(warm[0] / "results.nc", decode_times=False).load()
    data.close()
    for name, share in (("solids_fraction", 0.001), ("voidage", 0.999)):
        data[name][:, 1] = share
    data["solids_flux"][:, :, 1] = DENSITY * 0.001 * 0.1
    for name in ("solids_temperature", "gas_temperature"):
        data[name][:, 1] = 400.0
    data.to_netcdf(warm[0] / "results.nc")
    found = write_pool(warm[:1], tmp_path / "flat.nc", reduced=True)
    assert found["solids_temperature"].values == pytest.approx((0.5 * 300.0 + 0.001 * 400.0) / 0.501, rel=1e-6)
    gas = (0.5 * 300.0 + 0.999 * 400.0 + 0.5 * 300.0) / 1.999
    assert found["gas_temperature"].values == pytest.approx(gas, rel=1e-6)
    assert found["solids_temperature_stderr"].values == pytest.approx(1.0)


def test_errors_between_replicas_are_the_scatter_of_their_mean():
    """10 000 cells of 4 replicas of known deviation, whose block errors are all too small by the same factor."""
    rng = np.random.default_rng(3)
    size = np.geomspace(0.1, 1.0, 10_000)
    values = 1.0 + size * rng.standard_normal((4, 10_000))
    within = 0.5 * size * np.sqrt(rng.chisquare(9, (4, 10_000)) / 9)
    found = combine(values, np.ones_like(values), within, 10.0)
    assert np.mean(found.error**2) == pytest.approx(np.mean(size**2) / 4, rel=0.05)
    assert np.std(found.error / size) * 2 < 0.2  # 3 numbers alone: 0.42
    held = np.abs(found.mean - 1.0) <= 2.0 * found.error
    assert 0.93 < held.mean() < 0.97
    alone = combine(values, np.ones_like(values), np.full_like(within, np.nan), 10.0)
    plain = values.std(axis=0, ddof=1) / 2.0
    assert alone.error == pytest.approx(plain, rel=1e-12)


def test_weights_count_in_mean_and_error():
    values, weights = np.array([[1.0], [2.0], [4.0]]), np.array([[2.0], [1.0], [1.0]])
    found = combine(values, weights, np.full((3, 1), np.nan), 10.0)
    assert found.mean[0] == 2.0
    assert found.error[0] == pytest.approx(np.sqrt(1.5 * (0.25 * 1.0 + 0.0 + 0.0625 * 4.0)))


def test_what_one_replica_alone_has_keeps_its_value_and_has_its_error_by_blocks():
    values, weights = np.array([[1.0, np.nan], [2.0, 3.0]]), np.array([[1.0, 0.0], [1.0, 1.0]])
    found = combine(values, weights, np.array([[0.5, np.nan], [0.5, 0.2]]), 10.0)
    assert found.mean.tolist() == [1.5, 3.0]
    factor = 0.25 * 2.0 / (0.25 * 0.5)
    assert found.error[0] == pytest.approx(0.5) and found.error[1] ** 2 == pytest.approx(0.04 * factor / 2 * 1.0)


def test_one_replica_is_the_run_itself(three):
    run, pooled = open_results(three[0]).data, pool(open_replicas(three[:1]))
    for name in ("solids_fraction", "solids_velocity", "agitation", "pressure", "solids_flux_stderr"):
        assert pooled[name].values == pytest.approx(
            run[name].where(np.isfinite(run[name])).values, rel=1e-13, nan_ok=True
        )


def test_window_means_of_histories_are_pooled(three):
    pooled = pool(open_replicas(three))
    heights = [open_results(run).data["bed_height"].sel(time=slice(2.0 + 1e-9, None)).mean().item() for run in three]
    found = pooled.sel(quantity="bed_height")
    shares = np.array([6.0, 3.0, 2.0]) / 11.0  # of the samples
    mean = float(shares @ heights)
    assert float(found["window_mean"]) == pytest.approx(mean, rel=1e-9)
    between = np.sqrt(1.5 * np.sum((shares * (np.array(heights) - mean)) ** 2))
    assert 0.1 * between < float(found["window_mean_stderr"]) < between
    assert float(pooled["max_courant"].max()) == pytest.approx(0.23)  # the worst of all, the third's


def test_a_replica_that_records_more_often_counts_as_much_in_window_means(tmp_path):
    runs = [scatter(tmp_path / f"run-{seed}", seed) for seed in (1, 2)]
    data = xr.open_dataset(runs[0] / "results.nc", decode_times=False).load()
    data.close()
    data.isel(time=slice(0, None, 5)).assign(bed_height=lambda few: 0.0 * few["time"] + 0.05).to_netcdf(
        runs[0] / "results.nc"
    )
    height = open_results(runs[1]).data["bed_height"].sel(time=slice(2.0 + 1e-9, None)).mean().item()
    for reduced in (False, True):
        found = write_pool(runs, tmp_path / "pool.nc", reduced).sel(quantity="bed_height")
        assert float(found["window_mean"]) == pytest.approx(0.5 * (0.05 + height), rel=1e-6)


def test_bars_of_window_means_hold_the_truth():
    """In 60 correlation times of 20 rows each: nearly always told, and right in nineteen of twenty windows."""
    rng, decay = np.random.default_rng(0), np.exp(-1.0 / 20.0)
    chance = rng.standard_normal((1200, 200))
    for n in range(1, len(chance)):
        chance[n] = decay * chance[n - 1] + np.sqrt(1.0 - decay**2) * chance[n]
    errors = np.array([estimate_window_error(values) for values in chance.T])
    told = np.isfinite(errors)
    assert told.mean() > 0.96
    assert 0.88 < np.mean(np.abs(chance.mean(axis=0))[told] <= 2.0 * errors[told]) < 0.98


def test_reduced_files_pool_to_the_maps_of_the_whole_runs(three, tmp_path):
    """Also one by one, and in two steps, as runs of different days come."""
    whole = open_results(tmp_path)
    files = [tmp_path / "small" / f"{n}.nc" for n in range(3)]
    for run, file in zip(three, files, strict=True):
        write_pool([run], file, reduced=True)
    write_pool(files[:2], tmp_path / "small/two.nc")
    write_pool([tmp_path / "small/two.nc", files[2]], tmp_path / "small/all.nc")
    small = open_results(tmp_path / "small/all.nc")
    assert small.replicas == 3 and small.data.sizes["y"] == 1
    for name in ("solids_fraction", "solids_flux", "voidage", "gas_flux", "pressure"):
        one, other = (depth_average(run.mean(name)).values for run in (whole, small))
        assert other == pytest.approx(one, rel=2e-5, abs=2e-5 * np.abs(one).max()), name
    for name in ("solids_velocity", "agitation", "granular_temperature"):
        one, other = (mass_average(run, name).values for run in (whole, small))
        assert other == pytest.approx(one, rel=2e-5, abs=2e-5 * np.nanmax(np.abs(one)), nan_ok=True), name
    mean, error = whole.window_mean("bed_height")
    assert small.window_mean("bed_height") == pytest.approx((mean, error), rel=0.01)
    assert small.window_mean("bed_height")[0] == pytest.approx(mean, rel=2e-5)
    at_once = write_pool(three, tmp_path / "small/once.nc", reduced=True)
    error = small.data["solids_fraction_stderr"].values
    assert error == pytest.approx(at_once["solids_fraction_stderr"].values, rel=0.02, abs=1e-5)
    assert list(small.data["block_replica"].values) == [1] * 18 + [2] * 18 + [3] * 18
    errors = [flux_magnitude(run).error for run in (whole, small)]
    # Blocks of this bed differ by a twentieth alone, so that rounding them by a sixtieth shows.
    assert errors[1] == pytest.approx(errors[0], rel=0.05) and errors[0] > 0.0
    taken = open_replicas([tmp_path / "small/all.nc"])[1].data
    first = open_results(three[1]).data["block_solids_flux"].values
    assert taken["block_solids_flux"].values == pytest.approx(first, rel=0.032, abs=1e-6)


def test_a_reduced_file_of_patil_c2_is_small(tmp_path):
    run = scatter(tmp_path / "run", 1, cells=(35, 6, 110))
    data = xr.open_dataset(run / "results.nc", decode_times=False).load()
    data.close()
    noise = np.random.default_rng(2).uniform(0.5, 1.5, data["solids_flux"].shape)
    errors = {
        name: field
        * noise[: field.shape[0]].reshape(-1, *field.shape[-3:])[: field.sizes.get("component", 1)].reshape(field.shape)
        for name, field in data.items()
        if name.endswith("_stderr")
    }
    bed = data["z"] < 0.09  # above it there are no solids in a bed of 75 g
    solids = [
        name
        for name in data
        if {"z", "y", "x"} <= set(data[name].dims) and "gas" not in name and name not in ("pressure", "voidage")
    ]
    made = data.assign(errors)
    made.assign({name: made[name].where(bed, 0.0) for name in solids}).to_netcdf(run / "results.nc")
    write_pool([run], tmp_path / "small.nc", reduced=True)
    data = open_results(tmp_path / "small.nc").data
    assert data.sizes["time"] <= ROWS + 2 and not {"snapshot_time", "exit"} & set(data.dims)
    assert (tmp_path / "small.nc").stat().st_size < 500_000


def test_thinned_histories_keep_their_extremes(three, tmp_path):
    data = write_pool(three[:1], tmp_path / "small.nc", reduced=True)
    whole = open_results(three[0]).data
    for name in ("max_courant", "max_overlap"):
        assert float(data[name].max()) == float(whole[name].max())
    assert float(data["wall_seconds"].sum()) == pytest.approx(float(whole["wall_seconds"].sum()))


def test_what_is_no_replica_is_refused(three, tmp_path):
    with pytest.raises(CaseError, match="replica-1: is the same run as replica-1; give it once"):
        pool(open_replicas([three[0], three[0]]))
    other = scatter(tmp_path / "other", 5)
    say_otherwise(other, "friction = 0.1", "friction = 0.3")
    with pytest.raises(CaseError, match=r"other: is another case than replica-1 \(contact.friction\)"):
        pool(open_replicas([*three, other]))
    write_pool(three, tmp_path / "pooled.nc")
    with pytest.raises(CaseError, match="is pooled already and holds its replicas no more"):
        open_replicas([tmp_path / "pooled.nc"])
    with pytest.raises(CaseError, match="is one of the files that are pooled"):
        write_pool(three, three[0] / "results.nc")
    with pytest.raises(CaseError, match=r"pooled.txt: is given for a pool, a file NAME.nc"):
        write_pool(three, tmp_path / "pooled.txt")


def test_seeds_are_asked_for_among_runs_of_one_case_only(three, tmp_path):
    other = scatter(tmp_path / "other", 1)
    say_otherwise(other, "friction = 0.1", "friction = 0.3")
    with pytest.raises(CaseError) as refused:
        pool(open_replicas([three[0], other]))
    assert refused.value.problems == ["other: is another case than replica-1 (contact.friction); leave it out."]


def say_otherwise(run, old, new):
    """Let the case in the results of `run` have the line `new` in place of `old`."""
    data = xr.open_dataset(run / "results.nc", decode_times=False).load()
    data.close()
    data.attrs["case"] = data.attrs["case"].replace(old, new)
    data.to_netcdf(run / "results.nc")


def test_an_option_that_is_younger_than_a_replica_had_its_default_in_it(three, tmp_path):
    """So replicas of two versions can be pooled; a section that one of them has alone, or another value, is another
    case as before."""
    friction = "friction = 0.1"
    say_otherwise(three[0], friction, f"{friction}\nyounger = 2.5")
    with pytest.raises(CaseError, match=r"replica-2: is another case than replica-1 \(contact.younger\)"):
        write_pool(three, tmp_path / "no.nc")
    defaults = {"contact.younger": 2.5, "heat.younger": 1.0}
    assert write_pool(three, tmp_path / "all.nc", defaults=defaults).attrs["replicas"] == 3
    assert write_pool(three, tmp_path / "small.nc", True, defaults=defaults).attrs["replicas"] == 3
    say_otherwise(three[0], "younger = 2.5", "younger = 3.0")
    with pytest.raises(CaseError, match=r"\(contact.younger\)"):
        write_pool(three, tmp_path / "no.nc", defaults=defaults)
    say_otherwise(three[0], "[averages]", "[heat]\nyounger = 1.0\n[averages]")
    with pytest.raises(CaseError, match=r"\(contact.younger, heat\)"):
        write_pool(three, tmp_path / "no.nc", defaults=defaults)


def go_on(run, start, end):
    """The same run later: other means over a window from `start` to `end` [s]."""
    data = xr.open_dataset(run / "results.nc", decode_times=False).load()
    data.close()
    later = data.assign(solids_flux=1.1 * data["solids_flux"], pressure=data["pressure"] + 1.0)
    later.assign_attrs(averaging_start=start, averaging_end=end).to_netcdf(run / "results.nc")


def test_a_run_at_two_of_its_times_is_no_two_replicas(three, tmp_path):
    """It would count twice, and its error look several times smaller than it is."""
    early = tmp_path / "early.nc"
    write_pool(three[:1], early, reduced=True)
    go_on(three[0], 2.0, 30.0)
    with pytest.raises(CaseError) as refused:
        write_pool([three[1], three[0], early], tmp_path / "no.nc")
    (text,) = refused.value.problems
    assert "replica-1: is the same run as replica-1, maybe at another of its times" in text
    assert "the same seeds (start.seed = 1) and windows that overlap (2 to 20 s, 2 to 30 s)" in text
    assert "set one up with another seed" in text
    go_on(three[0], 20.0, 30.0)  # a window behind that of before: told by the set-up
    assert write_pool([early, three[0]], tmp_path / "both.nc").attrs["replicas"] == 2
    for run in three[:2]:
        (run / "manifest.json").write_text('{"files": {"case.toml": "12"}}', encoding="utf-8")
    write_pool(three[:1], early, reduced=True)
    go_on(three[0], 31.0, 40.0)
    with pytest.raises(CaseError, match=r"the same seeds \(start.seed = 1\) and the same set-up; give one"):
        write_pool([early, three[0]], tmp_path / "both.nc")
    assert write_pool([early, three[1]], tmp_path / "both.nc").attrs["replicas"] == 2  # of another seed


def test_a_pool_tells_what_is_in_it(three, tmp_path):
    data = fbcouple.pool(three, tmp_path / "pooled.nc")
    told = json.loads(data.attrs["replicas_of"])
    assert [one["name"] for one in told] == ["replica-1", "replica-2", "replica-3"]
    assert [one["seeds"]["start.seed"] for one in told] == [1, 2, 3]
    assert all(len(one["results"]) == 64 for one in told) and told[1]["window"] == [2.0, 20.0]
    assert "uncertain by 50 %" in data.attrs["pooled_errors"] and "little worth" in tell_errors(2)
    assert data.attrs["core_seconds"] == 3 * 7200.0


def test_a_run_without_means_is_refused(three):
    drop_means(three[1])
    with pytest.raises(CaseError, match="has no time means yet, averaging starts at 2 s"):
        open_replicas(three)


def drop_means(run):
    """As a replica leaves its results that has not come to the start of its averaging."""
    data = xr.open_dataset(run / "results.nc", decode_times=False).load()
    data.close()
    data.attrs["averaging_end"] = 1.0
    data.to_netcdf(run / "results.nc")


def test_of_a_folder_replicas_without_means_are_left_out_by_name(three, tmp_path):
    """The first has not begun and the third has no means yet; named one by one they are refused."""
    (three[0] / "results.nc").unlink()
    drop_means(three[2])
    done = CliRunner().invoke(cli, ["pool", str(tmp_path), "-o", str(tmp_path / "now.nc")])
    assert done.exit_code == 0, done.output
    left_out = "replica-1, replica-3: no time means yet, left out; 1 of 3 replicas are pooled"
    assert f"warning: {tmp_path}: {left_out}" in done.stderr.splitlines()
    assert open_results(tmp_path / "now.nc").data.attrs["replicas"] == 1
    with pytest.warns(LeftOutWarning, match="replica-1, replica-3"):
        opened = open_results(tmp_path)
    assert opened.path == three[1] / "results.nc" and opened.data.attrs["replicas"] == 1
    named = CliRunner().invoke(cli, ["pool", *map(str, three), "-o", str(tmp_path / "named.nc")])
    assert named.exit_code == 1
    assert "replica-1/results.nc does not exist" in named.stderr and "replica-3/results.nc: has no" in named.stderr


def test_a_folder_whose_replicas_all_have_no_means_is_refused(three, tmp_path):
    for run in three:
        (run / "results.nc").unlink()
    with pytest.raises(CaseError, match=r"none of its 3 replicas has time means yet"):
        write_pool([tmp_path], tmp_path / "now.nc")


def test_a_damaged_replica_of_a_folder_is_not_left_out(three, tmp_path):
    (three[0] / "results.nc").write_bytes(b"no netCDF")
    with pytest.raises(CaseError, match="replica-1"):
        write_pool([tmp_path], tmp_path / "now.nc")
