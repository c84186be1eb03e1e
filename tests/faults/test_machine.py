"""What the machine lacks: a library, the right MPI, permission to write. Exit code 3, with the words that say it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from small_bed import prepare

from fbcouple.errors import SolverError
from fbcouple.launcher.launch import launch

# The administrator may write anywhere, until this is taken from him.
OBEDIENT = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"] if os.geteuid() == 0 else []


def run_in_a_process(run: Path, *words: str) -> subprocess.CompletedProcess:
    """`fbcouple run` as a user who obeys permissions."""
    command = [*OBEDIENT, sys.executable, "-m", "fbcouple.cli.main", "run", str(run), *words]
    return subprocess.run(command, env={**os.environ}, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("name", "fix"),
    [
        ("libliggghts.so.3", "sudo apt-get install liggghts"),
        ("libincompressibleTurbulenceModels.so", "fbcouple doctor --fix"),
    ],
)
def test_library_that_does_not_load(tmp_path, monkeypatch, name, fix):
    run = prepare(tmp_path)
    (tmp_path / name).write_bytes(b"")
    monkeypatch.setenv("LD_LIBRARY_PATH", str(tmp_path))
    with pytest.raises(
        SolverError, match=rf"library .* cannot be loaded: {tmp_path / name}: file too short; fix: {fix}"
    ):
        launch(run, 1, lambda row: None)


def test_adapter_that_is_not_built(tmp_path, monkeypatch):
    run = prepare(tmp_path)
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path / "empty"))
    with pytest.raises(
        SolverError, match=r"library .*empty.* cannot be loaded: .*No such file.*fix: fbcouple doctor --fix"
    ):
        launch(run, 1, lambda row: None)


def test_library_that_brings_another_mpi(tmp_path, monkeypatch):
    """A LIGGGHTS that was linked with MPICH, as far as the loader sees: two MPIs in one process."""
    run = prepare(tmp_path)
    compiler = ["g++", "-shared", "-fPIC", "-x", "c++", os.devnull, "-o"]
    subprocess.run([*compiler, tmp_path / "libmpich.so.12"], check=True)
    link = ["-x", "none", "-Wl,--no-as-needed", tmp_path / "libmpich.so.12", f"-Wl,-rpath,{tmp_path}"]
    subprocess.run([*compiler, tmp_path / "libliggghts.so.3", *link], check=True)
    monkeypatch.setenv("LD_LIBRARY_PATH", str(tmp_path))
    with pytest.raises(SolverError, match=r"libliggghts.so.3 brings another MPI: \S*libmpich.so.12 and \S*/libmpi.so"):
        launch(run, 1, lambda row: None)


def test_launcher_of_another_mpi(tmp_path, monkeypatch):
    """It starts the processes, and each of them believes that it is alone."""
    run = prepare(tmp_path)
    (tmp_path / "bin").mkdir()
    launcher = tmp_path / "bin/mpirun"
    launcher.write_text(
        '#!/bin/sh\nwhile [ "$1" != "$PYTHON" ]; do shift; done\n"$@" & "$@"\ncode=$?\nwait\nexit $code\n'
    )
    launcher.chmod(0o755)
    monkeypatch.setenv("PYTHON", sys.executable)
    monkeypatch.setenv("PATH", str(launcher.parent), prepend=os.pathsep)
    words = r"mpirun was asked for 2 ranks and this process finds 1: the launcher is not of mpi4py's MPI, Open MPI"
    with pytest.raises(SolverError, match=words):
        launch(run, 2, lambda row: None)
    assert not (run / "results.nc").exists()


@pytest.mark.parametrize("folder", ["", "logs", "CFD/constant"])
def test_run_folder_without_permission_to_write(tmp_path, folder):
    run = prepare(tmp_path)
    (run / folder).chmod(0o555)
    done = run_in_a_process(run)
    assert done.returncode == 3, done.stderr
    assert str(run) in done.stderr and "Traceback" not in done.stderr
    assert "Permission denied" in done.stderr or "does not allow write permission" in done.stderr
    assert not (run / "results.nc").exists()


def test_checkpoints_without_permission_to_write(tmp_path):
    run = prepare(tmp_path, ["checkpoint.every=2e-4"])
    assert run_in_a_process(run, "--until", "1e-4").returncode == 0
    (newest,) = (run / "checkpoints").iterdir()
    (run / "checkpoints").chmod(0o555)
    done = run_in_a_process(run, "--resume")
    assert done.returncode == 3, done.stderr
    assert "cannot be written: [Errno 13] Permission denied" in done.stderr
    assert f"{newest.name} stands" in done.stderr and newest.exists()
