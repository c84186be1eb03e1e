"""The archive for a bug report: what is in it, what is not, and how large it may get."""

from __future__ import annotations

import json
import os
import tarfile

import pytest
from click.testing import CliRunner

from fbcouple import bundle, doctor
from fbcouple.bundle import list_environment, mask, write_bundle
from fbcouple.cli import cli
from fbcouple.errors import CaseError, SolverError

ROWS = [doctor.Row("thing", "1.0", ">=1.0", True, "mend it so")]


@pytest.fixture(autouse=True)
def no_earlier_error(monkeypatch, tmp_path):
    """The traceback that the user's own last command left is not these tests'."""
    monkeypatch.setattr("fbcouple.bundle.cache_folder", lambda: tmp_path / "no cache")


@pytest.fixture
def run(tmp_path):
    folder = tmp_path / "bed"
    for name in ("logs", "fluid/system", "fluid/constant/polyMesh", "grains", "checkpoints/step-1/fluid"):
        (folder / name).mkdir(parents=True)
    for name in ("case.toml", "manifest.json", "logs/fluid.log", "grains/in.grains", "fluid/system/controlDict"):
        (folder / name).write_text(f"this is {name}\n")
    for name in ("results.nc", "fluid/constant/polyMesh/points", "checkpoints/step-1/cells-0000.npz"):
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
        "run/logs/fluid.log",
        "run/grains/in.grains",
        "run/fluid/system/controlDict",
        "run/checkpoints/step-1/index.json",
    }
    assert found["run/logs/fluid.log"] == b"this is logs/fluid.log\n"
    assert b"1000" in found["files.txt"] and b"results.nc" in found["files.txt"]


def test_no_secrets(run, tmp_path, monkeypatch):
    monkeypatch.setenv("MY_API_TOKEN", "tr0ub4dor")
    monkeypatch.setenv("SLURM_JWT_TOKEN", "jwt-jwt-jwt")
    monkeypatch.setenv("HOME_GROWN", "not asked for")
    monkeypatch.setenv("OMPI_MCA_where", "https://me:hunter2@example.org/x")
    (run / "logs/fluid.log").write_text("started with tr0ub4dor\npassword = opensesame\nToken: abc, next\n")
    everything = b"".join(unpack(write_bundle(ROWS, run, tmp_path)).values())
    for secret in (b"tr0ub4dor", b"jwt-jwt-jwt", b"HOME_GROWN", b"not asked for", b"hunter2", b"opensesame", b" abc"):
        assert secret not in everything
    assert b"https://me:***@example.org/x" in everything and b"started with ***" in everything


def test_environment_is_an_allow_list():
    told = list_environment({"PATH": "/bin", "WM_PROJECT_DIR": "/foam", "FOAM_KEY": "x", "AWS_REGION": "y"})
    assert told == b"PATH=/bin\nWM_PROJECT_DIR=/foam\n"


def test_short_values_are_no_secrets_to_mask():
    assert mask(b"a 1 b", {"USE_TOKEN": "1"}) == b"a 1 b"


def test_long_files_are_cut_and_the_whole_is_bounded(run, tmp_path, monkeypatch):
    monkeypatch.setattr(bundle, "LARGEST", 3_500_000)
    (run / "logs/fluid.log").write_bytes(b"a" * 1_000_000 + b"b" * 1_000_000 + b"the end")
    for number in range(5):
        (run / f"logs/more-{number}.log").write_bytes(os.urandom(1_500_000))
    place = write_bundle(ROWS, run, tmp_path)
    found = unpack(place)
    log = found["run/logs/fluid.log"]
    assert len(log) <= bundle.LARGEST_FILE and log.startswith(b"aaa") and log.endswith(b"the end")
    assert b"bytes are left out" in log
    assert sum(len(text) for text in found.values()) < 4_000_000 and place.stat().st_size < 4_000_000
    assert b"run/logs/more-4.log" in found["left-out.txt"] and "run/case.toml" in found


@pytest.mark.parametrize("kind", ["link", "linked folder", "pipe"])
def test_no_link_leads_out_of_the_run(run, tmp_path, kind):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere/stolen").write_text("a stranger's")
    if kind == "link":
        (run / "logs/x.log").symlink_to(tmp_path / "elsewhere/stolen")
    elif kind == "linked folder":
        (run / "batch").symlink_to(tmp_path / "elsewhere")
    else:
        os.mkfifo(run / "logs/x.log")
    found = unpack(write_bundle(ROWS, run, tmp_path))
    assert b"a stranger's" not in b"".join(found.values()) and "run/logs/x.log" not in found


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
