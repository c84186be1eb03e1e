"""A results.nc that nobody of us wrote: figures, report and claims refuse it in words, or draw what is left of it."""

from __future__ import annotations

import re

import netCDF4
import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.errors import CaseError
from fbcouple.results import stored
from fbcouple.results.reader import open_results
from tests.postproc.whole_run import write_whole

COMMANDS = ["post"], ["report"], ["claims"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The text of a whole run's results.nc, to be spoiled."""
    return (write_whole(tmp_path_factory.mktemp("sound") / "run") / "results.nc").read_bytes()


@pytest.fixture
def spoil(tmp_path, whole):
    """Write RUN/results.nc of a whole run as `change` leaves it; returns RUN."""

    def make(change):
        path = tmp_path / "results.nc"
        path.write_bytes(whole)
        with xr.open_dataset(path, decode_times=False) as sound:
            data = sound.load()
        data = data.drop_encoding()
        (change(data) or data).to_netcdf(path)
        return tmp_path

    return make


def put(name, value):
    """Put an attribute or variable in its place; an option of the case is named by its line's start."""

    def change(data):
        if name in data or isinstance(value, tuple):
            data[name] = value
        else:
            data.attrs[name] = value

    return change


def edit(pattern, replacement):
    def change(data):
        text = re.sub(pattern, replacement, data.attrs["case"], count=1, flags=re.MULTILINE)
        assert text != data.attrs["case"]
        data.attrs["case"] = text

    return change


def text_like(name):
    return lambda data: data.assign({name: (data[name].dims, np.full(data[name].shape, "seven", dtype=object))})


REFUSED = {
    "no domain": (edit(r"^\[domain\]\nsize.*\ncells.*$", ""), r"\[domain\] of its case is no section"),
    "domain is a number": (edit(r"\A", "domain = 3\n"), "is not TOML"),
    "gas is a number": (put("case", 'title = "a"\ngas = 3\n'), r"\[gas\] of its case is no section"),
    "case is a number": (put("case", 7.0), "has no attribute `case`"),
    "case is empty": (put("case", ""), r"\[domain\] of its case is no section"),
    "case is a deep list": (put("case", "a = " + "[" * 20000), "is not TOML"),
    "title is a number": (edit(r"^title.*$", "title = 3"), "title of its case is `3`, and not a text"),
    "no title": (edit(r"^title.*$", ""), "title of its case is absent"),
    "size of nothing": (edit(r"^size.*$", "size = [0.0, 0.1, 0.1]"), r"domain\.size of its case"),
    "size of two": (edit(r"^size.*$", "size = [0.1, 0.1]"), r"domain\.size of its case"),
    "size of texts": (edit(r"^size.*$", 'size = ["a", "b", "c"]'), r"domain\.size of its case"),
    "cells of parts": (edit(r"^cells.*$", "cells = [1.5, 2, 3]"), r"domain\.cells of its case"),
    "density is a text": (edit(r"^density.*$", 'density = "air"'), r"gas\.density of its case is `air`"),
    "no inflow": (edit(r"^inlet_velocity.*$", ""), "neither inlet_velocity nor inlet_ramp"),
    "an empty ramp": (edit(r"^inlet_velocity.*$", "inlet_ramp = []"), "not rows of two numbers"),
    "inflow is infinite": (edit(r"^inlet_velocity.*$", "inlet_velocity = inf"), r"gas\.inlet_velocity of its case"),
    "averaging_start is a text": (put("averaging_start", "soon"), "averaging_start is `soon`, and not a number"),
    "start_up_over is a text": (put("start_up_over", "yes"), "start_up_over is `yes`, and not a number"),
    "averaging_end is a list": (put("averaging_end", [1.0, 2.0]), "averaging_end .* not a number"),
    "ranks is a text": (put("ranks", "two"), "ranks is `two`"),
    "texts for numbers": (text_like("bed_height"), "bed_height holds no numbers"),
    "texts for times": (lambda d: d.assign_coords(time=d["time"].astype(str)), "time is not rising times"),
    "times that fall": (lambda d: d.assign_coords(time=-d["time"]), "time is not rising times"),
    "no times": (lambda d: d.drop_vars("time"), "time is not rising times"),
    "x that jumps": (lambda d: d.assign_coords(x=d["x"] ** 3), "x is not the centres of equal cells"),
    "no z": (lambda d: d.drop_vars("z"), "z is not the centres of equal cells"),
    "history over x": (lambda d: d.assign(bed_height=("x", np.ones(8))), r"bed_height is over \(x\)"),
    "mean over time": (lambda d: d.assign(pressure=("time", np.ones(2001))), r"pressure is over \(time\)"),
    "no particles in the case": (edit(r"^\[particles\]\n(.*\n){3}", ""), r"no \[particles\]"),
    "a scalar mean": (lambda d: d.assign(solids_fraction=0.5), r"solids_fraction is over \(\)"),
    "probes are a number": (edit(r"^name = \"tap\"$", "name = 3"), r"output\.probes of its case is"),
    "a probe of nothing": (edit(r'"pressure"\]$', '"colour"]'), r"output\.probes of its case is"),
    "probes without their values": (lambda d: d.drop_vars("probe_tap_pressure"), "has no variable probe_tap_pressure"),
    "probes over time": (lambda d: d.assign(probe_tap_x=("time", np.ones(2001))), r"probe_tap_x is over \(time\)"),
    "other components": (lambda d: d.assign_coords(component=["a", "b", "c"]), "component is not x, y, z"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_no_run_writes_is_refused_in_words(name, spoil):
    change, words = REFUSED[name]
    run = spoil(change)
    with pytest.raises(CaseError, match=words) as caught:
        open_results(run)
    assert all(str(run / "results.nc") in problem for problem in caught.value.problems)
    for command in COMMANDS:
        done = CliRunner().invoke(cli, [*command, str(run)])
        assert done.exit_code == 1 and isinstance(done.exception, SystemExit), done.output


DRAWN = {
    "no averages": lambda d: d.drop_vars([n for n in d.data_vars if {"x", "y", "z"} <= set(d[n].dims)]),
    "a hole in the count of particles": put("particles", ("time", np.full(2001, np.nan))),
    "nothing recorded": lambda d: d.isel(time=slice(0, 0)),
    "one row": lambda d: d.isel(time=slice(0, 1)),
    "no stages": lambda d: d.drop_vars(["wall_seconds", "stage"]),
    "no sample of probes": lambda d: d.isel(probe_tap_time=slice(0, 0), probe_axis_time=slice(0, 0)),
    "no probes": lambda d: d.drop_vars([name for name in d.variables if str(name).startswith("probe_")]),
    "no snapshots": lambda d: d.isel(snapshot_time=slice(0, 0)),
    "infinite pressure": put("pressure_drop", ("time", np.full(2001, np.inf))),
    "no window": put("averaging_start", float("nan")),
    "a window that ends before it begins": put("averaging_end", -1.0),
}


@pytest.mark.parametrize("name", DRAWN)
def test_what_is_left_of_a_run_is_drawn_or_told(name, spoil):
    run = spoil(DRAWN[name])
    for command in COMMANDS[1:]:  # the report draws all that `post` does
        done = CliRunner().invoke(cli, [*command, str(run)])
        assert done.exit_code in (0, 1) and isinstance(done.exception, SystemExit | None), done.output


def test_a_small_file_that_says_it_is_large_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "results.nc"
    with netCDF4.Dataset(str(path), "w") as file:
        file.createDimension("time", 2_000_000_000_000)
        file.createVariable("time", "f8", ("time",), zlib=True, chunksizes=(1_000_000,))
        file.case = 'title = "large"'
    assert path.stat().st_size < 1e6
    with pytest.raises(CaseError, match=r"says that it holds 1\.6e\+04 GB, and has 0\.\d+ MB"):
        open_results(tmp_path)


def test_a_file_beyond_the_memory_of_this_machine_is_refused(tmp_path, monkeypatch):
    rng = np.random.default_rng(1)
    xr.Dataset({"a": ("n", rng.random(1_500_000))}, attrs={"case": ""}).to_netcdf(tmp_path / "results.nc")
    monkeypatch.setattr(stored, "find_free_memory", lambda: 2e7)
    with pytest.raises(CaseError, match=r"holds 0\.012 GB, .*this machine has 0\.02 GB of memory free"):
        open_results(tmp_path)


@pytest.mark.parametrize("part", [0.0, 0.1, 0.5, 0.99])
def test_a_file_that_was_cut_off_is_refused(tmp_path, whole, part):
    (tmp_path / "results.nc").write_bytes(whole[: int(part * len(whole))])
    with pytest.raises(CaseError, match=r"results\.nc cannot be read as NetCDF"):
        open_results(tmp_path)


def test_a_run_that_ended_before_a_record_is_told_from_one_that_was_never_started(tmp_path):
    (tmp_path / "case.toml").write_text("")
    with pytest.raises(CaseError, match=r"is not a run folder\. .*\(`fbcouple setup \S+ -o RUN`"):
        open_results(tmp_path)
    (tmp_path / "manifest.json").write_text("{}")
    with pytest.raises(CaseError, match=r"Run it first \(`fbcouple run "):
        open_results(tmp_path)
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs/run.jsonl").write_text("")
    with pytest.raises(CaseError, match=r"ended, or was ended, before it wrote any .*logs\)\. Fix the case"):
        open_results(tmp_path)
