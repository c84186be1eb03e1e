"""A case, the files beside it and a run folder may come from anybody: what they try is refused, or does nothing."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from fbcouple.case.load import load_case
from fbcouple.cli.main import cli
from fbcouple.decks.render import render_decks
from fbcouple.machine.environment import mpi_environment

PARTICLE = """
title = "fifty particles"
end_time = 1e-3
[domain]
size = [0.008, 0.008, 0.02]
cells = [2, 2, 5]
[particles]
diameter = 1e-3
density = 2500.0
count = 50
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
"""
GAS = "[gas]\ndensity = 1.2\nviscosity = 2e-5\ninlet_velocity = 0.5\n[exchange]\n"
# Touches the file that must not appear, in the words of a shell, of LIGGGHTS, of OpenFOAM and of Python.
SHELL, GRAINS = "$(touch stolen)", "\nshell touch stolen\n"
FOAM = '#codeStream { code #{ system("touch stolen"); #}; }'
PYTHON = 'open("stolen", "w")\n\ndef beta(voidage, slip, diameter, density, viscosity):\n    return diameter\n'

Call = Callable[..., Result]


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Call:
    """Call the command line in this process, in the test's folder."""
    monkeypatch.chdir(tmp_path)

    def invoke(*arguments: object) -> Result:
        return CliRunner().invoke(cli, [str(argument) for argument in arguments])

    return invoke


@pytest.fixture
def run(call: Call, tmp_path: Path) -> Path:
    """A sound run folder of fifty particles in gas."""
    (tmp_path / "case.toml").write_text(PARTICLE + GAS)
    assert call("setup", "case.toml", "-o", "run").exit_code == 0
    return tmp_path / "run"


def quote(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n").replace("\0", "\\u0000") + '"'


VALUES = {
    "shell in a number": ("gas.density", quote(f"1.2 {SHELL}")),
    "LIGGGHTS command in a number": ("particles.diameter", quote(f"1e-3{GRAINS}")),
    "codeStream in a number": ("gas.viscosity", quote(FOAM)),
    "calc in a number": ("contact.stiffness", quote('#calc "1+1"')),
    "template in a number": ("end_time", quote("{{ 7 * 7 }}")),
    "shell in a list": ("domain.cells", f"[2, 2, {quote(SHELL)}]"),
    "include in a list": ("domain.size", f"[0.008, {quote(') #include ' + chr(34) + '/etc/passwd')}, 0.02]"),
    "libs in a word": ("gas.turbulence", quote('smagorinsky; libs ("./x.so")')),
    "coded entry in a word": ("gas.walls", quote(f"slip; }} {FOAM}")),
    "LIGGGHTS command in a word": ("contact.tangential", quote(f"history{GRAINS}")),
    "LIGGGHTS command in a title": ("title", quote(f"bed{GRAINS}")),
    "line separator in a title": ("title", '"bed\\u2028shell touch stolen"'),
    "carriage return in a title": ("title", '"bed\\rshell touch stolen"'),
    "path in a drag law": ("exchange.drag", quote("../../law")),
    "Python in a drag law": ("exchange.drag", quote('x"); open("stolen", "w")')),
    "systemCall as a section": ("functions", '{ type = "systemCall", executeCalls = ["touch stolen"] }'),
    "positions above": ("particles.positions", quote("../secret.csv")),
    "positions elsewhere": ("particles.positions", quote("/etc/passwd")),
    "newline in positions": ("particles.positions", quote(f"seed{GRAINS}.csv")),
    "zero byte in positions": ("particles.positions", quote("seed\0.csv")),
    "drag file above": ("exchange.drag_file", quote("../law.py")),
    "drag file elsewhere": ("exchange.drag_file", quote("/tmp/law.py")),
    "law of heat above": ("heat.nusselt_file", quote("../law.py")),
    "reference above": ("output.references", f"[{quote('voidage@0.01=../secret.csv')}]"),
    "reference elsewhere": ("output.references", f"[{quote('voidage@0.01=/etc/passwd')}]"),
    "shell in a reference": ("output.references", f"[{quote(f'voidage@{SHELL}=a.csv')}]"),
    "base above": ("base", quote("../../secret")),
    "base elsewhere": ("base", quote("/etc/passwd")),
}


@pytest.mark.parametrize("command", ["check", "setup"])
@pytest.mark.parametrize("attempt", VALUES)
def test_value_is_refused(call, tmp_path, attempt, command):
    key, value = VALUES[attempt]
    (tmp_path / "case").mkdir()
    (tmp_path / "secret.csv").write_text("x,y,z\n")
    section, _, name = key.rpartition(".")
    lines = [line for line in (PARTICLE + GAS).splitlines() if not line.startswith(f"{name} =")]
    if name == "base":
        lines = []
    elif section and f"[{section}]" not in lines:
        lines.append(f"[{section}]")
    place = lines.index(f"[{section}]") + 1 if section else 0
    lines.insert(place, f"{name} = {value}")
    (tmp_path / "case/case.toml").write_text("\n".join(lines))
    before = sorted(tmp_path.rglob("*"))
    result = call(command, "case")
    assert result.exit_code == 1 and "Traceback" not in result.output, result.output
    assert any(f"case/case.toml: {key.split('.')[0]}" in line for line in result.stderr.splitlines())
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    "setting", ["gas.density=1.2; touch stolen", f"title=bed{GRAINS}", "title\nx=1", "base=patil/c2"]
)
def test_setting_is_refused(call, tmp_path, setting):
    result = call("setup", "patil/c1", "--set", setting)
    assert result.exit_code == 1 and len(result.stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", [SHELL, "../case", "patil/../../x", f"x{GRAINS}", "x\0", "-"])
def test_name_of_a_case_is_refused(call, tmp_path, name):
    assert call("setup", "--", name).exit_code == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "setting"),
    [
        ("seed.csv", "particles.positions=seed.csv"),
        ("law.py", "exchange.drag_file=law.py"),
        ("line.csv", 'output.references=["voidage@0.01=line.csv"]'),
    ],
)
@pytest.mark.parametrize("kind", ["link", "pipe", "folder"])
def test_file_beside_the_case_is_a_plain_file_of_its_folder(call, tmp_path, name, setting, kind):
    (tmp_path / "case").mkdir()
    (tmp_path / "case/case.toml").write_text(PARTICLE + GAS)
    (tmp_path / "secret").write_text("x,y,z\n0.001,0.001,0.001\n")
    path = tmp_path / "case" / name
    {"link": lambda: path.symlink_to(tmp_path / "secret"), "pipe": lambda: os.mkfifo(path), "folder": path.mkdir}[
        kind
    ]()
    result = call("setup", "case", "--set", setting, "--set", "exchange.drag=own", "--trust")
    words = "leads out of the folder" if kind == "link" else "is not a plain file"
    assert result.exit_code == 1 and words in result.stderr, result.output
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize("command", ["check", "setup", "run"])
def test_own_drag_law_does_not_run_without_trust(call, run, tmp_path, command):
    for place in (tmp_path, run):
        (place / "law.py").write_text(PYTHON)
        text = (place / "case.toml").read_text()
        law = '[exchange]\ndrag = "own"\ndrag_file = "law.py"\n'
        (place / "case.toml").write_text(text.replace("[exchange]\n", law).replace('drag = "huilin-gidaspow"\n', ""))
    result = call(command, "run" if command == "run" else "case.toml")
    assert "--trust" in result.output and result.exit_code == (0 if command == "check" else 1)
    assert not (tmp_path / "stolen").exists() and not (run / "stolen").exists()


def test_title_that_tries_everything_does_nothing(call, tmp_path):
    title = f"{SHELL} `touch stolen` & shell touch stolen ; {{{{ 7 * 7 }}}} {{% include 'x' %}} {FOAM} #calc ${{HOME}}"
    (tmp_path / "case.toml").write_text(PARTICLE.replace('"fifty particles"', quote(title)))
    assert call("setup", "case.toml", "-o", "run").exit_code == 0
    assert all("stolen" not in text for text in render_decks(load_case("case.toml")).values())
    result = call("run", "run")
    assert result.exit_code == 0, result.output
    assert not list(tmp_path.rglob("stolen"))


TAMPERED = {
    "codeStream": ("CFD/system/controlDict", f"endTime {FOAM};\n"),
    "calc": ("CFD/system/fvSolution", 'x #calc "1+1";\n'),
    "systemCall": ("CFD/system/controlDict", 'functions { x { type systemCall; executeCalls ("touch stolen"); } }\n'),
    "libs": ("CFD/system/controlDict", 'libs ("./stolen.so");\n'),
    "include": ("CFD/constant/transportProperties", '#include "/etc/passwd"\n'),
    "coded boundary": ("CFD/0/U", "x { type codedFixedValue; }\n"),
    "LIGGGHTS shell": ("DEM/in.liggghts", "shell touch stolen\n"),
    "LIGGGHTS include": ("DEM/in.liggghts", "include /tmp/in.stolen\n"),
    "deck that is not needed": ("CFD/constant/fvOptions", "x { type codedSource; }\n"),
    "second LIGGGHTS deck": ("DEM/in.more", "shell touch stolen\n"),
}


@pytest.fixture
def no_launch(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fail the test if a solver would be started."""
    monkeypatch.setattr("fbcouple.launcher.launch.launch", lambda *_, **__: pytest.fail("a solver was started"))


@pytest.mark.parametrize("attempt", TAMPERED)
@pytest.mark.usefixtures("no_launch")
def test_changed_run_folder_is_not_run(call, run, tmp_path, attempt):
    name, text = TAMPERED[attempt]
    with (run / name).open("a") as file:
        file.write(text)
    result = call("run", run)
    assert result.exit_code == 1 and f"{run / name}: " in result.stderr and "--trust" in result.stderr
    assert len(result.stderr.splitlines()) == 1


@pytest.mark.usefixtures("no_launch")
def test_decks_that_are_missing_are_not_run(call, run):
    decks = run / "DEM/in.liggghts", run / "CFD/system/controlDict"
    for deck in decks:
        deck.unlink()
    result = call("run", run)
    assert result.exit_code == 1 and len(result.stderr.splitlines()) == 2
    assert all(f"{deck}: is missing" in result.stderr for deck in decks)


def test_trusted_decks_still_compile_no_code(call, run, tmp_path):
    deck = run / "CFD/system/blockMeshDict"
    deck.write_text(deck.read_text().replace("scale   1;", f"scale   {FOAM};"))
    result = call("run", run, "--trust")
    assert result.exit_code == 3 and "blockMesh failed" in result.stderr
    assert "security reasons" in result.stderr
    assert not list(tmp_path.rglob("stolen")) and not list(tmp_path.rglob("dynamicCode"))


def test_openfoam_compiles_no_code_of_a_case_for_a_plain_user(run):
    """The administrator it refuses anyway: seen as nobody, who must be able to read the folder."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        shutil.copytree(run / "CFD", folder / "CFD")
        for path in (folder, *folder.rglob("*")):
            path.chmod(0o755)
        deck = folder / "CFD/system/controlDict"
        deck.write_text(deck.read_text().replace("writePrecision  17;", 'writePrecision #calc "17";'))
        nobody = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
        tool = ["blockMesh", "-case", str(folder / "CFD")]
        done = subprocess.run(tool, env=mpi_environment(), capture_output=True, text=True, check=False, **nobody)
    assert done.returncode != 0 and "allowSystemOperations" in done.stderr


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["particles.count=1000000000000", "domain.size=[100.0, 100.0, 100.0]"], "1e+12 particles need about 6e+05 GB"),
        (["domain.cells=[10000, 10000, 10000]"], "1e+12 cells are given (1.9e+06 GB)"),
        (["domain.cells=[10000, 10000, 10]"], "need about 1.9e+03 GB, this machine has"),
        (["output.record_every=1e-12"], "at least 1e-10 s is allowed"),
    ],
)
def test_size_beyond_the_machine_is_refused_with_its_estimate(call, tmp_path, settings, words):
    (tmp_path / "case.toml").write_text(PARTICLE + GAS)
    for command in ("check", "setup"):
        result = call(command, "case.toml", *(part for setting in settings for part in ("--set", setting)))
        assert result.exit_code == 1 and words in result.stderr, result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["case.toml"]
