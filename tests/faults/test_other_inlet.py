"""A run that goes on under another inlet: it is the run of a ramp that jumps there, its case and results say so, and
what a run cannot change is refused before anything is written."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
import xarray as xr
from click.testing import CliRunner
from small_bed import BED, find_differences, prepare
from test_resume_scenes import INLETS, SHORT_FORM

import fbcouple
from fbcouple.case.load import load_case
from fbcouple.cli.main import cli
from fbcouple.errors import CaseError
from fbcouple.launcher import change_case
from fbcouple.launcher.launch import launch
from fbcouple.run_folder.checkpoint import choose

SHORT = ["end_time=3e-3", "averages.start=0.0", "output.record_every=4e-4"]
BLOWN = ["gas.inlet_velocity=2.0"]
JET = "gas.inlets.2.ramp=[[0.0, 9.0], [1e-3, 9.0], [2e-3, 3.0]]"


@pytest.fixture(scope="module")
def part_way(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = prepare(tmp_path_factory.mktemp("part-way"), SHORT)
    launch(run, 1, lambda row: None, until=8e-4)
    return run


@pytest.fixture
def stopped(part_way: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(part_way, tmp_path / "stopped"))


def read_files(run: Path) -> dict[str, bytes]:
    return {str(p): p.read_bytes() for p in run.rglob("*") if p.is_file() and p.name != "lock"}


def read(run: Path) -> xr.Dataset:
    with xr.open_dataset(run / "results.nc") as results:
        return results.load()


def blow_harder(run: Path, ranks: int = 1, sets: list[str] | None = None) -> xr.Dataset:
    launch(run, ranks, lambda row: None, resume=True, sets=sets or BLOWN)
    return read(run)


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_it_is_the_run_of_a_ramp_that_jumps_there(stopped, tmp_path, ranks):
    """From the start, on as many ranks: bit for bit, where every step is one of DEM."""
    if ranks > 1:
        stopped = prepare(tmp_path / "ranks", SHORT)
        launch(stopped, ranks, lambda row: None, until=8e-4)
    results = blow_harder(stopped, ranks)
    case = load_case(str(stopped))
    (time,) = [float(results.attrs["inlet_changed_at"])]
    assert [speed for _, speed in case.gas.inlet_ramp] == [1.2, 1.2, 2.0] and case.gas.inlet_velocity is None
    assert case.gas.inlet_ramp[1][0] == pytest.approx(time, rel=2e-9)
    assert results.attrs["inlet_changes"].endswith("inlet: 1.2 m/s up to then, 2 m/s from then on")
    assert float(results["gas_inflow_error"].max()) < 1e-12 and results.attrs["complete"]
    ramp = BED.replace(SHORT_FORM, f"inlet_ramp = {[list(row) for row in case.gas.inlet_ramp]}\n")
    whole = prepare(tmp_path / "whole", SHORT, ramp)
    launch(whole, ranks, lambda row: None)
    of_fastest = {"inlet_velocity", "gas_mass_error", "gas_inflow_error", "gas_flux_error"}
    assert set(find_differences(stopped, whole)) <= of_fastest, "up to the change the fastest was another"
    speeds = results["inlet_velocity"].values[1:]
    assert speeds == pytest.approx(read(whole)["inlet_velocity"].values[1:], rel=1e-12)


@pytest.mark.slow
def test_inlets_change_one_by_one_and_again_and_resume_goes_on(tmp_path):
    """On two ranks and then one; the run that is stopped once more is the one that is not."""
    one = prepare(tmp_path / "one", [*INLETS, *SHORT], BED.replace(SHORT_FORM, ""))
    launch(one, 2, lambda row: None, until=4e-4)
    other = Path(shutil.copytree(one, tmp_path / "other"))
    launch(one, 1, lambda row: None, resume=True, sets=[JET, "gas.inlets.1.velocity=0.9"])
    launch(other, 1, lambda row: None, resume=True, until=1.2e-3, sets=[JET, "gas.inlets.1.velocity=0.9"])
    launch(other, 1, lambda row: None, resume=True)
    assert find_differences(one, other) == []
    results, gas = read(one), load_case(str(one)).gas
    told = results.attrs["inlet_changes"].splitlines()
    assert len(told) == 2 and told[0].endswith("inlet 1: 0.6 m/s up to then, 0.9 m/s from then on")
    assert "9 m/s from then on, and 2 rows of a ramp after it" in told[1]
    assert gas.inlets[1].ramp[-1] == (2e-3, 3.0) and gas.inlets[2].velocity == 0.5
    assert float(results["gas_inflow_error"].max()) < 1e-12


WARM = [
    *("heat.gas_temperature=400.0", "heat.gas_specific_heat=1010.0", "heat.prandtl=0.7"),
    *("heat.particle_temperature=300.0", "heat.particle_specific_heat=840.0"),
]
CLOSED = [*SHORT, *WARM, "gas.max_step=1e-6", "gas.inlet_velocity=0.0"]  # each step is one of DEM
IDEAL = "heat.gas_density=ideal"
STEEL = "heat.walls=[{face='left', temperature=350.0}]"


@pytest.mark.parametrize("more", [[], [STEEL, IDEAL]], ids=["adiabatic", "ideal-gas"])
def test_gas_that_is_let_in_at_last_has_its_own_temperature(tmp_path, more):
    """The bed has cooled the gas before: what comes in brings no heat but by conduction, counted from that temperature,
    and the run is that of a ramp that jumps there."""
    run = prepare(tmp_path / "closed", [*CLOSED, *more])
    launch(run, 1, lambda row: None, until=8e-4)
    results = blow_harder(run)
    assert float(results["inlet_velocity"][-1]) == pytest.approx(2.0, rel=1e-9)
    assert float(results["max_temperature"][-1]) == pytest.approx(400.0, abs=1.0)
    assert float(results["mean_gas_temperature"].min()) < 395.0, "there was cooler gas to come in"
    assert float(abs(results["heat_by_inlets"]).max()) < 0.02 * float(results["heat_given"].max())
    assert float(results["gas_inflow_error"].max()) < 1e-12
    ramp = [list(row) for row in load_case(str(run)).gas.inlet_ramp]
    text = BED.replace(SHORT_FORM, f"inlet_ramp = {ramp}\n")
    whole = prepare(tmp_path / "whole", [*CLOSED[:-1], *more], text)
    launch(whole, 1, lambda row: None)
    of_fastest = {"inlet_velocity", "gas_mass_error", "gas_inflow_error", "gas_flux_error", "gas_flux_height"}
    assert set(find_differences(run, whole)) <= of_fastest, "up to the change there was no fastest"


def test_an_inlet_that_is_a_hot_wall_stays_so(tmp_path):
    run = prepare(tmp_path, [*CLOSED, "heat.wall_temperature=350.0"])
    launch(run, 1, lambda row: None, until=1e-4)
    before = read_files(run)
    with pytest.raises(CaseError, match="the inlet lets no gas in at any time and is a wall with a temperature"):
        blow_harder(run)
    assert read_files(run) == before


REFUSED = {
    "gas.density=2.0": "--set: gas.density: is fixed once a run has begun; gas.inlet_velocity, gas.inlet_ramp",
    "gas.inlets.1.velocity=2.0": "--set: gas.inlets.1.velocity: the case has 0 inlets",
    "gas.inlet_velocity=-2.0": "--set: gas.inlet_velocity: -2.0 is given",
    "gas.inlet_velocity=": "--set: gas.inlet_velocity: no value is given",
    "gas.inlet_ramp=[[0.0, 1.0], [-1.0, 2.0]]": "--set: gas.inlet_ramp",
    "output.save_every=-1": "--set: output.save_every",
}


@pytest.mark.parametrize("setting", REFUSED)
def test_what_a_run_cannot_change_is_told_before_anything_is_written(stopped, setting):
    before = read_files(stopped)
    result = CliRunner().invoke(cli, ["run", str(stopped), "--resume", "--set", setting])
    assert result.exit_code == 1 and REFUSED[setting] in result.stderr, result.output
    assert read_files(stopped) == before


def test_a_change_needs_a_run_that_goes_on(tmp_path, stopped):
    result = CliRunner().invoke(cli, ["run", str(stopped), "--set", BLOWN[0]])
    assert result.exit_code == 2 and "give --resume with it" in result.stderr
    with pytest.raises(CaseError, match="has no checkpoint, from which its inlet could be another"):
        blow_harder(prepare(tmp_path / "new", SHORT))
    launch(stopped, 1, lambda row: None, resume=True, until=8e-4, sets=BLOWN)
    assert load_case(str(stopped)).gas.inlet_velocity == 1.2, "nothing was left to do"


@pytest.mark.slow
def test_an_inlet_that_is_wall_stays_so(tmp_path):
    sets = [INLETS[0].replace("velocity=0.5", "velocity=0.0"), *SHORT]
    run = prepare(tmp_path, sets, BED.replace(SHORT_FORM, ""))
    launch(run, 1, lambda row: None, until=1e-4)
    with pytest.raises(CaseError, match="inlet 3 lets no gas in at any time and is wall; set up another run"):
        blow_harder(run, sets=["gas.inlets.3.velocity=1.0"])


def test_an_inlet_that_was_changed_by_hand_is_told_how(stopped):
    path = stopped / "case.toml"
    path.write_text(path.read_text().replace("inlet_velocity = 1.2", "inlet_velocity = 1.3"))
    with pytest.raises(
        CaseError,
        match=r"1.2 and is 1.3 now, since set-up; a run that has begun gets another inlet by .* --resume --set",
    ):
        launch(stopped, 1, lambda row: None, resume=True)


def test_another_setting_lets_no_inlet_by_that_was_changed_by_hand(stopped):
    path = stopped / "case.toml"
    path.write_text(path.read_text().replace("inlet_velocity = 1.2", "inlet_ramp = [[0.0, 1.2], [1.0, 9.0]]"))
    before = read_files(stopped)
    with pytest.raises(CaseError, match="since set-up"):
        launch(stopped, 1, lambda row: None, resume=True, sets=["end_time=4e-3"])
    assert read_files(stopped) == before


def test_a_deck_that_was_changed_by_hand_stays_so(stopped):
    """With trust a run goes on with it; the other decks are written as the case wants them."""
    deck = stopped / "CFD/system/fvSchemes"
    deck.write_text(deck.read_text() + "// mine\n")
    case = load_case(str(stopped))
    change_case.change_case(stopped, case, change_case.ask(case, ["end_time=4e-3"], stopped), None)
    assert deck.read_text().endswith("// mine\n") and load_case(str(stopped)).end_time == 4e-3


@pytest.mark.parametrize("cut", ["write_whole", pytest.param("write_manifest", marks=pytest.mark.slow)])
def test_a_change_that_is_cut_short_is_made_by_the_same_command(stopped, monkeypatch, cut):
    with monkeypatch.context() as patched:
        patched.setattr(change_case, cut, lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            blow_harder(stopped)
    assert load_case(str(stopped)).gas.inlet_ramp is not None
    with pytest.raises(CaseError, match="--resume --set"):
        launch(stopped, 1, lambda row: None, resume=True)
    results = blow_harder(stopped)
    assert len(load_case(str(stopped)).gas.inlet_ramp) == 3 and results.attrs["complete"]
    manifest = json.loads((stopped / "manifest.json").read_text())
    assert len(manifest["inlet_changes"]) == 1 and manifest["case"]["gas.inlet_velocity"] is None
    assert "inlet_ramp" in manifest["in"]


def test_from_python_with_a_later_end(stopped):
    run = fbcouple.Run(stopped)
    with pytest.raises(CaseError, match=r"end_time: 0\.0010001 s is given, and the run has come to t = "):
        run.resume(values={"gas.inlet_velocity": 2.0, "end_time": 1.0001e-3}, progress=False)
    status = run.resume(values={"gas.inlet_velocity": 2.0, "end_time": 2e-3}, progress=False)
    assert status.state == "complete" and status.end_time == 2e-3
    status = run.resume(values={"gas.inlet_velocity": 1.5, "end_time": 2.3e-3}, progress=False)
    assert status.state == "complete" and len(run.results().attrs["inlet_changed_at"]) == 2
    assert [speed for _, speed in run.case.gas.inlet_ramp] == [1.2, 1.2, 2.0, 2.0, 1.5]
    status = run.resume(values={"gas.inlet_velocity": 1.5, "end_time": 2.6e-3}, progress=False)
    assert status.state == "complete" and len(run.results().attrs["inlet_changed_at"]) == 2, "the same is no change"
    assert [speed for _, speed in run.case.gas.inlet_ramp] == [1.2, 1.2, 2.0, 2.0, 1.5]


WORDS = r"end_time: 0.0006 s is given, and the run has come to t = 0.00\d+ s, its newest checkpoint; give a later one"


@pytest.mark.parametrize("way", ["--set", "python", "file"])
def test_a_run_cannot_end_before_its_checkpoint(stopped, way):
    """It was called done, with a window of its means that ends after it; nothing is written, and it can go on."""
    if way == "file":
        file = stopped / "case.toml"
        file.write_text(file.read_text().replace("end_time = 0.003", "end_time = 0.0006"))
    before = read_files(stopped)
    with pytest.raises(CaseError, match=WORDS):
        if way == "--set":
            launch(stopped, 1, lambda row: None, resume=True, sets=["end_time=6e-4"])
        elif way == "python":
            fbcouple.Run(stopped).resume(values={"end_time": 6e-4}, progress=False)
        else:
            launch(stopped, 1, lambda row: None, resume=True)
    assert read_files(stopped) == before and not read(stopped).attrs["complete"]


def test_a_run_may_end_where_it_is(stopped):
    newest, _ = choose(stopped, load_case(str(stopped)))
    assert newest is not None
    reached = newest.time
    launch(stopped, 1, lambda row: None, resume=True, sets=[f"end_time={reached!r}"])
    results = read(stopped)
    assert results.attrs["complete"] and float(results["time"][-1]) == pytest.approx(reached, rel=1e-9)
    with pytest.raises(CaseError, match=r"has come to its end, .*; give a later end_time, too"):
        launch(stopped, 1, lambda row: None, resume=True, sets=["monitors.overlap=0.2"])
