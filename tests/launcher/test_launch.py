"""Starting real runs, and what is said when a program fails: its own words, exit code 3, nothing left hanging."""

from __future__ import annotations

import json
import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

from fbcouple.case.load import load_case
from fbcouple.cli.main import cli
from fbcouple.decks.render import set_up
from fbcouple.errors import CaseError, SolverError
from fbcouple.launcher.launch import launch

SOLIDS = """
title = "fifty particles"
end_time = 1e-3
[domain]
size = [0.01, 0.006, 0.02]
cells = [5, 3, 10]
[particles]
diameter = 1e-3
density = 2500.0
count = 50
[contact]
restitution = 0.97
wall_restitution = 0.97
friction = 0.1
wall_friction = 0.1
[start]
[averages]
start = 0.0
every = 1e-4
[output]
record_every = 2e-4
"""
COUPLED = f"""{SOLIDS}
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 0.5
[exchange]
filter_passes = 1
"""


def prepare(folder: Path, text: str) -> Path:
    (folder / "case.toml").write_text(text)
    run = folder / "run"
    set_up(load_case(str(folder / "case.toml")), run)
    return run


def spoil(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert text.count(old) == 1, f"{old!r} must stand in the deck once"
    path.write_text(text.replace(old, new))


def start(run: Path, ranks: int = 1, fresh: bool = False) -> list[dict]:
    rows: list[dict] = []
    launch(run, ranks, rows.append, fresh=fresh, trusted=True)
    return rows


def call(*arguments: object):
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


@pytest.fixture
def coupled(tmp_path):
    return prepare(tmp_path, COUPLED)


@pytest.fixture
def solids(tmp_path):
    return prepare(tmp_path, SOLIDS)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A coupled run of fifty particles to its end, and the rows that the watcher saw."""
    run = prepare(tmp_path_factory.mktemp("launch"), COUPLED)
    return run, start(run, ranks=2)


@pytest.fixture
def done(finished, tmp_path):
    """A copy of the finished run, to be spoiled."""
    return Path(shutil.copytree(finished[0], tmp_path / "done"))


def test_a_run_ends_with_results_and_every_row_was_seen(finished):
    run, rows = finished
    with xr.open_dataset(run / "results.nc") as data:
        assert data.attrs["complete"] == 1 and data.attrs["ranks"] == 2
        assert data["time"].values.tolist() == [row["time"] for row in rows]
        assert data["time"][0] == 0.0 and data["time"][-1] >= 1e-3 * (1 - 1e-9)
        assert (data["particles"] == 50).all()
        assert data["solids_volume"].values == pytest.approx(50 * np.pi / 6 * 1e-9, rel=1e-12)
        assert data["momentum_error"].max() < 1e-10
        assert np.isfinite(data["gas_flux"]).all()


def test_the_manifest_says_how_it_was_run(finished):
    manifest = json.loads((finished[0] / "manifest.json").read_text())
    assert manifest["run"]["ranks"] == 2 and manifest["run"]["command"][0] == "mpirun"
    assert (
        set(manifest["run"]["liggghts"]["can"]) >= {"particles", "coupling"}
        and not manifest["run"]["liggghts"]["cannot"]
    )
    assert manifest["particles"] == 50 and "couple" not in manifest["left_out"]


def test_a_scene_without_gas_starts_no_openfoam(solids, monkeypatch, tmp_path):
    """With a PATH that holds what mpirun wants and nothing of OpenFOAM."""
    (tmp_path / "bin").mkdir()
    for program in ("mpirun", "ssh"):
        (tmp_path / "bin" / program).symlink_to(shutil.which(program))
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    rows = start(solids)
    assert rows[-1]["particles"] == 50 and "pressure_drop" not in rows[-1]
    assert not (solids / "CFD").exists() and not (solids / "logs/openfoam.log").exists()


def test_results_are_not_overwritten_unless_asked(done):
    before = (done / "results.nc").read_bytes()
    with pytest.raises(CaseError, match=r"results\.nc.*--fresh starts again"):
        start(done)
    result = call("run", done)
    assert result.exit_code == 1 and "--fresh" in result.stderr
    assert (done / "results.nc").read_bytes() == before


def test_fresh_removes_the_results_before_it_starts(done):
    (done / "figures").mkdir()
    spoil(done / "CFD/system/blockMeshDict", "simpleGrading (1 1 1)", "simplerGrading (1 1 1)")
    spoil(done / "CFD/system/blockMeshDict", "vertices", "corners")
    with pytest.raises(SolverError, match="blockMesh failed"):
        start(done, fresh=True)
    assert not (done / "results.nc").exists() and not (done / "figures").exists()


def test_liggghts_own_words(solids):
    spoil(solids / "DEM/in.liggghts", "pair_coeff      * *", "pair_coeff      nonsense")
    with pytest.raises(SolverError) as caught:
        start(solids)
    assert str(caught.value).startswith("LIGGGHTS: ERROR: Numeric index is out of bounds")
    assert "logs/liggghts.log" in str(caught.value)
    assert not (solids / "results.nc").exists()


@pytest.mark.parametrize("ranks", [1, 2])
def test_words_of_liggghts_on_one_rank(solids, ranks):
    """It tells them on its screen alone, and the process is ended in the next moment."""
    data = solids / "DEM/particles.data"
    data.write_text("".join(data.read_text().splitlines(keepends=True)[:30]))
    with pytest.raises(SolverError, match=r"^LIGGGHTS: ERROR: Unexpected end of data file .*in logs/liggghts\.log"):
        start(solids, ranks)


def test_no_text_of_the_case_is_in_a_line_that_liggghts_cuts(tmp_path, monkeypatch):
    """It reads 255 bytes of a line: here are 105 letters of three bytes, and ranks whose locale has none of them."""
    for name, value in {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}.items():
        monkeypatch.setenv(name, value)
    text = SOLIDS.replace("fifty particles", "\u5e8a" * 105)
    run = prepare(tmp_path, text)
    assert max(map(len, (run / "DEM/particles.data").read_bytes().splitlines())) < 255
    start(run)
    with xr.open_dataset(run / "results.nc") as results:
        assert "\u5e8a" * 105 in results.attrs["case"]


def test_liggghts_own_words_on_the_command_line(coupled):
    spoil(coupled / "DEM/in.liggghts", "gran model hooke/stiffness tangential history\npair_coeff", "nix\npair_coeff")
    result = call("run", coupled, "-n", 2, "--trust")
    assert result.exit_code == 3
    assert result.stderr.startswith("LIGGGHTS: ERROR") and "pair style" in result.stderr
    assert "Traceback" not in result.stderr


def test_openfoams_own_words(coupled):
    spoil(coupled / "CFD/system/fvSchemes", "default         Euler;", "default         Oiler;")
    result = call("run", coupled, "--trust")
    assert result.exit_code == 3 and isinstance(result.exception, SystemExit)
    assert result.stderr.startswith("OpenFOAM: ") and "Oiler" in result.stderr and "Euler" in result.stderr


@pytest.mark.parametrize(
    ("deck", "old", "new", "word"),
    [
        ("constant/transportProperties", "\nnu ", "\nmu ", "nu"),
        ("0/p", "fixedValue", "fixedVallue", "fixedVallue"),
        ("constant/turbulenceProperties", "laminar", "lamniar", "lamniar"),
    ],
)
@pytest.mark.parametrize("ranks", [1, 2])
def test_openfoams_own_words_about_what_it_reads_at_the_start(coupled, ranks, deck, old, new, word):
    spoil(coupled / "CFD" / deck, old, new)
    with pytest.raises(SolverError, match=rf"(?s)(OpenFOAM|decomposePar).*\b{word}\b"):
        start(coupled, ranks)


def test_words_of_a_mesh_tool(coupled):
    spoil(coupled / "CFD/system/blockMeshDict", "vertices", "corners")
    with pytest.raises(
        SolverError, match=r"(?s)blockMesh failed with code 1 \(logs/mesh\.log\): --> FOAM FATAL.*vertices"
    ):
        start(coupled)
    assert "vertices" in (coupled / "logs/mesh.log").read_text()


def test_the_words_of_an_earlier_failure_are_forgotten(solids):
    deck = (solids / "DEM/in.liggghts").read_text()
    spoil(solids / "DEM/in.liggghts", "pair_coeff      * *", "pair_coeff      nonsense")
    with pytest.raises(SolverError, match="Numeric index"):
        start(solids)
    (solids / "DEM/in.liggghts").write_text(deck)
    assert start(solids)[-1]["particles"] == 50


def test_without_mpirun(solids, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SolverError, match="mpirun is not on the PATH; fix: sudo apt-get install openmpi-bin"):
        start(solids)
    assert call("run", solids).exit_code == 3


def test_without_openfoams_programs(coupled, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SolverError, match="blockMesh is not on the PATH; fix: sudo apt-get install openfoam"):
        start(coupled)


def test_a_worker_that_cannot_start_leaves_the_launchers_words(solids, monkeypatch, tmp_path):
    """A Python without the package: no rank can write a note, no solver has a log."""
    (tmp_path / "sitecustomize.py").write_text("raise SystemExit('no such luck')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    with pytest.raises(SolverError, match=r"(?s)without a word of its own; the MPI launcher said:.*no such luck"):
        start(solids)


@pytest.mark.parametrize("what", ["nothing", "no manifest"])
def test_a_folder_that_is_no_run_is_refused(tmp_path, what):
    run = tmp_path / "run"
    if what == "no manifest":
        run = prepare(tmp_path, SOLIDS)
        (run / "manifest.json").unlink()
    with pytest.raises(CaseError, match=r"not a run folder; make one with: fbcouple setup CASE -o "):
        start(run)


def test_until_ends_early_and_says_that_it_is_not_complete(tmp_path):
    solids = prepare(tmp_path, f"{SOLIDS}\n[checkpoint]\nmoment_steps = 1\n")
    result = call("run", solids, "--until", "3e-4")
    assert result.exit_code == 0, result.stderr
    assert "stopped at a moment for a checkpoint at or after 0.0003 s of 0.001 s; go on with" in result.stdout
    with xr.open_dataset(solids / "results.nc") as data:
        assert data.attrs["complete"] == 0 and 3e-4 * (1 - 1e-9) <= data.attrs["averaging_end"] < 5e-4
    result = call("run", solids, "--resume", "--until", "5e-3")
    assert result.exit_code == 0 and "go on with" not in result.stdout


def test_the_interpreter_of_the_parent_is_that_of_the_ranks(finished):
    assert sys.executable in json.loads((finished[0] / "manifest.json").read_text())["run"]["command"]
