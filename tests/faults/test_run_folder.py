"""A run folder from anybody: nothing outside of it is touched, nothing in it is taken that its case does not give."""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from click.testing import CliRunner, Result
from small_bed import BED, prepare

import fbcouple.launcher.launch
from fbcouple.case.changes import list_values
from fbcouple.case.load import load_case
from fbcouple.cli.main import cli
from fbcouple.errors import SolverError
from fbcouple.launcher.launch import launch
from fbcouple.launcher.resume import is_complete
from fbcouple.run_folder.checkpoint import list_checkpoints
from fbcouple.run_folder.checkpoint_index import read_index, write_index
from fbcouple.run_folder.manifest import hash_file, hash_text

LAW = "def beta(voidage, slip, diameter, density, viscosity):\n    return 1e-4 * diameter\n"


def call(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return prepare(tmp_path)


@pytest.fixture(scope="module")
def part_way(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that stopped with two checkpoints on one rank."""
    run = prepare(tmp_path_factory.mktemp("part-way"), ["checkpoint.every=5e-4"])
    launch(run, 1, lambda row: None, until=2e-3)
    assert len(list_checkpoints(run)) == 2
    return run


@pytest.fixture
def stopped(part_way: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(part_way, tmp_path / "stopped"))


def test_a_run_goes_on_without_its_logs(stopped: Path) -> None:
    shutil.rmtree(stopped / "logs")
    launch(stopped, 1, lambda row: None, resume=True)
    with xr.open_dataset(stopped / "results.nc") as results:
        assert results.attrs["complete"] and float(results["time"][0]) == 0.0


@pytest.fixture
def no_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fail the test if a mesh tool or a solver would be started."""
    for name in ("Job", "prepare_mesh", "resume_mesh"):
        monkeypatch.setattr(fbcouple.launcher.launch, name, lambda *_: pytest.fail("a solver was started"))


def make_link(path: Path, outside: Path) -> None:
    path.symlink_to(outside)


def make_broken_link(path: Path, outside: Path) -> None:
    path.symlink_to(outside.with_name("not-there"))


def make_second_name(path: Path, outside: Path) -> None:
    path.hardlink_to(outside)


def make_pipe(path: Path, outside: Path) -> None:
    os.mkfifo(path)


KINDS: dict[str, tuple[Callable[[Path, Path], None], str]] = {
    "link": (make_link, "is a link"),
    "broken link": (make_broken_link, "is a link"),
    "second name": (make_second_name, "has another name elsewhere"),
    "pipe": (make_pipe, "is a pipe, socket or device"),
}
PLACES = ["lock", "logs/launcher.log", "logs/failure.room", "results.nc.part", "CFD/system/decomposeParDict"]
PLAIN = [*((kind, "manifest.json.part") for kind in KINDS), *(("link", place) for place in PLACES)]
COMMANDS: dict[str, Callable[[Path], list[object]]] = {
    "run": lambda run: ["run", run],
    "run --trust": lambda run: ["run", run, "--trust", "--resume"],
    "post": lambda run: ["post", run],
    "report": lambda run: ["report", run],
    "claims": lambda run: ["claims", run],
    "batch": lambda run: ["batch", run, "--scheduler", "slurm", "--time", "01:00:00"],
    "doctor": lambda run: ["doctor", "--bundle", run],
    "setup": lambda run: ["setup", run, "-o", run],
}


@pytest.mark.usefixtures("no_solver")
@pytest.mark.parametrize(("kind", "place"), PLAIN)
def test_what_is_no_plain_file_is_refused(run, tmp_path, kind, place):
    outside = tmp_path / "precious"
    outside.write_text("years of work")
    make, words = KINDS[kind]
    make(run / place, outside)
    before = sorted(tmp_path.rglob("*"))
    result = call("run", run)
    assert result.exit_code == 1 and result.stderr.startswith(f"{run / place}: {words}"), result.output
    assert outside.read_text() == "years of work" and sorted(tmp_path.rglob("*")) == before


@pytest.mark.usefixtures("no_solver")
@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_refuses_a_link_that_leads_out(run, tmp_path, command, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    (run / "figures").symlink_to(tmp_path / "elsewhere")
    before = sorted(tmp_path.rglob("*"))
    result = call(*COMMANDS[command](run))
    assert result.exit_code == 1 and result.stderr == (
        f"{run / 'figures'}: is a link; in a run folder only plain files are allowed: put the file itself there.\n"
    )
    assert sorted(tmp_path.rglob("*")) == before


def test_a_name_with_a_line_break_is_told_on_one_line(run, tmp_path):
    (run / "a\nb").symlink_to(tmp_path)
    assert call("run", run).stderr.count("\n") == 1


def test_the_run_folder_itself_may_be_a_link(tmp_path):
    """To a scratch disk."""
    (tmp_path / "scratch").mkdir()
    (tmp_path / "here").symlink_to(tmp_path / "scratch")
    (tmp_path / "case.toml").write_text(BED)
    assert call("setup", tmp_path / "case.toml", "-o", tmp_path / "here/run").exit_code == 0
    (tmp_path / "link").symlink_to(tmp_path / "scratch/run")
    case = load_case(str(tmp_path / "link"))
    assert fbcouple.launcher.launch.require_unchanged(case, tmp_path / "link", trusted=False) == []


# What is done to a run folder -> a line of the refusal.
CHANGES: dict[str, tuple[str, str, str, str]] = {
    "density": ("DEM/particles.data", " 2500.0 ", " 250.0 ", "DEM/particles.data: has been changed since set-up"),
    "seed": ("case.toml", "seed = 1", "seed = 77", "case.toml: start.seed was 1 and is 77 now, since set-up"),
    "count": ("case.toml", "count = 250", "count = 260", "case.toml: particles.count was 250 and is 260 now"),
    "filter": ("case.toml", "filter_passes = 1", "filter_passes = 2", "exchange.filter_passes was 1 and is 2 now"),
}


@pytest.mark.usefixtures("no_solver")
@pytest.mark.parametrize("change", CHANGES)
def test_what_was_changed_since_set_up_is_refused(run, change):
    name, old, new, words = CHANGES[change]
    text = (run / name).read_text()
    assert old in text
    (run / name).write_text(text.replace(old, new))
    result = call("run", run)
    assert result.exit_code == 1 and words in result.stderr and len(result.stderr.splitlines()) == 1, result.stderr


@pytest.mark.usefixtures("no_solver")
def test_start_positions_that_are_not_the_cases_are_refused_whatever_the_manifest_says(run):
    """Who makes up a run folder makes up its hashes, too."""
    data = run / "DEM/particles.data"
    data.write_text(data.read_text().replace(" 2500.0 ", " 250.0 "))
    manifest = json.loads((run / "manifest.json").read_text())
    manifest["files"]["DEM/particles.data"] = hash_file(data)
    (run / "manifest.json").write_text(json.dumps(manifest))
    result = call("run", run)
    assert result.exit_code == 1 and f"{data}: is not what the case gives" in result.stderr


@pytest.mark.usefixtures("no_solver")
def test_the_last_digits_of_another_machine_are_no_change(run, monkeypatch):
    data = run / "DEM/particles.data"
    lines = data.read_text().splitlines(keepends=True)
    *row, x, y, z = lines[-1].split()
    lines[-1] = f"{' '.join(row)} {float(x) * (1 + 1e-15)!r} {y} {z}\n"
    manifest = json.loads((run / "manifest.json").read_text())
    data.write_text("".join(lines))
    manifest["files"]["DEM/particles.data"] = hash_file(data)
    (run / "manifest.json").write_text(json.dumps(manifest))
    assert fbcouple.launcher.launch.require_unchanged(load_case(str(run)), run, trusted=False) == []


@pytest.mark.usefixtures("no_solver")
@pytest.mark.parametrize("name", ["0x10", "00", "0.0", "inf", "1_0", "postProcessing", "processor-notes"])
def test_what_openfoam_could_take_for_a_time_is_refused(run, name):
    """It reads hexadecimal numbers and starts from the latest time that it finds."""
    (run / "CFD" / name).mkdir()
    result = call("run", run)
    assert result.exit_code == 1 and f"{run / 'CFD' / name}: is none of this case's decks" in result.stderr


def change_index(folder: Path, **changes: Any) -> None:
    """Write the index anew, as whoever made the checkpoint could, with all files that are there."""
    about = json.loads(json.loads((folder / "index.json").read_text())["index"]) | changes
    about.pop("format"), about.pop("files")
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != "index.json"]
    sums = {path.relative_to(folder).as_posix(): (path.stat().st_size, hash_file(path)) for path in files}
    write_index(folder, about, sums)


def add_deck(folder: Path) -> None:
    (folder / "CFD/system").mkdir()
    (folder / "CFD/system/controlDict").write_text('libs ("./checkpoints/notes.so");')


def add_field_of_the_start(folder: Path) -> None:
    (folder / "CFD/0").mkdir()
    shutil.copy(next(folder.glob("CFD/*/U")), folder / "CFD/0/U")


def add_code_to_a_field(folder: Path) -> None:
    field = next(folder.glob("CFD/*/p"))
    field.write_bytes(field.read_bytes().replace(b"zeroGradient;", b'zeroGradient; libs ("./notes.so");', 1))


def add_mesh(folder: Path) -> None:
    mesh = next(folder.glob("CFD/*/uniform")).with_name("polyMesh")
    mesh.mkdir()
    (mesh / "points").write_text("")


FORGERIES: dict[str, tuple[Callable[[Path], None], dict[str, Any], str]] = {
    "deck": (add_deck, {}, '"CFD/system/controlDict" is in it, which no checkpoint has'),
    "start": (add_field_of_the_start, {}, "its fields are of the times 0, "),
    "code": (add_code_to_a_field, {}, "holds 'libs', which is in no field that fbcouple saves"),
    "mesh": (add_mesh, {}, 'polyMesh/points" is in it, which no checkpoint has'),
    "ranks": (lambda folder: None, {"ranks": 3000}, "index.json says 3000 ranks, and there are files of 1"),
    "no ranks": (lambda folder: None, {"ranks": 0}, "index.json says 0 ranks"),
    "words": (lambda folder: None, {"ranks": "1"}, "index.json does not say what an index says"),
    "step": (lambda folder: None, {"step": 10**13}, "index.json is of step 10000000000000"),
    "time": (lambda folder: None, {"time": -1.0}, "at t = -1.0 s"),
}


LISTED = [*((name, True) for name in FORGERIES), *((name, False) for name in ("deck", "start", "code", "mesh"))]


@pytest.mark.usefixtures("no_solver")
@pytest.mark.parametrize(("forgery", "is_listed"), LISTED)
def test_a_checkpoint_holds_nothing_but_what_a_run_writes(stopped, forgery, is_listed):
    """Whether its index lists it or not."""
    spoil, changes, words = FORGERIES[forgery]
    before = hash_file(stopped / "CFD/system/controlDict")
    for folder in list_checkpoints(stopped):
        spoil(folder)
        if is_listed:
            change_index(folder, **changes)
    result = call("run", stopped, "--resume")
    assert result.exit_code == 1 and "Traceback" not in result.output and "no checkpoint is left" in result.stderr
    assert re.search(re.escape(words) if is_listed else "it was not written with|bytes, .* were written", result.stderr)
    assert hash_file(stopped / "CFD/system/controlDict") == before


@pytest.mark.usefixtures("no_solver")
def test_other_names_are_told_and_left_alone(stopped):
    """Neither loaded, nor counted among the newest two, nor removed; one with a line break not even shown as it is."""
    places = stopped / "checkpoints"
    good = [folder.name for folder in list_checkpoints(stopped)]
    (places / "step-notes.txt").write_text("x")
    shutil.copytree(places / good[0], places / "step-backup")
    broken = "step-9\nshell touch stolen\n#"
    (places / good[0]).rename(places / broken)
    assert [folder.name for folder in list_checkpoints(stopped)] == good[1:]
    result = call("run", stopped, "--resume", "--until", "1e-9")
    assert result.exit_code == 0, result.output
    told = [line for line in result.stdout.splitlines() if "is no checkpoint and is left alone" in line]
    assert len(told) == 3 and "step-9\\nshell" in "".join(told)
    assert {path.name for path in places.iterdir()} == {"step-notes.txt", "step-backup", good[1], broken}


@pytest.mark.usefixtures("no_solver")
def test_a_law_that_was_changed_between_stop_and_resume_is_refused(tmp_path, part_way):
    """Also where the changed code is trusted: a run has one law."""
    text = BED.replace("[exchange]", '[exchange]\ndrag = "own"\ndrag_file = "law.py"')
    (tmp_path / "case.toml").write_text(text)
    (tmp_path / "law.py").write_text(LAW)
    run = tmp_path / "run"
    done = call("setup", tmp_path, "-o", run, "--trust", "--force")
    assert done.exit_code == 0 and f"start it with `fbcouple run {run} --trust`" in done.stdout
    (run / "law.py").write_text(LAW.replace("1e-4", "5e-3"))
    refused = call("run", run)
    assert refused.exit_code == 1 and "--trust" in refused.stderr
    case = load_case(str(run))
    assert fbcouple.launcher.launch.require_unchanged(case, run, trusted=True) == ["law.py"]
    for folder in list_checkpoints(part_way):
        shutil.copytree(folder, run / "checkpoints" / folder.name)
        change_index(run / "checkpoints" / folder.name, inputs={"law.py": "0" * 64}, case={})
    result = call("run", run, "--trust", "--resume")
    assert result.exit_code == 1 and "it is of another case" in result.stderr
    for folder in list_checkpoints(run):
        change_index(folder, case=list_values(case))
    result = call("run", run, "--trust", "--resume")
    assert result.exit_code == 1 and "law.py has changed since; put back what the run had then" in result.stderr


def test_a_checkpoint_with_the_state_of_something_else_ends_in_words(stopped):
    for folder in list_checkpoints(stopped):
        (folder / "state.json").write_text("[]")
        change_index(folder)
    result = call("run", stopped, "--resume")
    assert result.exit_code == 1 and "does not hold the state of this run (TypeError: " in result.stderr
    assert "Traceback" not in result.stderr and len(result.stderr.splitlines()) == 1


DAMAGES: dict[str, Callable[[Path], object]] = {
    "truncated": lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]),
    "empty": lambda path: path.write_bytes(b""),
    "text": lambda path: path.write_text("hello"),
    "without a word of it": lambda path: xr.Dataset({"time": ("time", [1.0])}).to_netcdf(path),
    "without rows": lambda path: xr.Dataset({"time": ("time", [])}, attrs={"complete": 1}).to_netcdf(path),
    "of words": lambda path: xr.Dataset({"time": ("time", ["x"])}, attrs={"complete": "y"}).to_netcdf(path),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_results_that_cannot_be_read_are_not_complete(stopped, damage):
    said: list[str] = []
    (stopped / "results.nc").unlink()
    shutil.copyfile(stopped / "DEM/particles.data", stopped / "results.nc")
    DAMAGES[damage](stopped / "results.nc")
    assert not is_complete(stopped, load_case(str(stopped)), said.append)
    assert len(said) == 1 and said[0].startswith(f"{stopped / 'results.nc'}: cannot be read (") and "\n" not in said[0]


def test_a_run_goes_on_after_an_update_where_asked_to_and_says_so(stopped):
    """With results that are damaged besides, which are written anew."""
    (stopped / "results.nc").write_bytes(b"")
    for folder in list_checkpoints(stopped):
        told = json.loads(json.loads((folder / "index.json").read_text())["index"])["made_by"]
        change_index(folder, made_by=told | {"fbcouple": "0.0.9, sources 0123456789abcdef"})
    before = {path: path.read_bytes() for path in stopped.rglob("*") if path.is_file() and path.name != "lock"}
    result = call("run", stopped, "--resume")
    assert result.exit_code == 1 and "was written with other versions (fbcouple: 0.0.9, sources" in result.stderr
    assert "--accept-update" in result.stderr and "results.nc: cannot be read" in result.stdout
    assert {path: path.read_bytes() for path in stopped.rglob("*") if path.is_file() and path.name != "lock"} == before
    result = call("run", stopped, "--resume", "--accept-update", "--until", "3e-3")
    assert result.exit_code == 0, result.output
    with xr.open_dataset(stopped / "results.nc") as results:
        assert "s on: fbcouple: 0.0.9, sources 0123456789abcdef then, 0.1.0" in results.attrs["updates"]
        assert results.attrs["LIGGGHTS"].startswith("LIGGGHTS-PUBLIC") and results.attrs["numpy"]
    assert len(json.loads((stopped / "manifest.json").read_text())["run"]["updates"]) == 1
    index = json.loads(json.loads((list_checkpoints(stopped)[0] / "index.json").read_text())["index"])
    assert len(index["updates"]) == 1 and index["made_by"]["fbcouple"].startswith("0.1.0")


def move(run: Path) -> None:
    run.rename(run.with_name("elsewhere"))


def remove(run: Path) -> None:
    """In two steps: the run goes on writing into its folder while it is removed."""
    move(run)
    shutil.rmtree(run.with_name("elsewhere"), ignore_errors=True)


GONE: dict[str, tuple[Callable[[Path], object], str]] = {
    "moved": (move, "run: was moved or removed while a run was under way in it"),
    "lock": (lambda run: (run / "lock").unlink(), "run/lock: was removed or replaced while a run was under way"),
    "logs": (lambda run: shutil.rmtree(run / "logs"), "run/logs: was removed or replaced"),
    "removed": (remove, "run: was moved or removed"),
}


@pytest.mark.parametrize(
    "what",
    ["moved", "lock", pytest.param("logs", marks=pytest.mark.slow), pytest.param("removed", marks=pytest.mark.slow)],
)
def test_a_run_whose_folder_is_taken_away_ends_in_words(tmp_path, what):
    """And makes no folder anew where it was."""
    run = prepare(tmp_path, ["end_time=10.0", "checkpoint.every=2e-4", "checkpoint.moment_steps=1"])
    take_away, words = GONE[what]
    rows: list[dict] = []

    def watch(row: dict) -> None:
        rows.append(row)
        if len(rows) == 3:
            take_away(run)

    with pytest.raises(SolverError, match=words):
        launch(run, 1, watch)
    assert run.exists() == (what not in ("moved", "removed"))
    if what == "moved":
        launch(run.with_name("elsewhere"), 1, lambda row: None, resume=True, until=rows[-1]["time"] + 1e-3)


def test_a_checkpoint_of_somebody_else_is_resumed_only_where_it_is_trusted(stopped, tmp_path, monkeypatch):
    """LIGGGHTS reads its restart file without a check, and a checksum can be made by anybody."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "another"))
    before = {path: path.read_bytes() for path in stopped.rglob("*") if path.is_file() and path.name != "lock"}
    result = call("run", stopped, "--resume")
    newest = list_checkpoints(stopped)[0]
    assert result.exit_code == 1 and f"{newest}: was not written by you" in result.stderr
    assert str(tmp_path / "another/fbcouple/checkpoint-key") in result.stderr and "--trust" in result.stderr
    assert {path: path.read_bytes() for path in stopped.rglob("*") if path.is_file() and path.name != "lock"} == before
    result = call("run", stopped, "--resume", "--trust", "--until", "3e-3")
    assert result.exit_code == 0, result.output
    with xr.open_dataset(stopped / "results.nc") as results:
        assert results.attrs["updates"].endswith("s on: a checkpoint of another user or machine")
    assert read_index(list_checkpoints(stopped)[0]).own
    assert len(read_index(list_checkpoints(stopped)[0]).updates) == 1


@pytest.mark.usefixtures("no_solver")
def test_a_signature_holds_for_the_text_that_was_signed(stopped):
    newest = list_checkpoints(stopped)[0]
    outer = json.loads((newest / "index.json").read_text())
    other = outer["index"].replace('"ranks": 1', '"ranks":  1')
    assert other != outer["index"] and read_index(newest).own
    (newest / "index.json").write_text(json.dumps(outer | {"index": other, "sha256": hash_text(other)}))
    assert not read_index(newest).own
    assert call("run", stopped, "--resume").exit_code == 1
