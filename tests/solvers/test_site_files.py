"""What a site names itself: a LIGGGHTS library, by whatever name it has, and the source of its OpenFOAM."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from fbcouple.errors import SolverError
from fbcouple.machine.environment import mpi_environment
from fbcouple.solvers.openfoam import headers
from fbcouple.solvers.site_files import LIGGGHTS, LIGGGHTS_NAMES, OPENFOAM_SOURCE, find_liggghts, find_openfoam_source
from fbcouple.solvers.versions import _load_elsewhere

ABSENT = "{}: cannot open shared object file: No such file or directory"


@pytest.fixture(autouse=True)
def nothing_named(monkeypatch):
    for variable in (LIGGGHTS, OPENFOAM_SOURCE):
        monkeypatch.delenv(variable, raising=False)


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """A source tree of as much as headers are collected from: a header in each library, and a stand-in of wmake."""
    tree = tmp_path / "OpenFOAM-v1912"
    for library in headers._LIBRARIES:
        (tree / "src" / library).mkdir(parents=True, exist_ok=True)
        (tree / "src" / library / "one.H").write_text("// one\n")
    (tree / "META-INFO").mkdir()
    (tree / "META-INFO/api-info").write_text("api=1912\npatch=0\n")
    (tree / "wmake").mkdir()
    (tree / "wmake/wmakeLnInclude").write_text(
        '#!/bin/sh\nmkdir -p "$2/lnInclude" && ln -sf ../one.H "$2/lnInclude/"\n'
    )
    (tree / "wmake/wmakeLnInclude").chmod(0o755)
    return tree


def test_the_library_that_is_here_is_found_without_a_name():
    assert find_liggghts(_load_elsewhere) in LIGGGHTS_NAMES


def test_names_are_tried_until_the_loader_finds_one():
    """One that is there and does not load is taken, for the loader's words tell what is wrong with it."""
    for there in LIGGGHTS_NAMES:

        def load(name, there=there):
            raise OSError(f"{name}: file too short" if name == there else ABSENT.format(name))

        assert find_liggghts(load) == there

    def find_none(name):
        raise OSError(ABSENT.format(name))

    assert find_liggghts(find_none) == LIGGGHTS_NAMES[0]


def test_a_library_of_any_name_runs_where_it_is_named(tmp_path, monkeypatch):
    """In a process of its own, as a rank loads it."""
    real = next(path for path in Path("/usr/lib").glob("**/libliggghts.so.3*") if not path.is_symlink())
    own = tmp_path / "libmine.so"
    own.symlink_to(real)
    monkeypatch.setenv(LIGGGHTS, str(own))
    assert find_liggghts() == str(own)
    deck = tmp_path / "in.one"
    deck.write_text("units si\natom_style sphere\nboundary f f f\nregion box block 0 1 0 1 0 1\ncreate_box 1 box\n")
    program = (
        "import sys; from pathlib import Path; from mpi4py import MPI; from fbcouple.solvers.liggghts import Liggghts;"
        "dem = Liggghts(Path(sys.argv[1]), Path(sys.argv[2]), MPI.COMM_WORLD); print(dem._library._name, dem.count)"
    )
    command = [sys.executable, "-c", program, str(deck), str(tmp_path / "log")]
    done = subprocess.run(command, env=mpi_environment(), capture_output=True, text=True, check=False, timeout=60)
    assert done.stdout.split() == [str(own), "0"], done.stderr


def test_a_named_library_that_is_not_there_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv(LIGGGHTS, str(tmp_path / "none.so"))
    with pytest.raises(SolverError, match=r"FBCOUPLE_LIGGGHTS=.*none\.so: no such file; .*unset FBCOUPLE_LIGGGHTS"):
        find_liggghts()


def test_headers_come_from_a_named_source_which_stays_as_it_was(source, tmp_path, monkeypatch):
    monkeypatch.setenv(OPENFOAM_SOURCE, str(source))
    before = sorted(source.rglob("*"))
    (tmp_path / "cache").mkdir()
    kept = headers.debian_headers("1912.0-1", tmp_path / "cache")
    assert all((folder / "one.H").is_file() for folder in headers.include_folders(kept) if folder.name == "lnInclude")
    assert sorted(source.rglob("*")) == before and os.listdir(tmp_path / "cache") == [kept.name]


@pytest.mark.parametrize("about", ["api=2312\n", ""])
def test_a_source_of_another_version_is_refused(source, monkeypatch, about):
    (source / "META-INFO/api-info").write_text(about)
    monkeypatch.setenv(OPENFOAM_SOURCE, str(source))
    with pytest.raises(SolverError, match=r"FBCOUPLE_OPENFOAM_SOURCE=.*allowed: the source tree of api=1912"):
        find_openfoam_source("1912")


def test_the_archive_alone_serves_where_the_rest_of_the_source_package_is_missing(source, tmp_path, monkeypatch):
    """A mirror without the package's description, as far as apt-get tells, and with OpenFOAM's own archive."""
    archive = tmp_path / "openfoam_1912.0.orig.tar.gz"
    subprocess.run(["tar", "-czf", archive, "-C", source.parent, source.name], check=True)
    program = tmp_path / "bin/apt-get"
    program.parent.mkdir()
    cases = f'*--tar-only*) cp {archive} . ;; *" source "*) echo "404  Not Found"; exit 100 ;;'
    program.write_text(f'#!/bin/sh\ncase "$*" in {cases} esac\n')
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}:{os.environ['PATH']}")
    (tmp_path / "cache").mkdir()
    kept = headers.debian_headers("1912.0-1", tmp_path / "cache")
    assert all((folder / "one.H").is_file() for folder in headers.include_folders(kept) if folder.name == "lnInclude")
