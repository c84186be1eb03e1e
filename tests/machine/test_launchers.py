"""How ranks are started by the launchers of several sites, by their command lines."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from fbcouple.errors import CaseError
from fbcouple.machine.launchers import count_nodes, mpi_command, name_mpi

SAYS = {
    "Open MPI": "mpirun (Open MPI) 4.1.4",
    "MPICH": "HYDRA build details:\n    Version: 4.2.0",
    "Intel MPI": "Intel(R) MPI Library for Linux* OS, Version 2021.13",
    "unknown": "a launcher of the site",
}


@pytest.fixture
def launcher(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Put a program `name` that says `words` of its version first on the PATH, on a machine of 4 cores."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: range(4))
    for variable in ("FBCOUPLE_LAUNCHER", "FBCOUPLE_BIND", "SLURM_STEP_ID", "SLURM_JOB_NUM_NODES", "PBS_NODEFILE"):
        monkeypatch.delenv(variable, raising=False)

    def put(name: str, words: str) -> None:
        (tmp_path / name).write_text(f"#!/bin/sh\necho '{words}'\n")
        (tmp_path / name).chmod(0o755)
        monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
        monkeypatch.setenv("FBCOUPLE_LAUNCHER", name)

    return put


@pytest.mark.parametrize("mpi", SAYS)
def test_mpirun_gets_what_its_own_mpi_understands(launcher, monkeypatch, mpi):
    """Open MPI binds unless it is told not to, and refuses more ranks than cores; Hydra does neither."""
    launcher("mpirun", SAYS[mpi])
    assert name_mpi("mpirun") == mpi
    own = ["--bind-to", "none", "--oversubscribe"] if mpi == "Open MPI" else []
    assert mpi_command(8, ["x"]) == ["mpirun", "-n", "8", *own, "x"]
    monkeypatch.setenv("FBCOUPLE_BIND", "core")
    bound = ["--bind-to", "core"] if mpi == "Open MPI" else ["-bind-to", "core"]
    assert mpi_command(2, ["x"]) == ["mpirun", "-n", "2", *bound, "x"]


@pytest.mark.parametrize(
    ("name", "bind", "words"),
    [
        ("srun", "none", ["--cpu-bind=none"]),
        ("srun", "core", ["--cpu-bind=cores"]),
        ("srun", "numa", ["--cpu-bind=ldoms"]),
        ("aprun", "none", ["-cc", "none"]),
        ("aprun", "numa", ["-cc", "numa_node"]),
    ],
)
def test_launchers_of_batch_systems_count_places_themselves(launcher, monkeypatch, name, bind, words):
    launcher(name, "")
    monkeypatch.setenv("FBCOUPLE_BIND", bind)
    assert mpi_command(64, ["x"]) == [name, "-n", "64", *words, "x"]


@pytest.mark.parametrize(
    ("variable", "value"), [("FBCOUPLE_LAUNCHER", "mpiexex"), ("FBCOUPLE_BIND", "cores"), ("FBCOUPLE_BIND", "-x")]
)
def test_a_launcher_or_binding_that_is_none_is_refused(launcher, monkeypatch, variable, value):
    monkeypatch.setenv(variable, value)
    with pytest.raises(CaseError, match=f"{variable}: '{value}' is given, allowed: "):
        mpi_command(1, ["x"])


def test_the_nodes_of_a_job_have_their_own_places(launcher, monkeypatch, tmp_path):
    """8 ranks on 2 nodes of 4 cores each are not too many; on one node they are."""
    launcher("mpirun", SAYS["Open MPI"])
    monkeypatch.setenv("SLURM_JOB_NUM_NODES", "2")
    assert "--oversubscribe" not in mpi_command(8, ["x"])
    monkeypatch.setenv("SLURM_JOB_NUM_NODES", "1")
    assert "--oversubscribe" in mpi_command(8, ["x"])
    (tmp_path / "nodes").write_text("a\na\nb\nb\n")
    given = ({"SLURM_JOB_NUM_NODES": "3"}, {"PBS_NODEFILE": str(tmp_path / "nodes")}, {"LSB_HOSTS": "a a b"}, {})
    assert [count_nodes(one) for one in given] == [3, 2, 2, 1]
