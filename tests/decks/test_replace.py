"""A run folder is set up over an earlier set-up and over nothing else: what fbcouple did not write is never lost."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.decks import replace
from fbcouple.geometry.block import make_block
from fbcouple.geometry.foam_files import write_polymesh
from fbcouple.geometry.foam_text import FILES

CASE = """
title = "twenty particles"
end_time = 1e-3
[domain]
size = [0.01, 0.006, 0.02]
cells = [5, 3, 10]
[particles]
diameter = 1e-3
density = 2500.0
count = 18
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
"""
GAS = "[gas]\ndensity = 1.2\nviscosity = 2e-5\ninlet_velocity = 0.5\n[exchange]\n"
BESIDE = CASE.replace("count = 18", 'count = 18\npositions = "start.csv"').replace("[start]\n", "")
HOLD = """
import pathlib, sys
from fbcouple.run_folder.lock import hold
with hold(pathlib.Path(sys.argv[1])):
    print(flush=True)
    sys.stdin.read()
"""


def call(*arguments: object):
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


def write_case(folder: Path, text: str = CASE + GAS, shift: float = 0.0) -> Path:
    folder.mkdir()
    (folder / "case.toml").write_text(text)
    if "start.csv" in text:
        places = [(1e-3 + 1.2e-3 * i, 1e-3 + 1.2e-3 * j, 1e-3 + shift) for i in range(6) for j in range(3)]
        (folder / "start.csv").write_text("x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in places))
    return folder


def read_files(run: Path) -> dict[str, bytes]:
    return {path.relative_to(run).as_posix(): path.read_bytes() for path in run.rglob("*") if path.is_file()}


@pytest.fixture
def run(tmp_path):
    """A run folder whose particles start where a file beside the case says."""
    assert call("setup", write_case(tmp_path / "case", BESIDE), "-o", tmp_path / "run").exit_code == 0
    return tmp_path / "run"


@pytest.mark.parametrize("text", ['{"name": "a web page"}', '{"fbcouple": "0.1.0", "decks": {}}', "[]", "{", ""])
def test_a_folder_with_the_manifest_of_another_program_is_kept(tmp_path, text):
    page = tmp_path / "page"
    (page / "src").mkdir(parents=True)
    (page / "manifest.json").write_text(text)
    (page / "src/main.js").write_text("years of work")
    before = read_files(page)
    result = call("setup", write_case(tmp_path / "case"), "-o", page)
    assert result.exit_code == 1 and "page/manifest.json: was not written by this version of fbcouple" in result.stderr
    assert read_files(page) == before


def test_a_manifest_cannot_have_files_elsewhere_removed(tmp_path, run):
    (tmp_path / "thesis.tex").write_text("years of work")
    manifest = json.loads((run / "manifest.json").read_text())
    for name in ("../thesis.tex", str(tmp_path / "thesis.tex"), "logs/../../thesis.tex"):
        (run / "manifest.json").write_text(json.dumps(manifest | {"files": manifest["files"] | {name: "0" * 64}}))
        assert call("setup", tmp_path / "case", "-o", run).exit_code == 1
    assert (tmp_path / "thesis.tex").read_text() == "years of work"


def test_files_of_the_user_stay(run, tmp_path):
    mine = ("notes.md", "batch/slurm.sh", "CFD/notes.md", "measured/today.csv")
    for name in mine:
        (run / name).parent.mkdir(exist_ok=True)
        (run / name).write_text("measured on Tuesday")
    result = call("setup", write_case(tmp_path / "other"), "-o", run)
    assert result.exit_code == 0, result.output
    assert all((run / name).read_text() == "measured on Tuesday" for name in mine)
    assert not (run / "start.csv").exists() and (run / "CFD/system/controlDict").exists()
    assert call("setup", write_case(tmp_path / "solids", CASE), "-o", run).exit_code == 0
    assert {path.name for path in (run / "CFD").iterdir()} == {"notes.md"}


@pytest.mark.parametrize("name", ["start.csv", "case.toml"])
@pytest.mark.parametrize("known", [True, False])
def test_a_file_of_the_user_is_not_replaced_by_another(run, tmp_path, name, known):
    """Neither one that a set-up did not write, nor one that was changed since."""
    (run / name).write_text("measured on Tuesday")
    if not known:
        manifest = json.loads((run / "manifest.json").read_text())
        del manifest["files"][name]
        (run / "manifest.json").write_text(json.dumps(manifest))
    before = read_files(run)
    result = call("setup", write_case(tmp_path / "other", BESIDE, 1e-4), "-o", run)
    words = "was changed since set-up" if known else "is no file that fbcouple wrote"
    assert result.exit_code == 1 and f"{run / name}: {words} and would be replaced; move it elsewhere" in result.stderr
    assert read_files(run) | {"lock": b""} == before | {"lock": b""}


def test_a_changed_file_of_the_user_that_is_not_needed_any_more_stays(run, tmp_path):
    (run / "start.csv").write_text("measured on Tuesday")
    assert call("setup", write_case(tmp_path / "other"), "-o", run).exit_code == 0
    assert (run / "start.csv").read_text() == "measured on Tuesday"


def test_a_run_folder_is_set_up_in_place_with_its_own_files(run):
    before = read_files(run)
    result = call("setup", run, "-o", run)
    assert result.exit_code == 0 and read_files(run) | {"lock": b""} == before | {"lock": b""}
    case = (run / "case.toml").read_text()
    (run / "case.toml").write_text(case.replace("density = 2500.0", "density = 2600.0"))
    assert call("setup", run, "-o", run).exit_code == 0
    assert " 2600.0 " in (run / "DEM/particles.data").read_text()
    assert (run / "start.csv").read_bytes() == before["start.csv"]


def test_a_mesh_folder_is_set_up_in_place(tmp_path):
    domain = '[domain]\nshape = "file"\nmesh = "column"\nsize = [0.01, 0.01, 0.02]\ncells = [4, 4, 8]\n'
    lines = (CASE + GAS).split("[domain]")[0] + domain + "[gas]" + GAS.split("[gas]")[1].replace("[exchange]\n", "")
    folder = write_case(tmp_path / "case", lines)
    write_polymesh(make_block((0.01, 0.01, 0.02), (2, 2, 4), "prisms"), folder / "column")
    run = tmp_path / "run"
    assert call("setup", folder, "-o", run).exit_code == 0
    assert call("setup", run, "-o", run).exit_code == 0
    assert {path.name for path in (run / "column").iterdir()} == set(FILES)
    (folder / "column").rename(folder / "CFD")
    (folder / "case.toml").write_text(lines.replace('"column"', '"CFD"'))
    result = call("setup", folder, "-o", tmp_path / "other")
    assert result.exit_code == 1 and '"CFD" is given, which a run folder has of its own' in result.stderr


@pytest.mark.parametrize("trace", ["results.nc", "logs/run.jsonl", "checkpoints/step-000000000005/state.json"])
def test_a_folder_that_holds_a_run_is_kept(run, tmp_path, trace):
    (run / trace).parent.mkdir(parents=True, exist_ok=True)
    (run / trace).write_text("")
    result = call("setup", run, "-o", run)
    assert result.exit_code == 1 and "holds a run" in result.stderr


def test_a_folder_in_which_a_run_is_under_way_is_kept(run):
    before = read_files(run)
    holder = subprocess.Popen([sys.executable, "-c", HOLD, run], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert holder.stdout is not None
    holder.stdout.readline()
    result = call("setup", run, "-o", run)
    holder.communicate()
    assert result.exit_code == 69 and f"another run is under way in it (process {holder.pid}" in result.stderr
    assert read_files(run) | {"lock": b""} == before | {"lock": b""}


@pytest.mark.parametrize("last", ["DEM/particles.data", "DEM/in.liggghts", "case.toml"])
def test_a_set_up_that_was_cut_short_is_done_again(run, tmp_path, monkeypatch, last):
    other, move = write_case(tmp_path / "other"), os.replace
    (run / "notes.md").write_text("measured on Tuesday")

    def run_out_of_space(source: Path, target: Path) -> None:
        if target == run / last:
            raise OSError(28, "No space left on device")
        move(source, target)

    monkeypatch.setattr(replace.os, "replace", run_out_of_space)
    assert "cannot be written (No space left on device)" in call("setup", other, "-o", run).stderr
    monkeypatch.undo()
    refused = call("run", run)
    assert refused.exit_code == 1 and f"-o {run}" in refused.stderr, "half of one case and half of another"
    again = call("setup", other, "-o", run)
    assert again.exit_code == 0, again.stderr
    assert call("setup", other, "-o", tmp_path / "fresh").exit_code == 0
    manifests = [json.loads((folder / "manifest.json").read_text()) for folder in (run, tmp_path / "fresh")]
    assert manifests[0] == manifests[1] and (run / "notes.md").exists()
    expected = read_files(tmp_path / "fresh").keys() | {"notes.md", "lock"}
    assert read_files(run).keys() == expected
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []


def test_what_is_written_is_hashed_in_the_manifest(run):
    told = json.loads((run / "manifest.json").read_text())
    found = {name: hashlib.sha256(content).hexdigest() for name, content in read_files(run).items()}
    assert told["files"] == {name: value for name, value in found.items() if name != "manifest.json"}
    assert {"fbcouple", "commit", "python", "numpy", "machine"} <= told["set_up_with"].keys()
