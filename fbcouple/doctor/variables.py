"""What a site may have of its own: the variables by which it says so, and what its LIGGGHTS can do."""

from __future__ import annotations

import os

from fbcouple.errors import CaseError, SolverError
from fbcouple.machine.launchers import BIND, LAUNCHER, mpi_command
from fbcouple.solvers.openfoam.build import find_installation
from fbcouple.solvers.site_files import LIGGGHTS, OPENFOAM_SOURCE, find_liggghts, find_openfoam_source

VARIABLES = ("FBCOUPLE_CACHE", LIGGGHTS, OPENFOAM_SOURCE, LAUNCHER, BIND, "WM_PROJECT_DIR")
"""Variables that `fbcouple doctor` shows."""
CAPABILITIES = """
import ctypes, pathlib, re, sys
library = ctypes.CDLL(sys.argv[1], ctypes.RTLD_GLOBAL)
if missing := [name for name in sys.argv[2:] if not hasattr(library, name)]:
    sys.exit(f"has no function {', '.join(missing)}")
address = ctypes.cast(library.lammps_open, ctypes.c_void_p).value
for line in pathlib.Path("/proc/self/maps").read_text(encoding="utf-8", errors="surrogateescape").splitlines():
    start, end = (int(one, 16) for one in line.split()[0].split("-"))
    if start <= address < end:
        content = pathlib.Path(line.split(None, 5)[5]).read_bytes()
        version = re.search(rb"LIGGGHTS-[A-Z]+ \\d[\\w.]*", content)
        print(version[0].decode() if version else "LIGGGHTS" if b"LIGGGHTS" in content else "not LIGGGHTS by its name")
"""
"""A program that says, in a process of its own, what the library named first is and which functions it lacks."""


def list_wrong_variables() -> list[str]:
    """What of them names what is not there, a text each."""
    problems = []
    try:
        mpi_command(1, [])
    except CaseError as error:
        problems += error.problems
    try:
        if os.environ.get(LIGGGHTS):
            find_liggghts()
        if os.environ.get(OPENFOAM_SOURCE):
            find_openfoam_source(find_installation().version.partition(".")[0].partition("-")[0])
    except SolverError as error:
        problems.append(str(error))
    return problems
