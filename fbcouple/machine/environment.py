"""How child processes are started: their environment.

Whatever starts a child takes its environment from here. Code, libraries and programs of the current folder, which may
be a run folder of somebody else, are never found there: Python's own search leaves that folder out, and entries of
search paths that are empty or relative, which mean it, are dropped. Folders of compiled code are named from the root,
because a child may work in another folder.
"""

from __future__ import annotations

import os
import re
import site
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from fbcouple.errors import SolverError
from fbcouple.paths import ABOVE, cache_folder

_SEARCHED = {
    "PATH": ":",
    "LD_LIBRARY_PATH": "[:;]",
    "PYTHONPATH": ":",
    "LIBRARY_PATH": ":",
    "CPATH": ":",
    "C_INCLUDE_PATH": ":",
    "CPLUS_INCLUDE_PATH": ":",
}
"""Variables that hold a list of folders, and what parts their entries."""
_OUTER_JOB = ("OMPI_COMM_WORLD_RANK", "OMPI_MCA_orte_launch", "PMIX_RANK", "PMIX_NAMESPACE", "PMI_RANK", "PMI_FD")
"""Variables by which a process knows that an MPI launcher started it."""
_OF_OUTER_JOB = re.compile(
    r"OMPI_(?!MCA_|ALLOW_RUN_AS_ROOT)\w+"
    r"|OMPI_MCA_(ess(_\w+)?|pmix|initial_wdir|mpi_oversubscribe|shmem_RUNTIME_QUERY_hint)"
    r"|OMPI_MCA_(rmaps|ras|plm|hwloc_base)_\w+"
    r"|OMPI_MCA_orte_(app_num|bound_at_launch|ess_\w+|hnp_uri|jobfam_session_dir|launch|local_daemon_uri|num_nodes"
    r"|precondition_transports|top_session_dir)"
    r"|PMIX_(?!MCA_)\w+|PRTE_(?!MCA_)\w+|PMI2?_\w+|HYDI_\w+|MPI_LOCAL(NRANKS|RANKID)"
)
"""What that launcher tells its own ranks; settings of the user's (OMPI_MCA_btl ...) are not among them."""


HUGE_PAGES = "glibc.malloc.hugetlb=1:glibc.malloc.mmap_threshold=33554432:glibc.malloc.trim_threshold=268435456"
"""What glibc (2.35 and later; others read past it) is told: to ask for huge pages where the system gives them to who
asks, and to put arrays below 32 MiB side by side, so that they share them; what is freed is kept up to 256 MiB."""


def child_environment(given: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Environment of a child process: `given` without what leads to the current folder or to an outer MPI job.

    Python children find this very package first, and no module of the current folder, whether they are started by
    `-m`, `-c` or as a grandchild.
    """
    outer = is_in_mpi_job(given)
    told = {name: value for name, value in given.items() if not (outer and _OF_OUTER_JOB.fullmatch(name))}
    for name, sign in _SEARCHED.items():
        entries = [entry for entry in re.split(sign, told.pop(name, "")) if os.path.isabs(entry)]
        if name == "PYTHONPATH":
            entries = [*find_package(), *(entry for entry in entries if entry not in find_package())]
        if entries:
            told[name] = ":".join(entries)
    if cache := told.get("NUMBA_CACHE_DIR"):
        told["NUMBA_CACHE_DIR"] = os.path.abspath(cache)
    return told | {"PYTHONSAFEPATH": "1", "FBCOUPLE_CACHE": str(cache_folder().absolute())}


def find_package() -> list[str]:
    """Return what must stand on PYTHONPATH: the folder of fbcouple and postproc, unless Python finds it by itself.

    The folder of installed packages, put there, would come before the standard library.
    """
    folder = str(ABOVE)
    installed = [*site.getsitepackages(), site.getusersitepackages()]
    return [] if folder in map(os.path.realpath, installed) else [folder]


def is_in_mpi_job(given: Mapping[str, str] = os.environ) -> bool:
    """Was this process started as a rank of an MPI job?"""
    return any(name in given for name in _OUTER_JOB)


@contextmanager
def hand_down() -> Iterator[None]:
    """Make this process's own environment that of a child, for what starts children without asking for one."""
    before = dict(os.environ)
    _replace_environment(child_environment())
    try:
        yield
    finally:
        _replace_environment(before)


def _replace_environment(wanted: Mapping[str, str]) -> None:
    os.environ.clear()
    os.environ.update(wanted)


def missing_program(name: str, package: str) -> SolverError:
    """The error of a program that is not found, for the caller to raise; `package` of Debian brings it."""
    relative = [entry for entry in os.environ.get("PATH", "").split(":") if not os.path.isabs(entry)]
    hint = f" (its entries that are not absolute, {relative}, are not searched)" if relative else ""
    return SolverError(f"{name} is not on the PATH{hint}; fix: sudo apt-get install {package}")


def mpi_environment() -> dict[str, str]:
    """A child's environment with one thread a rank.

    Open MPI may run as root where the caller is root (containers, CI), and a rank that waits lets others have its core:
    by default Open MPI does so only where this one job has more ranks than cores, and two jobs on the cores of one take
    twice the time that they need. Arrays lie in huge pages: loops over neighbours jump about in them, and small pages
    are looked up again and again. Values of the caller's own (OMPI_MCA_mpi_yield_when_idle, GLIBC_TUNABLES) stand.
    """
    own = {"OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
    if os.geteuid() == 0:
        own |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    project = os.environ.get("WM_PROJECT_DIR", "/usr/share/openfoam")
    return (
        {"WM_PROJECT_DIR": project, "OMPI_MCA_mpi_yield_when_idle": "1", "GLIBC_TUNABLES": HUGE_PAGES}
        | child_environment()
        | own
        | {"FOAM_CONTROLDICT": make_control_dict(Path(project))}
    )


def make_control_dict(project: Path) -> str:
    """OpenFOAM's global controlDict with compiling and system calls from a case switched off, and any path allowed.

    FOAM_CONTROLDICT takes the place of every etc/controlDict; of an entry that is given twice the last one counts.
    With `fileName` on, as OpenFOAM has it, blanks and quotes are taken out of the path of the current folder.
    Empty, which OpenFOAM takes for not set, where `project` has none.
    """
    file = project / "etc/controlDict"
    text = file.read_text(encoding="utf-8", errors="replace") if file.is_file() else ""
    return f"{text}\nInfoSwitches {{ allowSystemOperations 0; }}\nDebugSwitches {{ fileName 0; }}\n" if text else ""
