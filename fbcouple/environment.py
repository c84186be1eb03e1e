"""How programs under MPI are started: their environment and command line."""

from __future__ import annotations

import os
from pathlib import Path


def mpi_environment() -> dict[str, str]:
    """One thread a rank; Open MPI may run as root where the caller is root (containers, CI)."""
    own = {"OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
    if os.geteuid() == 0:
        own |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    project = os.environ.get("WM_PROJECT_DIR", "/usr/share/openfoam")
    return {"WM_PROJECT_DIR": project} | os.environ | own | {"FOAM_CONTROLDICT": make_control_dict(Path(project))}


def make_control_dict(project: Path) -> str:
    """OpenFOAM's global controlDict with compiling and system calls from a case switched off, and any path allowed.

    FOAM_CONTROLDICT takes the place of every etc/controlDict; of an entry that is given twice the last one counts.
    With `fileName` on, as OpenFOAM has it, blanks and quotes are taken out of the path of the current folder.
    Empty, which OpenFOAM takes for not set, where `project` has none.
    """
    file = project / "etc/controlDict"
    text = file.read_text(encoding="utf-8", errors="replace") if file.is_file() else ""
    return f"{text}\nInfoSwitches {{ allowSystemOperations 0; }}\nDebugSwitches {{ fileName 0; }}\n" if text else ""


def mpi_command(ranks: int, program: list[str]) -> list[str]:
    """The command line that starts `program` on `ranks` ranks; more ranks than cores share them."""
    crowded = ["--oversubscribe"] if ranks > len(os.sched_getaffinity(0)) else []
    return ["mpirun", "-n", str(ranks), "--bind-to", "none", *crowded, *program]
