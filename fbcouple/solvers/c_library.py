"""Load a C library from one table of its functions: name, result, argument types."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fbcouple.errors import SolverError

MPI_LIBRARY = r"libmpi\.so|libmpich|libmpi\.\d"
"""Pattern of the file name of an MPI library."""
Signature = tuple[Any, Sequence[Any]]


def load_library(name: str | Path, table: Mapping[str, Signature], mend: str) -> ctypes.CDLL:
    """Load shared library `name` and declare every function of `table`.

    Raises SolverError that names the library, the loader's own words and `fix` if it is missing or too old, or brings
    an MPI of its own.
    """
    try:
        library = ctypes.CDLL(str(name), mode=ctypes.RTLD_GLOBAL)
    except OSError as error:
        raise SolverError(f"library {name} cannot be loaded: {error}; fix: {mend}") from error
    if len(known := _find_mpi_libraries()) > 1:
        raise SolverError(f"library {name} brings another MPI: {' and '.join(known)} are loaded; fix: {mend}")
    for function, (result, arguments) in table.items():
        try:
            entry = getattr(library, function)
        except AttributeError as error:
            raise SolverError(f"library {name} has no function {function}; fix: {mend}") from error
        entry.restype = result
        entry.argtypes = list(arguments)
    return library


def _find_mpi_libraries() -> list[str]:
    """Files of the MPI libraries in this process: two of them do not know of each other's ranks."""
    lines = Path("/proc/self/maps").read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    files = {line.split(None, 5)[5] for line in lines if ".so" in line}
    return sorted(file for file in files if re.match(MPI_LIBRARY, Path(file).name))
