"""CFD-DEM of fluidized beds: stock OpenFOAM (gas) and stock LIGGGHTS (particles) in one MPI job."""

import hashlib
import os
from pathlib import Path

from fbcouple.places import cache_folder

__version__ = "0.1.0"

_PREFIX = "loops-"
_COMPILED = "exchange", "meshes"
"""Folders whose loops are compiled into one another."""


def _name_compiled() -> str:
    """Where Numba is to keep what it compiles: a name that changes with the sources.

    Numba itself looks at the file of a loop alone: after an update of a function that is compiled into others, such as
    a power in the drag laws, it would go on with those of before.
    """
    files = sorted(path for name in _COMPILED for path in (Path(__file__).parent / name).glob("*.py"))
    sources = hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:16]
    return str(cache_folder() / f"{_PREFIX}{sources}")


# A place of the user's own stands; that of an fbcouple that started this one does not.
if Path(os.environ.get("NUMBA_CACHE_DIR", _PREFIX)).name.startswith(_PREFIX):
    os.environ["NUMBA_CACHE_DIR"] = _name_compiled()
# Results are written beside their name and renamed, so nobody meets a file that is being written; HDF5's own locks only
# keep them from being read or written on file systems that have none.
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")
