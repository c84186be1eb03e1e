"""Pools on disk."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from fbcouple.errors import CaseError
from fbcouple.machine.whole_files import require_writable
from fbcouple.paths import expand_replicas
from fbcouple.results.later_means import begin_later
from fbcouple.results.pooling import pool
from fbcouple.results.reader import RESULTS
from fbcouple.results.reduced import pool_reduced, write
from fbcouple.results.replicas import REDUCED, open_replicas


def write_pool(
    runs: Sequence[Path],
    path: Path,
    reduced: bool = False,
    start: float | None = None,
    defaults: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Pool `runs` (run folders, folders of replicas, files) into `path`; reduced: with depth averages alone, as it is
    where one of them has no more than that, and with `start` [s], from which on the blocks of their windows count;
    defaults: of the options of a case by dotted key, for runs that an fbcouple without some of them made.

    Returns: what is written. Raises: CaseError if they cannot be pooled, or the file cannot be written.
    """
    if path.suffix != ".nc":
        raise CaseError([f"{path}: is given for a pool, a file NAME.nc is allowed; give it that ending."])
    given = [file for one in expand_replicas(runs) for file in (one, one / RESULTS) if file.is_file()]
    if any(path.resolve() == file.resolve() for file in given):
        raise CaseError([f"{path}: is one of the files that are pooled; give another file."])
    if path.name == RESULTS and (path.parent / "case.toml").is_file():
        raise CaseError([f"{path}: holds the results of the run in that folder; give another file."])
    require_writable(path, "give another file")
    replicas = open_replicas(runs)
    if start is not None:
        replicas = [begin_later(one, start) for one in replicas]
    is_small = reduced or any(one.data.attrs.get(REDUCED) for one in replicas)
    data = pool_reduced(replicas, defaults) if is_small else pool(replicas, defaults)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write(path, data)
    except OSError as error:
        raise CaseError([f"{path}: cannot be written ({error}); give another file."]) from error
    return data
