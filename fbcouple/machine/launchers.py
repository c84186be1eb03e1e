"""How ranks are started: the launcher that a site has, how it binds ranks to cores, and what its own mpirun takes.

`FBCOUPLE_LAUNCHER` names it (mpirun, mpiexec, srun, aprun) and `FBCOUPLE_BIND` what a rank is bound to (none, core,
socket, numa); job scripts of `fbcouple batch` set both. Unset: mpirun, and no rank is bound.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from fbcouple.errors import CaseError
from fbcouple.machine.environment import child_environment, mpi_environment
from fbcouple.machine.programs import run_program

LAUNCHER, BIND = "FBCOUPLE_LAUNCHER", "FBCOUPLE_BIND"
"""Environment variables that a run reads."""
OVERSUBSCRIBE = "OMPI_MCA_rmaps_base_oversubscribe"
"""Environment variable by which a user of Open MPI says that ranks may share cores."""
_OF_MPI = {"none": "none", "core": "core", "socket": "socket", "numa": "numa"}
BINDINGS: dict[str, tuple[str, dict[str, str]]] = {
    "mpirun": ("--bind-to", _OF_MPI),
    "mpiexec": ("--bind-to", _OF_MPI),
    "srun": ("--cpu-bind", {"none": "none", "core": "cores", "socket": "sockets", "numa": "ldoms"}),
    "aprun": ("-cc", {"none": "none", "core": "cpu", "numa": "numa_node"}),
}
"""Launcher -> its option for what a rank is bound to, and its word for each."""
_OPEN_MPI = "Open MPI"
_HOST_FILES = ("PBS_NODEFILE", "LSB_DJOB_HOSTFILE")
"""Where PBS and LSF name the file of a job's hosts, a line for each rank."""
_READ_BY_RANKS = re.compile(r"PATH|LD_\w+|GLIBC_TUNABLES|(PYTHON|FBCOUPLE_|NUMBA_|OMP_|WM_|FOAM_)\w*")
"""Variables that a rank reads or that its libraries do."""


def mpi_command(ranks: int, program: list[str]) -> list[str]:
    """The command line that starts `program` on `ranks` ranks; more ranks than cores share them.

    Raises: CaseError if a variable above names what is not known.
    """
    launcher, bind = _read(LAUNCHER, "mpirun", BINDINGS), os.environ.get(BIND) or "none"
    option, words = BINDINGS[launcher]
    _read(BIND, "none", words)
    command = [launcher, "-n", str(ranks)]
    is_open = launcher in ("mpirun", "mpiexec") and name_mpi(launcher) == _OPEN_MPI
    if is_open or launcher in ("srun", "aprun"):
        command += [option, words[bind]] if option == "-cc" or is_open else [f"{option}={words[bind]}"]
    elif bind != "none":
        command += ["-bind-to", words[bind]]  # Hydra of MPICH, which binds nothing unless it is told to
    if is_open and count_nodes() > 1:
        command += _reach_nodes()
    return [*command, *(["--oversubscribe"] if is_open and _is_crowded(ranks) else []), *program]


def name_mpi(launcher: str) -> str:
    """Whose MPI the program `launcher` on the PATH says that it is of: Open MPI, MPICH, Intel MPI, or unknown.

    One that is not found is taken for Open MPI, whose lack the start of the run tells.
    """
    return _ask(launcher, child_environment().get("PATH", os.defpath))


@cache
def _ask(launcher: str, path: str) -> str:
    try:
        done = run_program([launcher, "--version"], child_environment() | {"PATH": path})
    except OSError:
        return _OPEN_MPI
    words = done.stdout + done.stderr
    known = {_OPEN_MPI: r"Open MPI|OpenRTE|open-mpi", "Intel MPI": r"Intel\(R\) MPI", "MPICH": r"HYDRA|MPICH"}
    return next((name for name, pattern in known.items() if re.search(pattern, words)), "unknown")


def count_nodes(given: Mapping[str, str] = os.environ) -> int:
    """Nodes of the batch job that this process is in; 1 outside of one."""
    if (slurm := given.get("SLURM_JOB_NUM_NODES", "")).isdecimal():
        return int(slurm)
    if places := _list_places(given):
        return len(set(places))
    return max(len(set(given.get("LSB_HOSTS", "").split())), 1)


def _list_places(given: Mapping[str, str]) -> list[str]:
    """Host of each rank that a job of PBS or LSF has a place for, in their order; none where no file says it."""
    files = [Path(given[variable]) for variable in _HOST_FILES if given.get(variable)]
    return next((file.read_text(encoding="utf-8", errors="replace").split() for file in files if file.is_file()), [])


def _reach_nodes() -> list[str]:
    """What mpirun of Open MPI needs for ranks on the other nodes of a job. Where it was built without the batch system
    (Debian's knows SLURM alone) it has to be told the hosts and how many ranks each is for, or starts all ranks on the
    first; and what starts a rank on another node brings this environment along by SLURM only."""
    places = Counter(_list_places(os.environ))
    hosts = ",".join(f"{host}:{ranks}" for host, ranks in places.items())
    brought = [name for name in sorted(mpi_environment()) if _READ_BY_RANKS.fullmatch(name)]
    return [*(["--host", hosts] if hosts else []), *(word for name in brought for word in ("-x", name))]


def _read(variable: str, default: str, allowed: Mapping[str, object]) -> str:
    given = os.environ.get(variable) or default
    if given not in allowed:
        raise CaseError([f"{variable}: {given!r} is given, allowed: {', '.join(allowed)}; unset it for {default}."])
    return given


def tell_crowd(ranks: int, jobs: int = 1) -> str:
    """That `jobs` runs on `ranks` ranks each have more ranks than there are places for them; "" where they have not, or
    where somebody said so: a batch system that gives the places, a launcher that asks it for them, or Open MPI's own
    variable."""
    places, is_meant = count_places(), os.environ.get(OVERSUBSCRIBE, "").lower() in ("1", "true", "yes")
    if ranks * jobs <= places or is_meant or os.environ.get(LAUNCHER) in ("srun", "aprun"):
        return ""
    asked = f"{jobs} runs of {ranks} rank{'s' * (ranks > 1)} at a time are" if jobs > 1 else f"{ranks} ranks are"
    here = f"{places} core{'s' * (places > 1)}"
    return f"{asked} asked for, on {here}: ranks that share a core wait for each other, and fewer of them are faster"


def count_places(given: Mapping[str, str] = os.environ) -> int:
    """Ranks that there is a place for: cores that this process has on each node, or what a batch job says of its tasks
    and cores, whichever is more."""
    cores = re.findall(r"(\d+)(?:\(x(\d+)\))?", given.get("SLURM_JOB_CPUS_PER_NODE", ""))
    tasks = given.get("SLURM_NTASKS", "")
    own = len(os.sched_getaffinity(0)) * count_nodes(given)
    of_slurm = sum(int(count) * int(nodes or 1) for count, nodes in cores), int(tasks) if tasks.isdecimal() else 0
    return max(own, *of_slurm, len(_list_places(given)), len(given.get("LSB_HOSTS", "").split()))


def _is_crowded(ranks: int) -> bool:
    """Are there more ranks than cores of this machine? The nodes of a job have their own places, counted by mpirun."""
    return _has_cores_of_a_step(ranks) or (count_nodes() == 1 and ranks > len(os.sched_getaffinity(0)))


def _has_cores_of_a_step(ranks: int) -> bool:
    """Does SLURM's `srun -n 1 -c CORES` give the cores for `ranks`? mpirun counts the one task."""
    cores = os.environ.get("SLURM_CPUS_ON_NODE", "")
    return "SLURM_STEP_ID" in os.environ and cores.isdecimal() and 1 < ranks <= int(cores)
