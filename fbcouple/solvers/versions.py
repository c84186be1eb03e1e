"""What a run is made with: fbcouple, both solvers, MPI, Python and its libraries, and the machine."""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import platform
import re
import shutil
import sys
from functools import cache
from pathlib import Path

from fbcouple.case.schema.sections import Case
from fbcouple.errors import SolverError
from fbcouple.machine.environment import mpi_environment
from fbcouple.machine.programs import run_program
from fbcouple.paths import ABOVE, PACKAGE
from fbcouple.run_folder.provenance import Versions
from fbcouple.solvers.openfoam.build import adapter_path, find_installation
from fbcouple.solvers.site_files import find_liggghts
from fbcouple.version import __version__

NOT_FOUND = "not found"
NO_CHECKOUT = "not a checkout"
_NO_PART = ("batch", "bench", "cli", "doctor", "postproc", "study", "validate", "verify")
"""Folders of the package that have no part in a run's numbers."""
_LIBRARIES = ("numpy", "numba", "scipy")
_PROBE = """
import ctypes, pathlib, sys
ctypes.CDLL(sys.argv[1], ctypes.RTLD_GLOBAL)
lines = pathlib.Path("/proc/self/maps").read_text(encoding="utf-8", errors="surrogateescape").splitlines()
files = {line.split(None, 5)[5] for line in lines if ".so" in line}
print(next(file for file in files if pathlib.Path(file).name.startswith(sys.argv[1].partition(".so")[0])))
"""


def list_own_versions() -> Versions:
    """What the start of a run depends on, as far as no solver has to be there: fbcouple, Python, numpy, machine."""
    return {
        "fbcouple": f"{__version__}, sources {hash_sources()}",
        "commit": find_commit(),
        "python": platform.python_version(),
        "numpy": importlib.metadata.version("numpy"),
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores, {platform.node()}",
    }


def list_versions(case: Case) -> Versions:
    """What a run of `case` is made with, here and now; what cannot be found says so, for the run itself will."""
    versions = list_own_versions() | {name: importlib.metadata.version(name) for name in _LIBRARIES}
    if case.gas:
        versions |= _find_openfoam()
    if case.particles:
        versions["LIGGGHTS"] = _find_liggghts()
    return versions | {"MPI": _ask("mpirun", "--version")}


@cache
def hash_sources() -> str:
    """A hash of the sources that have a part in a run's numbers, so that an update of fbcouple is seen."""
    files = [path for kind in ("py", "cpp", "hpp") for path in PACKAGE.glob(f"**/*.{kind}")]
    parts = sorted(
        (str(inner), path) for path in files if (inner := path.relative_to(PACKAGE)).parts[0] not in _NO_PART
    )
    texts = b"".join(name.encode() + b"\0" + path.read_bytes() for name, path in parts)
    return hashlib.sha256(texts).hexdigest()[:16]


def format_own_version() -> str:
    """The version of fbcouple, with the commit where it lies in a checkout."""
    commit = find_commit()
    return __version__ if commit in (NO_CHECKOUT, NOT_FOUND) else f"{__version__}, commit {commit}"


def find_commit() -> str:
    """The commit of the checkout that this fbcouple lies in, and whether files were changed since; or that it is in
    none."""
    checkout = ABOVE
    if not (checkout / ".git").exists() or not (checkout / "pyproject.toml").is_file():
        return NO_CHECKOUT
    return _ask("git", "-C", str(checkout), "describe", "--always", "--abbrev=12", "--dirty", "--exclude=*")


def _find_openfoam() -> Versions:
    try:
        return {"OpenFOAM": find_installation().version, "adapter": adapter_path().stem}
    except SolverError:
        return {"OpenFOAM": NOT_FOUND, "adapter": NOT_FOUND}


def _find_liggghts() -> str:
    """Version and hash of the library that a rank would load; it is loaded in a process of its own."""
    try:
        named = find_liggghts(_load_elsewhere)
        file = Path(named if os.path.isabs(named) else _load_elsewhere(named))
        content = file.read_bytes()
    except (SolverError, OSError):
        return NOT_FOUND
    version = re.search(rb"LIGGGHTS-[A-Z]+ \d[\w.]*", content)
    return f"{version[0].decode() if version else file.name}, library {hashlib.sha256(content).hexdigest()[:16]}"


def _load_elsewhere(name: str) -> str:
    """The file that the loader takes for library `name`. Raises: OSError with its words."""
    done = run_program([sys.executable, "-I", "-c", _PROBE, name], mpi_environment())
    if done.returncode:
        raise OSError((done.stderr.strip().splitlines() or ["no words"])[-1])
    return done.stdout.splitlines()[0]


def _ask(*command: str) -> str:
    """First line that a program prints."""
    if not shutil.which(command[0]):
        return NOT_FOUND
    done = run_program(command, mpi_environment())
    lines = done.stdout.splitlines()
    return lines[0].strip() if lines and done.returncode == 0 else NOT_FOUND
