"""NetCDF files that anyone may have written: nothing of them is read before their size is known to be true."""

from __future__ import annotations

import math
import re
from pathlib import Path

import xarray as xr
from netCDF4 import Dataset

from fbcouple.errors import CaseError

DENSEST = 1100
"""Bytes that a byte of a compressed file can stand for: zlib packs no more than 1032 to 1."""
SMALL = 10_000_000
"""Bytes that are read whatever the file's size."""
_TEXT = 64
"""Bytes counted for an entry that is a text."""
_AGAIN = "`fbcouple run RUN --resume` writes it anew from a checkpoint; without one, run the case again."
_POOL = (
    "`fbcouple pool RUN -o FILE --reduced` writes such a file anew of the runs in it; without them, take another copy."
)
_REASONS = (OSError, ValueError, RuntimeError, TypeError, KeyError, AttributeError, OverflowError)
"""What the libraries below raise at a damaged or odd file."""


def load(path: Path) -> xr.Dataset:
    """Read all of a NetCDF file into memory.

    Raises: CaseError (one text) if it is no NetCDF, or says that it holds more than its bytes, or this machine's
    memory, can hold.
    """
    try:
        claimed = _count_bytes(path)
        _require_true(path, claimed)
        with xr.open_dataset(path, decode_times=False, engine="netcdf4") as stored:
            return stored.load()
    except _REASONS as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise CaseError([f"{path} cannot be read as NetCDF ({reason}). {tell_mend(path)}"]) from error


def tell_mend(path: Path) -> str:
    """What mends a damaged file: results and frames of a run are written anew by it, a file of means by its runs."""
    is_of_run = path.name == "results.nc" or path.parent.name == "frames"
    return _AGAIN if is_of_run else _POOL


def _count_bytes(path: Path) -> int:
    """Bytes that the file's variables say they have."""
    with Dataset(str(path)) as file:
        return sum(math.prod(v.shape) * (v.dtype.itemsize if v.dtype is not str else _TEXT) for v in _list(file))


def _list(file: Dataset) -> list:  # type: ignore[type-arg]
    return [*file.variables.values(), *(v for group in file.groups.values() for v in _list(group))]


def _require_true(path: Path, claimed: int) -> None:
    if claimed <= SMALL:
        return
    length = path.stat().st_size
    if claimed > DENSEST * length:
        said = f"it says that it holds {claimed / 1e9:.3g} GB, and has {length / 1e6:.3g} MB"
        raise CaseError([f"{path}: {said}: it is damaged, or no file of fbcouple. {tell_mend(path)}"])
    free = find_free_memory()
    if 2 * claimed > free:
        said = f"it holds {claimed / 1e9:.3g} GB, to be worked on twice that, and this machine has {free / 1e9:.3g} GB"
        raise CaseError([f"{path}: {said} of memory free; draw its figures on a larger machine."])


def find_free_memory() -> float:
    """Bytes of memory that are free on this machine; infinity where it does not tell."""
    try:
        words = re.search(r"^MemAvailable:\s+(\d+) kB", Path("/proc/meminfo").read_text("ascii"), re.MULTILINE)
    except OSError:
        return math.inf
    return 1024.0 * int(words[1]) if words else math.inf
