"""The parent process of a run: prepares the folder and the mesh, starts the MPI job and says how it ended."""

from __future__ import annotations

import math
import platform
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import fbcouple.run_folder.checkpoint
from fbcouple.case.cost.prediction import predict_run
from fbcouple.case.load import load_case
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import require_trust
from fbcouple.decks.abilities import require_able, tell_able
from fbcouple.decks.unchanged import require_own_decks, require_unchanged
from fbcouple.errors import CaseError, SolverError, StoppedError
from fbcouple.launcher.change_case import ask, change_case, changes_inlet
from fbcouple.launcher.job import Job, Watch
from fbcouple.launcher.openfoam_mesh import Guard, prepare_mesh, resume_mesh
from fbcouple.launcher.resume import Choice, Say, Start, choose_start
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.cache import prepare_compiled
from fbcouple.machine.launchers import mpi_command, tell_crowd
from fbcouple.machine.own_key import make_key
from fbcouple.paths import HEARTBEAT, LOG
from fbcouple.run_folder.checkpoint import Checkpoint
from fbcouple.run_folder.failure import SOLVER_LOGS, give_room_back, prepare_failure
from fbcouple.run_folder.lock import hold
from fbcouple.run_folder.manifest import read_manifest, write_manifest
from fbcouple.run_folder.plain_files import require_plain
from fbcouple.run_folder.products import remove_products
from fbcouple.solvers.versions import list_versions

PATIENCE = 600.0


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
    trusted: bool = False,
    accept_update: bool = False,
    sets: Sequence[str] = (),
    requests: Requests | None = None,
    begin: Callable[[], None] = lambda: None,
) -> None:
    """Run the case in `run` on `ranks` MPI ranks to its end; `watch` sees each history row.

    until [s]: stop, with a checkpoint, at the first moment for one at or after it; resume: from the newest checkpoint
    that is whole; wall_limit [s]: wall time by which it has to be over; patience [s]: wall time without a coupling step
    after which it is taken for hanging, and before the first one without a loop compiled or a log written either;
    say: told what is refused, and of more ranks than cores; trusted: also with decks and files that were changed
    since set-up, or from another's checkpoint; accept_update: resume also what another version of fbcouple or of a
    solver began; sets: key=value that are another from the checkpoint on (see `change_case`); requests: to stop, by
    default the signals that come while it is under way; begin: called once nothing refuses the run any more and there
    is something to do.

    Raises CaseError if `run` is no run folder, was changed, holds what neither `fresh` nor `resume` speaks of, or has
    only damaged checkpoints; SolverError with the solver's own last words; DivergedError if a check of the run failed;
    StoppedError if it stopped early with a checkpoint.
    """
    deadline = time.monotonic() + wall_limit
    require_plain(run)
    read_manifest(run)
    with hold(run, say) as lock, nullcontext(requests) if requests else Requests() as asked:
        choice = Choice(fresh, resume, until, trusted, accept_update, say, begin, tuple(sets))
        start = make_ready(run, ranks, choice, Guard(lock, asked))
        if start is None:
            return
        command = _format_job(run, ranks, until, deadline, start.checkpoint)
        note_run(run, ranks, command, start, say)
        Job(command, run, patience, lock, asked, say).follow(watch)


def make_ready(run: Path, ranks: int, choice: Choice, guard: Guard) -> Start | None:
    """Check the run folder, choose the checkpoint to go on from, and make mesh and fields for `ranks` ranks.

    Returns: what the run starts with; None if nothing is left to do. Raises: as `launch`.
    """
    try:
        start = _make_ready(run, ranks, choice, guard)
        if start and guard.requests.first:
            raise StoppedError(f"stopped by {guard.requests.first} before the first step")
    except OSError as error:
        raise SolverError(f"{run}: cannot be made ready: {error}") from error
    except StoppedError:
        give_room_back(run)
        raise
    return start


def _make_ready(run: Path, ranks: int, choice: Choice, guard: Guard) -> Start | None:
    case = _read_run(run, choice.fresh, choice.resume)
    require_trust(case, choice.trusted)
    changed = require_unchanged(case, run, choice.trusted, changes_inlet(choice.sets))
    asked = case
    if choice.sets:
        asked = ask(case, choice.sets, run)
        case = asked.model_copy(update={"gas": case.gas})
    start = choose_start(run, case, choice) if choice.resume else Start(list_versions(case))
    if start is None:
        return None
    if choice.sets:
        case = change_case(run, case, asked, start.checkpoint)
    able = require_able(case, start.versions.get("LIGGGHTS", ""), choice.say)
    if crowd := tell_crowd(ranks):
        choice.say(f"{run}: warning: {crowd}")
    choice.begin()
    _prepare(run, case, ranks, start.checkpoint, guard)
    if not choice.trusted:
        require_own_decks(case, run)
    return replace(start, changed=tuple(changed), liggghts=able)


def _prepare(run: Path, case: Case, ranks: int, checkpoint: Checkpoint | None, guard: Guard) -> None:
    """Make the folder ready: what earlier runs left is gone, and mesh and fields are there."""
    prepare_compiled()
    make_key()
    _clear(run, checkpoint)
    prepare_failure(run)
    if case.gas and checkpoint:
        resume_mesh(case, run, ranks, checkpoint, guard)
    elif case.gas:
        prepare_mesh(case, run, ranks, guard)


def _format_job(
    run: Path, ranks: int, until: float | None, deadline: float, checkpoint: Checkpoint | None
) -> list[str]:
    options = ["--ranks", str(ranks), "--deadline", repr(deadline)]
    if until is not None:
        options += ["--until", repr(until)]
    if checkpoint:
        options += ["--resume", checkpoint.folder.name]
    return mpi_command(ranks, [sys.executable, "-m", "fbcouple.simulation.worker", str(run.resolve()), *options])


def _read_run(run: Path, fresh: bool, resume: bool) -> Case:
    traces = [run / "results.nc", *fbcouple.run_folder.checkpoint.list_checkpoints(run)]
    if not fresh and not resume and any(trace.exists() for trace in traces):
        found = next(trace for trace in traces if trace.exists()).relative_to(run)
        raise CaseError([f"{run}: holds results ({found}); --resume goes on, --fresh starts again and removes them"])
    return load_case(str(run / "case.toml"))


def _clear(run: Path, checkpoint: Checkpoint | None) -> None:
    """Remove what an earlier run left; of one that is resumed only what came after the checkpoint."""
    log = run / LOG
    log.parent.mkdir(exist_ok=True)
    for old in (log, run / HEARTBEAT, *(run / "logs" / name for name in SOLVER_LOGS)):
        old.unlink(missing_ok=True)
    if checkpoint:
        shutil.copyfile(checkpoint.folder / "history.jsonl", log)
    else:
        remove_products(run)


def note_run(run: Path, ranks: int, command: list[str], start: Start, say: Say = lambda text: None) -> None:
    """Write into the manifest how the run was started, with what, and what it was predicted to cost; `say` is told
    where it cannot be predicted. Raises: SolverError if the manifest cannot be written."""
    about = {
        "ranks": ranks,
        "host": platform.node(),
        "command": command,
        "started": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        "changed": list(start.changed),
        "updates": list(start.updates),
        "predicted": predict_run(run, ranks, say),
        "liggghts": tell_able(start.liggghts),
    }
    try:
        write_manifest(run, read_manifest(run) | {"run": about, "run_with": start.versions})
    except OSError as error:
        raise SolverError(f"{run}: cannot be made ready: {error}") from error
