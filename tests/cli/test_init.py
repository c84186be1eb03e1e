"""`fbcouple init`: a new case that is fit, says what it is, and runs."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner

from fbcouple.case.bed.derived import cell_size, fastest_inlet
from fbcouple.case.bed.drag_balance import minimum_fluidization, terminal_velocity
from fbcouple.case.bed.region import find_region
from fbcouple.case.kinds.registry import KINDS
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate
from fbcouple.cli.init import KIND_NAMES
from fbcouple.cli.main import cli
from fbcouple.results.reader import open_results


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(cli, [str(argument) for argument in arguments])


def list_files(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


@pytest.mark.parametrize("kind", ["bubbling", "column"])
@pytest.mark.parametrize("diameter", [0.2e-3, 0.5e-3, 1e-3, 3e-3, 10e-3])
def test_new_case_is_fit(call, tmp_path, diameter, kind):
    result = call("init", "beds/mine", "--diameter", diameter, "--kind", kind)
    assert result.exit_code == 0, result.stderr
    assert list_files(tmp_path) == ["beds/mine/case.toml"]
    case = load_case("beds/mine")
    assert [number for number in estimate(case) if number.verdict not in (None, "fit")] == []
    assert case.particles.diameter == diameter
    spacing = find_region(case).spacing / diameter
    assert 1.95 <= min(spacing) <= max(spacing) < 3.0
    assert case.gas.inlet_velocity == pytest.approx(2.0 * minimum_fluidization(case), rel=0.05)
    (overlap,) = (number.value for number in estimate(case) if number.name == "overlap")
    assert overlap == pytest.approx(0.03, rel=0.03)


@pytest.mark.parametrize("diameter", [0.5e-3, 1e-3, 3e-3])
def test_new_spout_is_fit(call, diameter):
    result = call("init", "spout", "--kind", "spout", "--diameter", diameter)
    assert result.exit_code == 0, result.stderr
    case = load_case("spout")
    assert [number for number in estimate(case) if number.verdict not in (None, "fit")] == []
    assert 2.0 <= min(cell_size(case)) / diameter <= max(cell_size(case)) / diameter < 3.0
    assert fastest_inlet(case.gas) == pytest.approx(1.3 * minimum_fluidization(case), rel=0.05)
    (overlap,) = (number.value for number in estimate(case) if number.name == "overlap")
    assert overlap == pytest.approx(0.03, rel=0.03)
    lines = Path("spout/case.toml").read_text().splitlines()
    assert not [line for line in lines if "]#" in line], "a comment stands apart from its value"
    assert max(map(len, lines)) <= 120


def test_options_reach_the_case(call):
    size = ("--size", 0.05, 0.012, 0.2)
    assert call("init", "mine", "--diameter", 2e-3, "--density", 1000, "--velocity", 1.5, *size).exit_code == 0
    case = load_case("mine")
    assert (case.particles.diameter, case.particles.density, case.gas.inlet_velocity) == (2e-3, 1000.0, 1.5)
    assert case.domain.size == (0.05, 0.012, 0.2) and case.domain.cells == (12, 3, 50)
    assert case.particles.mass == pytest.approx(0.25 * 0.6 * 1000 * 0.05 * 0.012 * 0.2)


def test_what_is_unfit_is_reported(call):
    result = call("init", "mine", "--velocity", 0.2)
    assert result.exit_code == 0 and "warn: minimum fluidization is 0.5601 m s-1" in result.stdout


def test_what_is_told_is_what_check_tells(call):
    """By the preset that the new case stands on."""
    told = call("init", "fine", "--diameter", 3e-5).stdout
    checked = {number.name: number for number in estimate(load_case("fine"), None, Path("fine"))}
    warned = {name for name, number in checked.items() if number.verdict not in (None, "fit")}
    assert set(re.findall(r"^(?:warn|unfit): (.*?) is ", told, re.MULTILINE)) == warned
    assert "DEM steps per fluid step" not in told


def test_next_commands_are_printed_and_are_right(call):
    result = call("init", "my beds/one")
    commands = [line.strip() for line in result.stdout.splitlines() if line.startswith("  fbcouple ")]
    assert commands == [
        "fbcouple check 'my beds/one'",
        "fbcouple setup 'my beds/one'",
        "fbcouple run runs/one -n 2",
        "fbcouple post runs/one",
    ]
    assert call("setup", "my beds/one").exit_code == 0 and Path("runs/one/case.toml").is_file()


def test_every_key_of_the_new_case_has_its_unit_or_a_comment_nearby(call):
    call("init", "mine")
    lines = Path("mine/case.toml").read_text().splitlines()
    assert sum("#" in line for line in lines) > 20 and max(map(len, lines)) <= 120
    assert tomllib.loads("\n".join(lines))["accuracy"] == "standard"


def test_case_that_is_there_is_kept(call):
    Path("mine").mkdir()
    Path("mine/case.toml").write_text("years")
    Path("mine/notes.txt").write_text("kept")
    result = call("init", "mine")
    assert result.exit_code == 1 and "is there already" in result.stderr
    assert Path("mine/case.toml").read_text() == "years"
    Path("mine/case.toml").unlink()
    Path("mine/case.toml").symlink_to("notes.txt")
    assert call("init", "mine").exit_code == 1 and Path("mine/notes.txt").read_text() == "kept"


def test_name_of_a_file_is_refused(call):
    Path("file").write_text("kept")
    result = call("init", "file/mine")
    assert result.exit_code == 1 and "cannot be written" in result.stderr


def test_box_that_is_too_small_writes_nothing(call, tmp_path):
    result = call("init", "mine", "--size", 0.0005, 0.1, 0.1)
    assert result.exit_code == 1 and "give a smaller particle" in result.stderr
    assert list_files(tmp_path) == []


@pytest.mark.parametrize("arguments", [("--diameter", 0), ("--kind", "spouted"), ("--size", 1, 1), ("--density", -1)])
def test_wrong_options_are_usage_errors(call, arguments):
    assert call("init", "mine", *arguments).exit_code == 2


def test_command_line_offers_every_kind():
    assert tuple(KINDS) == KIND_NAMES


@pytest.mark.parametrize(
    ("kind", "size", "count"), [("bubbling", (0.01, 0.004, 0.05), 573), ("column", (0.01, 0.01, 0.03), 675)]
)
def test_new_case_runs(call, kind, size, count):
    """A small part of it, for some steps, through both solvers."""
    assert call("init", "mine", "--kind", kind, "--size", *size).exit_code == 0
    result = call("setup", "mine", "--set", "end_time=0.01", "--set", "output.record_every=0.002")
    assert result.exit_code == 0 and "no averages are taken" in result.stdout
    result = call("run", "runs/mine")
    assert result.exit_code == 0, result.output
    data = open_results(Path("runs/mine")).data
    assert data.attrs["complete"] == 1 and data.time[-1] >= 0.01
    assert float(data.pressure_drop[-1]) > 0.0 and set(data.particles.values) == {count}


@pytest.mark.parametrize("diameter", [0.3e-3, 1e-3, 3e-3])
def test_new_riser_is_fit(call, diameter):
    result = call("init", "riser", "--kind", "riser", "--diameter", diameter)
    assert result.exit_code == 0 and "starts empty, fed with particles" in result.stdout, result.stderr
    case = load_case("riser")
    assert [number for number in estimate(case) if number.verdict not in (None, "fit")] == []
    settling, (feed,) = terminal_velocity(case), case.particles.feeds
    assert case.gas.inlet_velocity == pytest.approx(1.5 * settling, rel=0.05)
    width, depth, _ = case.domain.size
    fraction = feed.mass_flow / (2500.0 * width * depth * (case.gas.inlet_velocity - settling))
    assert fraction == pytest.approx(0.02, rel=1e-3)


def test_a_low_riser_is_fed_too(call):
    assert call("init", "riser", "--kind", "riser", "--size", 0.01, 0.01, 0.01).exit_code == 0
    assert load_case("riser").particles.feeds[0].high == (0.01, 0.01, 0.002)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [(("--velocity", 2.0), r"more than 6\.76\d* m s-1 is allowed"), (("--bed-height", 0.05), "a riser starts empty")],
)
def test_a_riser_that_carries_nothing_is_refused(call, tmp_path, arguments, told):
    result = call("init", "riser", "--kind", "riser", *arguments)
    assert result.exit_code == 1 and re.search(told, result.stderr) and list_files(tmp_path) == []


def test_new_riser_runs(call):
    """A short one, until the first particles leave by its top."""
    assert call("init", "mine", "--kind", "riser", "--size", 0.01, 0.01, 0.02).exit_code == 0
    assert call("setup", "mine", "--set", "end_time=0.02", "--set", "output.record_every=0.005").exit_code == 0
    result = call("run", "runs/mine")
    assert result.exit_code == 0, result.output
    data = open_results(Path("runs/mine")).data
    fed, gone = data.particles_fed.values[-1], data.particles_removed.values[-1]
    assert fed > gone > 0 and fed - gone == data.particles.values[-1] and data.ledger_error.max() < 1e-13


def test_new_spout_runs(call):
    """A narrow one, whose slot is less than a cell wide."""
    assert call("init", "mine", "--kind", "spout", "--size", 0.012, 0.004, 0.05).exit_code == 0
    sets = [part for text in ("end_time=0.01", "output.record_every=0.002") for part in ("--set", text)]
    assert call("setup", "mine", *sets).exit_code == 0
    result = call("run", "runs/mine")
    assert result.exit_code == 0, result.output
    data = open_results(Path("runs/mine")).data
    assert data.attrs["complete"] == 1 and float(data.gas_inflow_error.max()) < 1e-9


def test_set_up_makes_the_folders_above_the_run(call, tmp_path):
    assert call("init", "mine").exit_code == 0
    assert call("setup", "mine", "-o", "a/b/c").exit_code == 0
    assert (tmp_path / "a/b/c/case.toml").is_file() and [path.name for path in (tmp_path / "a/b").iterdir()] == ["c"]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--diameter", 3), r"3 m is given, at most 0\.05 m is allowed; .* write 3 mm as 0\.003"),
        (("--diameter", 0.3), r"0\.3 m is given, .* write 0\.3 mm as 0\.0003"),
        (("--size", 40, 8, 100), r"40 m is given, at most 30 m is allowed; .* write 40 mm as 0\.04"),
        (("--size", 8, 2, 20), r"particles need about .* Lengths are in m"),
        (("--bed-height", 50), r"50 m is given, at most 30 m is allowed; .* write 50 mm as 0\.05"),
    ],
)
def test_lengths_in_millimetres_are_refused_with_the_mend(call, tmp_path, arguments, told):
    result = call("init", "mine", *arguments)
    assert result.exit_code in (1, 2) and re.search(told, " ".join(result.stderr.split())), result.stderr
    assert list_files(tmp_path) == []


def test_bed_height_gives_the_mass_and_a_box_with_room_above(call):
    result = call("init", "mine", "--bed-height", 0.05)
    assert result.exit_code == 0, result.stderr
    case = load_case("mine")
    width, depth, height = case.domain.size
    assert (width, depth, height) == (0.04, 0.008, 0.2)
    assert case.particles.mass == pytest.approx(0.6 * 2500 * 0.05 * width * depth, rel=1e-3)
    (settled,) = (number.value for number in estimate(case) if number.name == "settled height")
    assert settled == pytest.approx(0.05, rel=1e-3)
    (count,) = (number.value for number in estimate(case) if number.name == "particles")
    assert f"{count} particles of 1 mm" in result.stdout


def test_bed_that_fills_its_box_is_refused(call, tmp_path):
    result = call("init", "mine", "--size", 0.05, 0.01, 0.1, "--bed-height", 0.09)
    assert result.exit_code == 1 and "at most 0.08 m is allowed in a box 0.1 m high" in result.stderr
    assert list_files(tmp_path) == []


def test_bed_height_of_a_spout(call):
    assert call("init", "mine", "--kind", "spout", "--bed-height", 0.05).exit_code == 0
    case = load_case("mine")
    (settled,) = (number.value for number in estimate(case) if number.name == "settled height")
    assert settled == pytest.approx(0.05, rel=1e-3) and case.domain.size[2] == pytest.approx(0.25)
