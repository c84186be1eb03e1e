"""The command line: every mistake on its own line of stderr, exit code 1, no traceback, nothing written."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import fbcouple
from fbcouple.case.load import load_case
from fbcouple.case.source import list_sets, list_shipped
from fbcouple.doctor import checks as doctor
from fbcouple.errors import CaseError, DivergedError, SolverError

PARTICLE = """
end_time = 1
[domain]
size = [1, 1, 1]
cells = [4, 4, 4]
[particles]
diameter = 0.1
density = 1000
count = 1
[start]
[contact]
restitution = 1
wall_restitution = 1
friction = 0
wall_friction = 0
"""
BROKEN = {
    "wrong key": (("density = 2500.0", "densty = 2500.0"), "particles.densty", "did you mean `density`"),
    "wrong type": (("mass = 0.075", 'mass = "75 g"'), "particles.mass", "give a bare number"),
    "negative diameter": (("diameter = 1e-3", "diameter = -1e-3"), "particles.diameter", "a number above 0 (in m)"),
    "particle larger than the box": (("diameter = 1e-3", "diameter = 1"), "particles.diameter", "smaller particle"),
    "more mass than fits": (("mass = 0.075", "mass = 75"), "particles.mass", "give less, in kg"),
    "unknown drag law": (("[exchange]", '[exchange]\ndrag = "di-felise"'), "exchange.drag", "give the name of one"),
}


def start(folder: Path, *arguments: object, **variables: str) -> subprocess.CompletedProcess[str]:
    """Start the command line in a process of its own, in `folder`."""
    root = str(Path(fbcouple.__file__).parents[1])
    command = [sys.executable, "-m", "fbcouple.cli.main", *map(str, arguments)]
    return subprocess.run(
        command,
        cwd=folder,
        env={"PYTHONPATH": root, "PATH": "", **variables},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )


@pytest.mark.parametrize("mistake", BROKEN)
@pytest.mark.parametrize("command", ["check", "setup"])
def test_broken_case(spoil, call, tmp_path, command, mistake):
    replacement, key, mend = BROKEN[mistake]
    path = spoil(replacement)
    result = call(command, "case.toml")
    assert result.exit_code == 1 and result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert line.startswith(f"case.toml: {key}: ") and mend in line
    assert list(tmp_path.iterdir()) == [path]


def test_several_mistakes_in_a_process_of_its_own(spoil, tmp_path):
    path = spoil(*(BROKEN[name][0] for name in ("wrong key", "negative diameter", "unknown drag law")))
    done = start(tmp_path, "setup", "case.toml", "--set", "gas.walls=moving", "-o", "out/run")
    assert done.returncode == 1 and done.stdout == ""
    assert sorted(line.split(": ")[1] for line in done.stderr.splitlines()) == [
        "exchange.drag",
        "gas.walls",
        "particles.densty",
        "particles.diameter",
    ]
    assert list(tmp_path.iterdir()) == [path]


def test_missing_file_in_a_process_of_its_own(tmp_path):
    done = start(tmp_path, "check", "nowhere.toml")
    assert done.returncode == 1 and done.stdout == ""
    assert done.stderr.startswith('"nowhere.toml": neither a shipped case nor a file')
    assert "fbcouple cases" in done.stderr
    assert len(done.stderr.splitlines()) == 1 and list(tmp_path.iterdir()) == []


def test_bytes_that_are_no_text_in_a_process_of_its_own(tmp_path):
    done = start(tmp_path, "check", "patil/c2", "--set", "title=\udcff")
    assert done.returncode == 1 and "not UTF-8" in done.stderr and "Traceback" not in done.stderr


ASCII = {"PYTHONIOENCODING": "ascii"}, {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
TABLE = """
from fbcouple.cli import main
from fbcouple.cli.table import print_table
main.cli = lambda prog_name: print_table(["letter"], [[chr(0x5E8A)]])
main.main()
"""


@pytest.mark.parametrize("locale", ASCII)
def test_letters_that_the_locale_has_not(tmp_path, locale):
    """Files are read and written as in any other locale; a mistake is told."""
    title = 'title = "b\u00e9d \u5e8a"\n'
    (tmp_path / "case.toml").write_text(title + PARTICLE, encoding="utf-8")
    done = start(tmp_path, "setup", "case.toml", "-o", "run", "--explain", **locale)
    assert done.returncode == 0, done.stderr
    assert title in (tmp_path / "run/case.toml").read_text(encoding="utf-8")
    (tmp_path / "case.toml").write_text(f'"d\u5e8a" = 1\n{title}{PARTICLE}', encoding="utf-8")
    done = start(tmp_path, "check", "case.toml", **locale)
    assert done.returncode == 1 and done.stderr.startswith("case.toml: d"), done.stderr
    assert "a case file has no such key" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.parametrize("locale", ASCII)
def test_letters_that_the_terminal_has_not_are_told_by_their_numbers(tmp_path, locale):
    environment = {"PYTHONPATH": str(Path(fbcouple.__file__).parents[1]), "PATH": "", **locale}
    done = subprocess.run(
        [sys.executable, "-c", TABLE], env=environment, cwd=tmp_path, capture_output=True, check=False
    )
    assert done.returncode == 0 and b"\\u5e8a" in done.stdout, done.stderr


def test_usage_errors_are_2(call):
    assert call("check").exit_code == 2
    assert call("chek").exit_code == 2
    assert call("run", "x", "-n", "0").exit_code == 2
    assert call("run", "x", "--until", "nan").exit_code == 2


def test_check_prints_the_numbers(call):
    result = call("check", "patil/c2")
    assert result.exit_code == 0 and result.stderr == ""
    rows = {line.split("  ")[0]: line for line in result.stdout.splitlines()}
    assert "57296" in rows["particles"] and "612.8" in rows["pressure drop"] and "0.54 " in rows["minimum fluidization"]


def test_check_of_an_unfit_case_fails_as_its_set_up_does(call, tmp_path):
    """A stiffness with which particles pass through each other: the table is there, and what is unfit is named."""
    result = call("check", "patil/c2", "--set", "contact.stiffness=0.1")
    assert result.exit_code == 1 and "57296" in result.stdout
    mend = r"at most 0\.05 is fit; fix the case; `setup` refuses it without --force\.\n"
    assert re.fullmatch(rf"patil/c2: overlap: \d\.\d+ d, {mend}", result.stderr)
    assert call("setup", "patil/c2", "--set", "contact.stiffness=0.1", "-o", str(tmp_path / "run")).exit_code == 1


def test_cases_lists_the_shipped_ones(call):
    result = call("cases")
    assert result.exit_code == 0
    for name in (*list_shipped(), *list_sets()):
        assert name in result.stdout


def test_setup_of_a_set_is_one_folder_of_runs(call, tmp_path):
    result = call("setup", "patil/turbulence", "--set", "end_time=2.0")
    assert result.exit_code == 0, result.stderr
    runs = tmp_path / "runs/patil-turbulence"
    assert sorted(path.name for path in runs.iterdir()) == ["patil-a1", "patil-c6", "patil-c6-smagorinsky"]
    cases = [load_case(str(path)) for path in sorted(runs.iterdir())]
    assert [case.gas.turbulence for case in cases] == ["none", "localized-dynamic", "smagorinsky"]
    assert {case.end_time for case in cases} == {2.0}


def test_setup_of_a_set_with_a_mistake_writes_nothing(call, tmp_path):
    assert call("setup", "patil/turbulence", "--set", "gas.densty=1").exit_code == 1
    assert list(tmp_path.iterdir()) == []


def test_setup_of_a_set_keeps_a_run_that_has_results(call, tmp_path):
    kept = tmp_path / "set/patil-a1"
    kept.mkdir(parents=True)
    (kept / "results.nc").write_bytes(b"kept")
    result = call("setup", "patil/turbulence", "-o", tmp_path / "set")
    assert result.exit_code == 1 and "patil-a1" in result.stderr
    assert [path.name for path in (tmp_path / "set").iterdir()] == ["patil-a1"]


def test_setup_names_the_run_after_the_case(call):
    result = call("setup", "patil/demo", "--set", "end_time=1.5", "--explain")
    assert result.exit_code == 0, result.stderr
    assert "closed_nozzle" in result.stdout and "rotation" in result.stdout
    assert load_case("runs/patil-demo").end_time == 1.5
    assert call("setup", "patil/demo").exit_code == 0
    assert load_case("runs/patil-demo").end_time == 2.0


def test_setup_refuses_a_folder_with_results(call, tmp_path):
    run = tmp_path / "run"
    assert call("setup", "patil/demo", "-o", run).exit_code == 0
    (run / "results.nc").write_bytes(b"kept")
    result = call("setup", "patil/demo", "-o", run)
    assert result.exit_code == 1 and "results.nc" in result.stderr
    assert (run / "results.nc").read_bytes() == b"kept"


def test_setup_refuses_a_foreign_folder(call, tmp_path):
    (tmp_path / "thesis.tex").write_text("years")
    result = call("setup", "patil/demo", "-o", tmp_path)
    assert result.exit_code == 1 and str(tmp_path) in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_setup_into_a_file_is_refused(call, tmp_path):
    (tmp_path / "file").write_text("kept")
    result = call("setup", "patil/demo", "-o", tmp_path / "file" / "run")
    assert result.exit_code == 1 and "give another folder with -o" in result.stderr


def test_setup_keeps_the_positions_beside_the_case(spoil, call, tmp_path):
    path = spoil(("[start]\n", ""), ("mass = 0.075", 'count = 2\npositions = "seed.csv"'))
    (tmp_path / "seed.csv").write_text("x,y,z\n0.02,0.005,0.01\n0.03,0.005,0.01\n")
    assert call("setup", path, "-o", tmp_path / "run").exit_code == 0
    assert load_case(str(tmp_path / "run")) == load_case(str(path))
    atoms = [line.split() for line in (tmp_path / "run/DEM/particles.data").read_text().splitlines()]
    np.testing.assert_array_equal(np.array(atoms[-1][-3:], dtype=float), [0.03, 0.005, 0.01])


@pytest.mark.parametrize("command", ["run", "post"])
def test_folder_that_is_no_run(call, tmp_path, command):
    result = call(command, tmp_path / "nothing")
    assert result.exit_code == 1 and "nothing" in result.stderr


def test_run_hands_its_options_to_the_launcher(call, tmp_path, monkeypatch):
    asked = []

    def launch(run, ranks, watch, until, fresh, **others):
        asked.append((run, ranks, until, fresh))
        for step in range(3):
            watch({"time": 0.01 * step, "steps": step, "wall": {"dem": 2.0, "cfd": 1.0, "map": 1.0}})

    monkeypatch.setattr("fbcouple.launcher.launch.launch", launch)
    assert call("setup", "patil/demo", "-o", "run").exit_code == 0
    result = call("run", "run", "-n", 2, "--until", 0.02, "--fresh")
    assert result.exit_code == 0 and asked == [(Path("run"), 2, 0.02, True)]
    assert ["dem", "6.0", "50.0", "%"] in [line.split() for line in result.stdout.splitlines()]
    assert "of which not in a solver" in result.stdout and "25.0 %" in result.stdout


def test_until_that_no_moment_for_a_checkpoint_follows_is_told(call, monkeypatch):
    monkeypatch.setattr("fbcouple.launcher.launch.launch", lambda *_, **__: None)
    before_and_after = iter([False, True])
    monkeypatch.setattr("fbcouple.launcher.resume.is_complete", lambda *_: next(before_and_after, True))
    assert call("setup", "patil/demo", "-o", "run").exit_code == 0
    result = call("run", "run", "--until", 0.02)
    assert "no moment for a checkpoint came from --until 0.02 s to the end of the run" in result.stdout
    assert "checkpoint.moment_steps" in result.stdout and "where the time went" not in result.stdout
    assert "--until" not in call("run", "run").stdout
    assert "--until" not in call("run", "run", "--until", 0.02).stdout, "it had come to its end before"


@pytest.mark.parametrize(
    ("error", "code"), [(CaseError(["a", "b"]), 1), (SolverError("a\nb"), 3), (DivergedError("a\nb"), 4)]
)
def test_errors_have_their_exit_codes(call, monkeypatch, error, code):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr("fbcouple.launcher.launch.launch", fail)
    assert call("setup", "patil/demo", "-o", "run").exit_code == 0
    result = call("run", "run")
    assert result.exit_code == code and result.stderr == "a\nb\n"


@pytest.mark.parametrize(("is_fit", "code"), [(True, 0), (False, 3)])
def test_doctor_is_content_only_if_a_run_can_work(call, monkeypatch, is_fit, code):
    row = doctor.Row("thing", "1.0", ">=1.0", is_fit, "fix it so")
    monkeypatch.setattr(doctor, "examine", lambda: [row])
    result = call("doctor")
    assert result.exit_code == code and ("fix it so" in result.stdout) is not is_fit
    assert ("thing" in result.stderr) is not is_fit
