"""Jobs on two nodes, each a host with a name and a network of its own, with the real solvers and a real SLURM."""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.paths import LOG
from tests.batch.hosts import Host, open_hosts, write_agent
from tests.batch.slurm_box import open_slurm
from tests.batch.slurm_jobs import CASE, await_end, call, hand_in, is_complete, list_jobs

pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.geteuid() != 0, reason="only root may open networks for hosts")]
TWO = ("-n", 2, "--nodes", 2, "--memory", 900)
LONGER = CASE.replace("end_time = 2e-3", "end_time = 0.03")


PMIX = "/usr/lib/x86_64-linux-gnu/pmix2/lib"


@pytest.fixture(scope="module")
def hosts(tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[Host]]:
    """With the name of PMIx' library that SLURM's plugin asks for; Debian has it in the package of the headers."""
    folder = tmp_path_factory.mktemp("hosts")
    pmix = shutil.copytree(PMIX, folder / "pmix", symlinks=True)
    if not (pmix / "libpmix.so").exists():
        (pmix / "libpmix.so").symlink_to("libpmix.so.2")
    with open_hosts(folder, ["box1", "box2"], {PMIX: pmix}) as hosts:
        yield hosts


@pytest.fixture(scope="module")
def slurm(hosts: list[Host], tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    with open_slurm(tmp_path_factory.mktemp("slurm"), hosts) as environment:
        yield environment


@pytest.fixture
def run(tmp_path: Path) -> Path:
    (tmp_path / "case.toml").write_text(LONGER)
    call("setup", tmp_path / "case.toml", "-o", tmp_path / "run")
    return tmp_path / "run"


def find_networks(run: Path) -> set[str]:
    """Networks in which ranks of `run` are now: one a host."""
    networks = set()
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
            if b"python" in words[0] and b"fbcouple.simulation.worker" in words and str(run).encode() in words:
                networks.add(os.readlink(process / "ns/net"))
        except OSError:
            continue  # ended in between
    return networks


def watch(run: Path, is_over: Callable[[], bool], seconds: float = 300.0) -> set[str]:
    """Networks in which ranks of `run` were seen until its job was over."""
    seen: set[str] = set()
    deadline = time.monotonic() + seconds
    while not is_over():
        assert time.monotonic() < deadline
        seen |= find_networks(run)
        time.sleep(0.1)
    return seen


def list_networks(hosts: list[Host]) -> set[str]:
    return {os.readlink(f"/proc/{host.process}/ns/net") for host in hosts}


def require_as_here(run: Path, *changed: str) -> None:
    """The run came to its end, with the numbers of two ranks on one machine; up to rounding where it noted that."""
    said = "".join(path.read_text() for path in (run / "batch").glob("*.out"))
    assert (run / "batch/state").read_text() == "0\n" and is_complete(run), said
    call("setup", run.parent / "case.toml", "-o", run.parent / "here", *changed)
    call("run", run.parent / "here", "-n", 2)
    with xr.open_dataset(run / "results.nc") as far, xr.open_dataset(run.parent / "here/results.nc") as near:
        assert far["pressure_drop"].size > 3
        within = 1e-9 if "updates" in far.attrs else 0.0
        for name in ("time", "pressure_drop", *(() if within else ("kinetic_energy",))):
            np.testing.assert_allclose(far[name], near[name], rtol=within)


@pytest.mark.parametrize("launcher", ["mpirun", "srun"])
def test_slurm_puts_the_ranks_on_two_hosts(hosts, slurm, run, launcher):
    pmi = ("--prelude", "export SLURM_MPI_TYPE=pmix") if launcher == "srun" else ()
    call("batch", run, "--scheduler", "slurm", *TWO, "--time", "00:10:00", "--launcher", launcher, *pmi)
    hand_in(run, slurm)
    assert watch(run, lambda: not list_jobs(slurm)) == list_networks(hosts)
    require_as_here(run)


def test_slurm_gives_notice_to_a_job_on_two_hosts_and_it_goes_on(hosts, slurm, run):
    """The notice comes when it is sent by hand here, as a limit would; the job stops, requeues itself and ends."""
    call("setup", run.parent / "case.toml", "-o", run, "--set", "end_time=0.1")
    call("batch", run, "--scheduler", "slurm", *TWO, "--time", "00:10:00")
    hand_in(run, slurm)
    watch(run, lambda: (run / LOG).is_file() and len((run / LOG).read_text().splitlines()) > 3)
    (job,) = (line.split()[0] for line in list_jobs(slurm))
    subprocess.run(["scancel", "--batch", "--signal=USR1", job], env=slurm, check=True)
    await_end(slurm, 600.0, run / "batch/state")
    said = "".join(path.read_text() for path in (run / "batch").glob("*.out"))
    assert said.count("a step from now") == said.count("resumes at t = ") == 1, said
    require_as_here(run, "--set", "end_time=0.1")


@pytest.mark.parametrize("system", ["pbs", "lsf"])
def test_other_jobs_reach_two_hosts_with_an_mpi_that_does_not_know_them(hosts, run, system):
    """Debian's Open MPI is built for neither: it needs a file of hosts, and starts ranks by a login of its own."""
    chain = ("--chain", 1) if system == "pbs" else ()
    call("batch", run, "--scheduler", system, *TWO, "--time", "00:10:00", *chain)
    nodes = run.parent / "nodes"
    nodes.write_text("".join(f"{host.name}\n" for host in hosts))
    names = {
        "pbs": {"PBS_NODEFILE": str(nodes)},
        "lsf": {"LSB_HOSTS": "box1 box2", "LSB_DJOB_HOSTFILE": str(nodes)},
    }[system]
    told = os.environ | names | {"OMPI_MCA_plm_rsh_agent": str(write_agent(run.parent, hosts))}
    with (run / "batch/job.out").open("w") as out:
        command = hosts[0].enter("bash", run / f"batch/{system}.sh")
        job = subprocess.Popen(command, env=told, cwd="/", stdout=out, stderr=out)
    try:
        networks = watch(run, lambda: job.poll() is not None)
    finally:
        job.terminate()  # the script hands it on
    assert networks == list_networks(hosts), (run / "batch/job.out").read_text()
    require_as_here(run)
