"""The solvers' files that a site names itself: a LIGGGHTS library of its own, and the source of its OpenFOAM."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable
from pathlib import Path

from fbcouple.errors import SolverError

LIGGGHTS, OPENFOAM_SOURCE = "FBCOUPLE_LIGGGHTS", "FBCOUPLE_OPENFOAM_SOURCE"
"""Environment variables that name a library file, and a source tree of the OpenFOAM whose libraries are installed."""
LIGGGHTS_NAMES = ("libliggghts.so.3", "libliggghts.so", "liblmp_auto.so")
"""Names of LIGGGHTS' library, in the order in which they are tried: Debian's, and those of its own makefiles."""
FUNCTIONS = (
    "lammps_open",
    "lammps_close",
    "lammps_file",
    "lammps_command",
    "lammps_extract_global",
    "lammps_extract_atom",
    "lammps_extract_fix",
)
"""Functions of LIGGGHTS' library that the coupling calls."""
_ABSENT = "cannot open shared object file: No such file or directory"


def find_liggghts(load: Callable[[str], object] = ctypes.CDLL) -> str:
    """What to load LIGGGHTS by: the file that FBCOUPLE_LIGGGHTS names, else the first name that the loader finds, else
    Debian's.

    `load` raises OSError with the loader's words; one that is there and does not load is the one, for those words tell
    what is wrong. Raises: SolverError if the variable names no file.
    """
    if named := _named(LIGGGHTS):
        if not named.is_file():
            raise SolverError(f"{LIGGGHTS}={named}: no such file; name LIGGGHTS' library, or unset {LIGGGHTS}")
        return str(named)
    for name in LIGGGHTS_NAMES:
        try:
            load(name)
        except OSError as error:
            if f"{name}: {_ABSENT}" in str(error):
                continue
        return name
    return LIGGGHTS_NAMES[0]


def find_openfoam_source(api: str) -> Path | None:
    """The source tree that FBCOUPLE_OPENFOAM_SOURCE names, None if it is not set.

    Raises: SolverError if it is no source of OpenFOAM version `api`, whose libraries are installed.
    """
    named = _named(OPENFOAM_SOURCE)
    if named is None:
        return None
    about = named / "META-INFO" / "api-info"
    words = about.read_text(encoding="utf-8", errors="replace").split() if about.is_file() else []
    if f"api={api}" not in words or not (named / "wmake" / "wmakeLnInclude").is_file():
        found = next((word for word in words if word.startswith("api=")), "no source of openfoam.com")
        text = f"{found}; allowed: the source tree of api={api}, which is installed, with src/ and wmake/"
        raise SolverError(f"{OPENFOAM_SOURCE}={named}: {text}; name it, or unset {OPENFOAM_SOURCE}")
    return named


def _named(variable: str) -> Path | None:
    given = os.environ.get(variable)
    return Path(os.path.abspath(os.path.expanduser(given))) if given else None
