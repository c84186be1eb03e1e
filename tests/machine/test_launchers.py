"""How ranks are started by the launchers of several sites, by their command lines."""

from __future__ import annotations

import itertools
import os
from pathlib import Path

import pytest

from fbcouple.errors import CaseError
from fbcouple.machine.launchers import OVERSUBSCRIBE, count_nodes, mpi_command, name_mpi, tell_crowd

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
    of_jobs = ("SLURM_STEP_ID", "SLURM_JOB_NUM_NODES", "PBS_NODEFILE", "LSB_DJOB_HOSTFILE", "LSB_HOSTS")
    of_places = ("SLURM_NTASKS", "SLURM_JOB_CPUS_PER_NODE", OVERSUBSCRIBE)
    for variable in ("FBCOUPLE_LAUNCHER", "FBCOUPLE_BIND", *of_jobs, *of_places):
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


def list_brought(command: list[str]) -> list[str]:
    return [word for before, word in itertools.pairwise(command) if before == "-x"]


@pytest.mark.parametrize("variable", ["PBS_NODEFILE", "LSB_DJOB_HOSTFILE"])
def test_open_mpi_is_told_the_hosts_of_a_job_and_what_its_ranks_read(launcher, monkeypatch, tmp_path, variable):
    """Built without the batch system, as Debian's is, it would start all ranks on the first host; and what starts a
    rank on another brings no environment along."""
    launcher("mpirun", SAYS["Open MPI"])
    hosts = tmp_path / "hosts"
    hosts.write_text("one\none\ntwo\ntwo\n")
    monkeypatch.setenv(variable, str(hosts))
    monkeypatch.setenv("FBCOUPLE_LIGGGHTS", "/opt/liggghts/libliggghts.so")
    monkeypatch.setenv("LD_LIBRARY_PATH", "/opt/openfoam/lib")
    monkeypatch.setenv("DISPLAY", ":0")
    command = mpi_command(4, ["x"])
    assert command[:7] == ["mpirun", "-n", "4", "--bind-to", "none", "--host", "one:2,two:2"] and command[-1] == "x"
    brought = list_brought(command)
    assert {"PATH", "LD_LIBRARY_PATH", "FBCOUPLE_LIGGGHTS", "FBCOUPLE_CACHE", "FOAM_CONTROLDICT"} <= set(brought)
    assert "DISPLAY" not in brought and "HOME" not in brought
    hosts.write_text("one\none\none\none\n")
    assert mpi_command(4, ["x"]) == ["mpirun", "-n", "4", "--bind-to", "none", "x"]


def test_slurm_needs_no_list_of_hosts_but_may_keep_the_environment_back(launcher, monkeypatch):
    """As under `sbatch --export=NONE`."""
    launcher("mpirun", SAYS["Open MPI"])
    monkeypatch.setenv("SLURM_JOB_NUM_NODES", "2")
    command = mpi_command(4, ["x"])
    assert "--host" not in command and "PYTHONSAFEPATH" in list_brought(command)


@pytest.mark.parametrize("mpi", ["MPICH", "Intel MPI"])
def test_other_launchers_find_hosts_and_bring_the_environment_themselves(launcher, monkeypatch, tmp_path, mpi):
    launcher("mpirun", SAYS[mpi])
    (tmp_path / "hosts").write_text("one\ntwo\n")
    monkeypatch.setenv("PBS_NODEFILE", str(tmp_path / "hosts"))
    assert mpi_command(4, ["x"]) == ["mpirun", "-n", "4", "x"]


def test_more_ranks_than_cores_are_told(launcher):
    """The machine has four cores."""
    launcher("mpirun", SAYS["Open MPI"])
    assert tell_crowd(4) == tell_crowd(2, 2) == tell_crowd(1, 4) == ""
    assert tell_crowd(8).startswith("8 ranks are asked for, on 4 cores: ranks that share a core wait")
    assert tell_crowd(2, 3).startswith("3 runs of 2 ranks at a time are asked for, on 4 cores")


@pytest.mark.parametrize(
    ("variable", "value", "covered"),
    [
        (OVERSUBSCRIBE, "1", 100),
        (OVERSUBSCRIBE, "0", 4),
        ("FBCOUPLE_LAUNCHER", "srun", 100),
        ("SLURM_NTASKS", "16", 16),
        ("SLURM_JOB_CPUS_PER_NODE", "8(x2),4", 20),
        ("SLURM_JOB_NUM_NODES", "3", 12),
        ("LSB_HOSTS", "a a a b b b", 8),
    ],
)
def test_what_covers_more_ranks_than_cores(launcher, monkeypatch, variable, value, covered):
    launcher("mpirun", SAYS["Open MPI"])
    monkeypatch.setenv(variable, value)
    assert tell_crowd(covered) == ""
    assert (tell_crowd(covered + 1) == "") == (covered == 100)
