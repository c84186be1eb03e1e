"""Doctor: every row of this machine, and what it says where something is missing or does not fit."""

import importlib.metadata
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from fbcouple.decks.abilities import PROBED, probe
from fbcouple.doctor import checks as doctor
from fbcouple.solvers.openfoam import build

ROOT = Path(__file__).resolve().parents[2]
PICTURE = doctor._PICTURE
NEEDED = {
    "python",
    "variables",
    "numpy",
    "mpi4py",
    "mpi4py's MPI",
    "mpirun",
    "libliggghts.so.3",
    "LIGGGHTS' models",
    "libOpenFOAM.so",
    "libfiniteVolume.so",
    "libincompressibleTurbulenceModels.so",
    "blockMesh",
    "topoSet",
    "createPatch",
    "decomposePar",
    "OpenFOAM's controlDict",
    "C++ compiler",
    "cache",
    "adapter",
    "3-D pictures",
    "cores",
    "free memory",
    "free disk",
}


@pytest.fixture(autouse=True)
def without_what_takes_long(monkeypatch):
    """The picture takes a second and is tried once, in the test of everything; so are the questions to LIGGGHTS."""
    monkeypatch.setattr(doctor, "_PICTURE", "print('not tried')")
    monkeypatch.setattr("fbcouple.doctor.abilities.probe", lambda: dict.fromkeys(PROBED, ""))


def row(name: str) -> doctor.Row:
    return {row.name: row for row in doctor.examine()}[name]


def test_everything_is_examined_and_set_up_here(monkeypatch):
    monkeypatch.setattr(doctor, "_PICTURE", PICTURE)
    monkeypatch.setattr("fbcouple.doctor.abilities.probe", probe)
    rows = doctor.examine()
    assert {row.name for row in rows} >= NEEDED
    assert len({row.name for row in rows}) == len(rows)
    assert all(row.found and row.wanted and row.mend for row in rows)
    assert [row for row in rows if not row.ok] == []


def test_every_dependency_of_pyproject_has_a_row():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    names = {re.match(r"[A-Za-z0-9._-]+", dependency)[0].lower() for dependency in project["dependencies"]}
    assert names <= {row.name.lower() for row in doctor.examine()}


def test_old_and_missing_packages_get_the_command_that_mends_them(monkeypatch):
    monkeypatch.setattr(
        importlib.metadata, "requires", lambda _: ["numpy>=99", "no-such-one>=1.0", "pip>=1; extra == 'x'"]
    )
    rows = {row.name: row for row in doctor.examine()}
    assert not rows["numpy"].ok and rows["numpy"].wanted == ">=99" and "pip install 'numpy>=99'" in rows["numpy"].mend
    assert not rows["no-such-one"].ok and rows["no-such-one"].found == "not installed"
    assert "pip" not in rows


@pytest.mark.parametrize(
    ("found", "bound", "enough"),
    [
        ("2", "2.0", True),
        ("2.10", "2.9", True),
        ("1.26.4", "2.0", False),
        ("3.0rc1", "2.0", True),
        ("2.0", "2.0,<3", True),
    ],
)
def test_versions_compare_as_numbers(monkeypatch, found, bound, enough):
    monkeypatch.setattr(importlib.metadata, "requires", lambda _: [f"numpy>={bound}"])
    monkeypatch.setattr(importlib.metadata, "version", lambda _: found)
    assert row("numpy").ok is enough


def test_without_the_reader_of_requirements_the_rest_is_still_examined(monkeypatch):
    monkeypatch.setitem(sys.modules, "packaging.requirements", None)
    rows = {row.name: row for row in doctor.examine()}
    assert not rows["packaging"].ok and "pip install packaging" in rows["packaging"].mend
    assert rows["python"].ok


def test_missing_programs_each_have_their_package(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    rows = {row.name: row for row in doctor.examine()}
    wanted = {"blockMesh": "openfoam", "decomposePar": "openfoam", "mpirun": "openmpi-bin"}
    for name, package in wanted.items():
        assert not rows[name].ok and rows[name].mend == f"sudo apt-get install {package}"


def test_a_library_with_another_mpi_is_not_ok(monkeypatch):
    load = doctor._load

    def with_another_mpi(name):
        return (
            doctor._Loaded("Open MPI v4.1.4", ("/elsewhere/libmpi.so.40",), False) if name == "mpi4py" else load(name)
        )

    monkeypatch.setattr(doctor, "_load", with_another_mpi)
    found = row("libliggghts.so.3")
    assert not found.ok and "/elsewhere/libmpi.so.40" in found.wanted and "libmpi.so" in found.found


@pytest.mark.parametrize(
    ("words", "ok"), [("Open MPI v4.1.4", True), ("Open MPI v5.0.1", False), ("MPICH Version: 4.2", False)]
)
def test_mpi_of_mpi4py_is_open_mpi_of_the_launcher(monkeypatch, words, ok):
    monkeypatch.setattr(doctor, "_load", lambda _: doctor._Loaded(words, ("/lib/libmpi.so.40",), False))
    monkeypatch.setattr(doctor, "_first_line", lambda _: "mpirun (Open MPI) 4.1.4")
    rows = {row.name: row for row in doctor.examine()}
    assert (rows["mpirun"].ok and rows["mpi4py's MPI"].ok) is ok


def test_a_missing_library_shows_the_loaders_words():
    loaded = doctor._load("libnosuch.so.1")
    assert loaded.failed and "libnosuch.so.1" in loaded.words


def test_fix_builds_the_adapter(monkeypatch, tmp_path):
    kept = build.build_adapter().parent
    for headers in kept.glob("openfoam-*-headers"):
        (tmp_path / headers.name).symlink_to(headers)
    (tmp_path / "adapter.cpp").write_text('extern "C" int answer() { return 42; }\n')
    monkeypatch.setattr(build, "SOURCES", tmp_path)
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path))
    before = row("adapter")
    assert not before.ok and before.mend == "fbcouple doctor --fix"
    doctor.fix()
    assert row("adapter").ok


def test_a_compiler_is_only_needed_until_the_adapter_is_built(monkeypatch, tmp_path):
    build.build_adapter()
    monkeypatch.setenv("CXX", "no-such-compiler")
    assert row("C++ compiler").ok and row("adapter").ok
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path))
    assert not row("C++ compiler").ok and not row("adapter").ok


def test_3d_pictures_are_no_part_of_a_run(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    row = doctor._pictures()
    assert row.ok and "not installed" in row.found


def test_a_launcher_of_mpich_goes_with_an_mpi4py_of_mpich(monkeypatch):
    load, words = doctor._load, "MPICH Version: 4.2.0"
    monkeypatch.setattr(
        doctor,
        "_load",
        lambda name: doctor._Loaded(words, ("/lib/libmpich.so.12",), False) if "4" in name else load(name),
    )
    monkeypatch.setattr(doctor, "_first_line", lambda _: "HYDRA build details:")
    rows = {row.name: row for row in doctor.examine()}
    assert rows["mpi4py's MPI"].ok and rows["mpirun"].ok and rows["mpirun"].wanted == "mpirun of MPICH"


def test_variables_of_the_site_are_shown_and_judged(monkeypatch, tmp_path):
    monkeypatch.setenv("FBCOUPLE_BIND", "core")
    assert row("variables").ok and "FBCOUPLE_BIND=core" in row("variables").found
    monkeypatch.setenv("FBCOUPLE_BIND", "cores")
    monkeypatch.setenv("FBCOUPLE_LIGGGHTS", str(tmp_path / "none.so"))
    found = row("variables")
    assert not found.ok and "FBCOUPLE_BIND: 'cores' is given" in found.found and "none.so: no such file" in found.found


def test_a_library_that_is_no_liggghts_is_told_by_what_it_lacks(monkeypatch, tmp_path):
    """With the MPI of this machine, but none of the functions that are called."""
    empty = tmp_path / "libliggghts.so"
    link = ["-x", "none", "-Wl,--no-as-needed", doctor._load("mpi4py").mpi[0]]
    subprocess.run(["g++", "-shared", "-fPIC", "-x", "c++", os.devnull, "-o", empty, *link], check=True)
    monkeypatch.setenv("FBCOUPLE_LIGGGHTS", str(empty))
    found = row("libliggghts.so")
    assert not found.ok and "has no function lammps_open, lammps_close" in found.found
    assert "name a library of LIGGGHTS 3.8 in FBCOUPLE_LIGGGHTS" in found.mend
