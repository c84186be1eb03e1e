"""The parent process of a run: prepares the folder and the mesh, starts the MPI job and says how it ended."""

from __future__ import annotations

import json
import math
import os
import platform
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path
from shlex import quote

import xarray as xr

import fbcouple.checkpoint
from fbcouple.cache import prepare_compiled
from fbcouple.case.load import load_case
from fbcouple.case.schema import Case
from fbcouple.checkpoint import FOLDER, Checkpoint
from fbcouple.environment import mpi_command
from fbcouple.errors import CaseError, SolverError
from fbcouple.failure import SOLVER_LOGS, prepare_failure
from fbcouple.job import Job, Requests, Watch
from fbcouple.lock import hold
from fbcouple.mesh import prepare_mesh, resume_mesh
from fbcouple.places import FRAMES, PULSE

PATIENCE = 600.0
_PRODUCTS = ("results.nc", FRAMES, FOLDER, "figures", "report.html", "report.json")
_ALMOST = 1 - 1e-9
_LOG = "logs/run.jsonl"

Say = Callable[[str], None]


def launch(
    run: Path,
    ranks: int,
    watch: Watch,
    *,
    until: float | None = None,
    fresh: bool = False,
    resume: bool = False,
    wall_limit: float = math.inf,
    patience: float = PATIENCE,
    say: Say = lambda text: None,
) -> None:
    """Run the case in `run` on `ranks` MPI ranks to its end; `watch` sees each history row.

    until [s]: stop, with a checkpoint, at the first moment for one at or after it; resume: from the newest checkpoint
    that is whole; wall_limit [s]: wall time by which it has to be over; patience [s]: wall time without a coupling step
    after which it is taken for hanging; say: told what is refused.

    Raises CaseError if `run` is no run folder, holds what neither `fresh` nor `resume` speaks of, or has only damaged
    checkpoints; SolverError with the solver's own last words; DivergedError if a check of the run failed;
    StoppedError if it stopped early with a checkpoint.
    """
    begin = time.time()
    if not (run / "manifest.json").exists():
        raise CaseError([f"{run}: is not a run folder; make one with: fbcouple setup CASE -o {quote(str(run))}"])
    with hold(run) as lock, Requests() as requests:
        try:
            command = _prepare(run, ranks, until, fresh, resume, begin + wall_limit, say)
        except OSError as error:
            raise SolverError(f"{run}: cannot be made ready: {error}") from error
        if command:
            Job(command, run, patience, lock, requests).follow(watch)


def _prepare(
    run: Path, ranks: int, until: float | None, fresh: bool, resume: bool, deadline: float, say: Say
) -> list[str] | None:
    """Make the folder ready and return the command of the job; None if there is nothing left to do."""
    prepare_compiled()
    case = _read_run(run, fresh, resume)
    if resume and is_complete(run, case):
        say(f"{run}: is complete: nothing is left to do")
        return None
    checkpoint = _find_checkpoint(run, case, say) if resume else None
    if checkpoint and until is not None and checkpoint.time >= until * _ALMOST:
        say(f"{run}: has reached t = {checkpoint.time:.6g} s already: nothing is left to do up to {until:g} s")
        return None
    _clear(run, checkpoint)
    prepare_failure(run)
    if case.gas and checkpoint:
        resume_mesh(case, run, ranks, checkpoint)
    elif case.gas:
        prepare_mesh(case, run, ranks)
    options = ["--ranks", str(ranks), "--deadline", repr(deadline)]
    if until is not None:
        options += ["--until", repr(until)]
    if checkpoint:
        options += ["--resume", str(checkpoint.folder.relative_to(run))]
    command = mpi_command(ranks, [sys.executable, "-m", "fbcouple.worker", str(run.resolve()), *options])
    _note_run(run, ranks, command)
    return command


def _read_run(run: Path, fresh: bool, resume: bool) -> Case:
    if not fresh and not resume:
        for trace in ("results.nc", *(str(p.relative_to(run)) for p in fbcouple.checkpoint.list_checkpoints(run))):
            if (run / trace).exists():
                raise CaseError(
                    [f"{run}: holds results ({trace}); --resume goes on, --fresh starts again and removes them"]
                )
    return load_case(str(run / "case.toml"))


def is_complete(run: Path, case: Case) -> bool:
    """Did an earlier run reach the end of the case as it is now, by its results?"""
    if not (run / "results.nc").exists():
        return False
    with xr.open_dataset(run / "results.nc") as results:
        return bool(results.attrs["complete"]) and float(results["time"][-1]) >= case.end_time * _ALMOST


def _find_checkpoint(run: Path, case: Case, say: Say) -> Checkpoint | None:
    checkpoint, refusals = fbcouple.checkpoint.choose(run, case)
    for line in refusals:
        say(line)
    say(
        f"{run}: resumes at t = {checkpoint.time:.6g} s from {checkpoint.folder.name}"
        if checkpoint
        else f"{run}: has no checkpoint yet: starts at t = 0"
    )
    return checkpoint


def _clear(run: Path, checkpoint: Checkpoint | None) -> None:
    """Remove what an earlier run left; of one that is resumed only what came after the checkpoint."""
    log = run / _LOG
    for old in (log, run / PULSE, *(run / "logs" / name for name in SOLVER_LOGS)):
        old.unlink(missing_ok=True)
    if checkpoint:
        shutil.copyfile(checkpoint.folder / "history.jsonl", log)
        return
    for name in _PRODUCTS:
        _remove(run / name)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _note_run(run: Path, ranks: int, command: list[str]) -> None:
    manifest = json.loads((run / "manifest.json").read_text(encoding="utf-8"))
    manifest["run"] = {
        "ranks": ranks,
        "host": platform.node(),
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "command": command,
        "started": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
    }
    fresh = run / "manifest.tmp"
    fresh.write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
    fresh.replace(run / "manifest.json")
