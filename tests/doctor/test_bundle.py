"""The archive for a bug report: what is in it, what is not, and how large it may get."""

from __future__ import annotations

import json
import os
import tarfile

import pytest
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.doctor import bundle
from fbcouple.doctor import checks as doctor
from fbcouple.doctor.bundle import write_bundle
from fbcouple.doctor.disclosure import list_environment
from fbcouple.errors import CaseError, SolverError

ROWS = [doctor.Row("thing", "1.0", ">=1.0", True, "fix it so")]


@pytest.fixture(autouse=True)
def no_earlier_error(monkeypatch, tmp_path):
    """The traceback that the user's own last command left is not these tests'."""
    monkeypatch.setattr("fbcouple.doctor.bundle.cache_folder", lambda: tmp_path / "no cache")


@pytest.fixture
def run(tmp_path):
    folder = tmp_path / "bed"
    for name in ("logs", "CFD/system", "CFD/constant/polyMesh", "DEM", "checkpoints/step-1/CFD"):
        (folder / name).mkdir(parents=True)
    for name in ("case.toml", "manifest.json", "logs/openfoam.log", "DEM/in.liggghts", "CFD/system/controlDict"):
        (folder / name).write_text(f"this is {name}\n")
    for name in ("results.nc", "CFD/constant/polyMesh/points", "checkpoints/step-1/cells-0000.npz"):
        (folder / name).write_bytes(bytes(1000))
    (folder / "checkpoints/step-1/index.json").write_text("{}")
    return folder


def unpack(place) -> dict[str, bytes]:
    with tarfile.open(place) as archive:
        members = archive.getmembers()
        return {member.name.partition("/")[2]: archive.extractfile(member).read() for member in members}


def test_what_is_in_it(run, tmp_path):
    found = unpack(write_bundle(ROWS, run, tmp_path))
    about = json.loads(found.pop("about.json"))
    assert about["doctor"][0]["name"] == "thing" and about["packages"]["numpy"] and about["python"]
    assert set(found) == {
        "environment.txt",
        "files.txt",
        "run/case.toml",
        "run/manifest.json",
        "run/logs/openfoam.log",
        "run/DEM/in.liggghts",
        "run/CFD/system/controlDict",
        "run/checkpoints/step-1/index.json",
    }
    assert found["run/logs/openfoam.log"] == b"this is logs/openfoam.log\n"
    assert b"1000" in found["files.txt"] and b"results.nc" in found["files.txt"]


SECRETS = """
AKIAZZZZ7ZZZZZ7ZZZZZ
aws_secret_access_key = zq01JalrXUtnzz
Authorization: Bearer eyJzq02hbGciOi.zq02.x
cloned https://ghp_zq03abcdefghij@example.org/me/x.git
password is zq04
PASSWORD="two words zq05 here"
-----BEGIN OPENSSH PRIVATE KEY-----
b3BlbnNzaC1rZXktdjEAAAAzq06
-----END OPENSSH PRIVATE KEY-----
--password zq07
pwd=zq08
glpat-zq09xxxxxxxxxx
{"auth": "zq10"}
db: postgres://me:pa/zq11@host/db
client_secret_value: zq12
passphrase: "zq13"
api_key=zq14
password:
    solver zq15
mpirun -x TOKEN=zq16 -n 2
xoxb-zq17-zq17
curl -u me:zq18 https://example.org
my dog is called Zq19zq
set by zq20@example.org
passphrase is open the file
Passwort: datei zq21
"""
"""Forms that passwords and keys have in texts; each holds `zq` or is of words that a solver uses."""


@pytest.mark.parametrize(
    "name",
    [
        "case.toml",
        "manifest.json",
        "logs/launcher.log",
        "logs/openfoam.log",
        "logs/failure.json",
        "DEM/in.liggghts",
        "CFD/system/controlDict",
        "checkpoints/step-1/index.json",
        "batch/state",
    ],
)
def test_no_secret_of_any_form_in_a_known_file(run, tmp_path, name):
    (run / name).parent.mkdir(exist_ok=True)
    (run / name).write_text(f"end_time = 20.0\n{SECRETS}the last line of the file\n")
    found = unpack(write_bundle(ROWS, run, tmp_path))
    everything = b"".join(found.values()).lower()
    for secret in (b"zq", b"zzzz", b"two words", b"open the file", b"b3blbn"):
        assert secret not in everything, secret
    assert (
        found[f"run/{name}"].startswith(b"end_time = 20.0\n") and b"the last line of the file" in found[f"run/{name}"]
    )


@pytest.mark.parametrize(
    "name",
    ["logs/solver.log", "law.py", "start.csv", "batch/slurm.sh", "checkpoints/step-x/index.json", "CFD/0/extra"],
)
def test_files_of_other_names_stay_at_home(run, tmp_path, name):
    (run / name).parent.mkdir(exist_ok=True)
    (run / name).write_text("the file is there\n")
    found = unpack(write_bundle(ROWS, run, tmp_path))
    assert b"the file is there" not in b"".join(found.values()) and f"run/{name}" not in found


def test_names_of_files_are_told_where_they_are_known(run, tmp_path):
    (run / "ghp_zq1234.csv").write_text("1\n")
    (run / "checkpoints/password zq").mkdir()
    listed = unpack(write_bundle(ROWS, run, tmp_path))["files.txt"]
    assert b"zq" not in listed and b"***.csv" in listed and b"checkpoints/***/" in listed
    assert b" results.nc\n" in listed and b" logs/openfoam.log\n" in listed


def test_values_of_secret_variables_are_replaced_wherever_they_stand(run, tmp_path, monkeypatch):
    monkeypatch.setenv("MY_API_TOKEN", "pressure")
    (run / "logs/openfoam.log").write_text("started with pressure in a cell\n")
    found = unpack(write_bundle(ROWS, run, tmp_path))
    assert found["run/logs/openfoam.log"] == b"started with *** in a cell\n"


def test_what_a_reader_needs_of_a_log_stays(run, tmp_path):
    """Messages of solvers, numbers, places in the sources, and our own tracebacks."""
    lines = (
        "ERROR: Unexpected end of data file (./src/read_data.cpp:687)",
        "--> FOAM FATAL IO ERROR:",
        "file: CFD/system/fvSchemes.ddtSchemes at line 11.",
        '  File "/opt/fbcouple/worker.py", line 12, in initialise',
        "smoothSolver:  Solving for Ux, Initial residual = 1.5e-05, Final residual = 3e-10, No Iterations 4",
        "t = 0.0125 s, dt = 1e-5, 250 particles",
    )
    (run / "logs/openfoam.log").write_text("\n".join(lines))
    library = tmp_path / "libsolver.so"
    texts = (
        b"Unexpected end of data file\0--> FOAM FATAL IO ERROR: \0%s:  Solving for , Initial residual = No Iterations"
    )
    library.write_bytes(b"\x7fELF\0" + texts + b"\0No Iterations smoothSolver fvSchemes ddtSchemes opt Ux Final\0")
    rows = [doctor.Row("libsolver.so", str(library), "loads", True, "fix it so")]
    found = unpack(write_bundle(rows, run, tmp_path))["run/logs/openfoam.log"].decode().splitlines()
    assert found == list(lines)


def test_environment_is_an_allow_list_of_whole_names():
    told = list_environment(
        {
            "PATH": "/bin:/opt/b in",
            "WM_PROJECT_DIR": "/foam-7",
            "FOAM_KEY": "zq1",
            "AWS_REGION": "zq2",
            "SLURM_JWT": "zq3",
            "OMPI_MCA_pw": "zq4",
            "PBS_AUTH_X": "zq5",
            "FBCOUPLE_PAT": "zq6",
            "TMPDIR": "https://me:zq7@example.org",
            "LD_LIBRARY_PATH": "$(zq8)",
            "MY_TOKEN": "/foam-7",
        }
    )
    assert "zq" not in told and "AWS" not in told and "MY_TOKEN" not in told
    assert "PATH=/bin:/opt/b in\n" in told and "SLURM_JWT: set, its value is left out\n" in told
    assert "WM_PROJECT_DIR=***\n" in told, "the value of a variable that is called a secret"


def test_long_files_are_cut_and_the_whole_is_bounded(run, tmp_path, monkeypatch):
    monkeypatch.setattr(bundle, "LARGEST", 3_500_000)
    (run / "logs/openfoam.log").write_bytes(b"a a\n" * 250_000 + b"b b\n" * 250_000 + b"the end")
    for name in ("launcher", "liggghts", "mesh"):
        (run / f"logs/{name}.log").write_bytes(b"12 34\n" * 250_000)
    place = write_bundle(ROWS, run, tmp_path)
    found = unpack(place)
    log = found["run/logs/openfoam.log"]
    assert len(log) <= bundle.LARGEST_FILE + 10 and log.startswith(b"a a\n") and log.endswith(b"the end\n")
    assert b"bytes are left out" in log
    assert sum(len(text) for text in found.values()) < 4_000_000 and place.stat().st_size < 4_000_000
    assert b"run/logs/mesh.log" in found["left-out.txt"] and "run/case.toml" in found


@pytest.mark.parametrize("kind", ["link", "linked folder", "pipe"])
def test_no_link_leads_out_of_the_run(run, tmp_path, kind):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere/stolen").write_text("the file is there")
    (tmp_path / "elsewhere/state").write_text("the file is there")
    if kind == "link":
        (run / "logs/mesh.log").symlink_to(tmp_path / "elsewhere/stolen")
    elif kind == "linked folder":
        (run / "batch").symlink_to(tmp_path / "elsewhere")
    else:
        os.mkfifo(run / "logs/mesh.log")
    found = unpack(write_bundle(ROWS, run, tmp_path))
    assert b"the file is there" not in b"".join(found.values()) and "run/logs/mesh.log" not in found


def test_without_a_run(tmp_path):
    assert set(unpack(write_bundle(ROWS, None, tmp_path))) == {"about.json", "environment.txt"}


def test_what_is_no_run_or_no_place(run, tmp_path):
    with pytest.raises(CaseError, match="not a run folder"):
        write_bundle(ROWS, tmp_path, tmp_path)
    with pytest.raises(SolverError, match="cannot be written"):
        write_bundle(ROWS, run, tmp_path / "nowhere")


def test_on_the_command_line(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(doctor, "examine", lambda: ROWS)
    result = CliRunner().invoke(cli, ["doctor", "--bundle", "bed"])
    (place,) = tmp_path.glob("fbcouple-bundle-bed-*.tar.gz")
    assert result.exit_code == 0 and place.name in result.stdout
    assert CliRunner().invoke(cli, ["doctor", "bed"]).exit_code == 2
