"""Several runs at once, from Python."""

from __future__ import annotations

import math
import os
import warnings
from contextlib import suppress
from pathlib import Path
from shlex import quote
from typing import Any

from fbcouple.api import Run, Status
from fbcouple.arguments import in_python, say_in_python
from fbcouple.batch.folders import find_runs
from fbcouple.batch.side_by_side import require_done, run_all
from fbcouple.decks.replicas import make_replicas
from fbcouple.errors import StoppedError
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.launchers import tell_crowd


@in_python()
def start_replicas(
    run: Run | str | os.PathLike[str], count: int, *, jobs: int = 1, ranks: int = 1, **options: Any
) -> list[Run]:
    """Run `count` replicas of the case in `run`, with different seeds, `jobs` at a time on `ranks` MPI ranks each.

    run: a run folder, which becomes a folder of run folders, and what lies in it the first of them; or such a folder,
    whose replicas go on from their checkpoints. options: as for `run_set`.

    Returns: the replicas. Raises: CaseError if no seed changes the case or there are another number of replicas, and as
    `run_set`.
    """
    folder = Path(run)
    found = make_replicas(folder, count)
    run_set(folder, jobs=jobs, ranks=ranks, **options)
    return [Run(replica) for replica in found]


@in_python()
def run_set(
    folder: str | os.PathLike[str],
    *,
    jobs: int = 1,
    ranks: int = 1,
    fresh: bool = False,
    trust: bool = False,
    wall_limit: float = math.inf,
) -> list[Status]:
    """Run what is not complete of the run folders in `folder`, `jobs` at a time on `ranks` MPI ranks each.

    fresh: start all again; trust: as on the command line; wall_limit [s]: before it is over all stop with
    checkpoints.

    Returns: how far each has come, by name; one that stopped with a checkpoint raises nothing. Raises: as `Run.start`
    for the first that failed, with a text for each that did.
    """
    runs = find_runs(Path(folder), _warn)
    if crowd := tell_crowd(ranks, min(jobs, len(runs))):
        _warn(crowd)
    options = ["-n", str(ranks), "--fresh" if fresh else "--resume", *(["--trust"] if trust else [])]
    with Requests() as requests:
        ended = run_all(runs, jobs, options, requests, wall_limit=wall_limit)
    with suppress(StoppedError):
        require_done(runs, ended, f"`fbcouple run {quote(os.fspath(folder))}`")
    return [Run(one).status() for one in runs]


def _warn(text: str) -> None:
    warnings.warn(say_in_python(text), stacklevel=5)
