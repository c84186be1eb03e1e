"""Load a C library from one table of its functions: name, result, argument types."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fbcouple.errors import SolverError

Signature = tuple[Any, Sequence[Any]]


def load_library(name: str | Path, table: Mapping[str, Signature], mend: str) -> ctypes.CDLL:
    """Load shared library `name` and declare every function of `table`.

    Raises SolverError that names the library, the loader's own words and `mend` if it is missing or too old.
    """
    try:
        library = ctypes.CDLL(str(name), mode=ctypes.RTLD_GLOBAL)
    except OSError as error:
        raise SolverError(f"library {name} cannot be loaded: {error}; mend: {mend}") from error
    for function, (result, arguments) in table.items():
        try:
            entry = getattr(library, function)
        except AttributeError as error:
            raise SolverError(f"library {name} has no function {function}; mend: {mend}") from error
        entry.restype = result
        entry.argtypes = list(arguments)
    return library
