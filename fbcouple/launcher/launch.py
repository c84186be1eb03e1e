"""The parent process of a run: prepares the folder and the mesh, starts the MPI job and says how it ended."""

from __future__ import annotations

import math
import platform
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path

import xarray as xr

import fbcouple.run_folder.checkpoint
from fbcouple.case.bed.derived import dem_step
from fbcouple.case.cost.prediction import predict_run
from fbcouple.case.load import load_case
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import require_trust
from fbcouple.decks.abilities import Answers, require_able, tell_able
from fbcouple.decks.unchanged import require_own_decks, require_unchanged
from fbcouple.errors import CaseError, SolverError, StoppedError
from fbcouple.launcher.change_case import ask, change_case, changes_inlet
from fbcouple.launcher.job import Job, Watch
from fbcouple.launcher.openfoam_mesh import Guard, prepare_mesh, resume_mesh
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.cache import prepare_compiled
from fbcouple.machine.launchers import mpi_command, tell_crowd
from fbcouple.machine.own_key import key_file, make_key
from fbcouple.paths import HEARTBEAT, LOG
from fbcouple.run_folder.checkpoint import Checkpoint
from fbcouple.run_folder.failure import SOLVER_LOGS, give_room_back, prepare_failure
from fbcouple.run_folder.lock import hold
from fbcouple.run_folder.manifest import read_manifest, write_manifest
from fbcouple.run_folder.plain_files import format_path, require_plain
from fbcouple.run_folder.products import remove_products
from fbcouple.run_folder.provenance import Versions, list_makers
from fbcouple.solvers.versions import list_versions

PATIENCE = 600.0
_ALMOST = 1 - 1e-9

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


@dataclass(frozen=True)
class Start:
    """What a run starts with: versions, the checkpoint that it goes on from, and the updates since its start."""

    versions: Versions
    checkpoint: Checkpoint | None = None
    updates: tuple[str, ...] = ()
    changed: tuple[str, ...] = ()
    """Decks and files that were changed since set-up, and trusted."""
    liggghts: Answers = field(default_factory=dict)
    """What LIGGGHTS can do, and what it cannot."""


@dataclass(frozen=True)
class Choice:
    """How a run is started, as `launch` says of each."""

    fresh: bool = False
    resume: bool = False
    until: float | None = None
    trusted: bool = False
    accept_update: bool = False
    say: Say = lambda text: None
    begin: Callable[[], None] = lambda: None
    """Called when it is sure that there is something to do."""
    sets: tuple[str, ...] = ()


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
    start = _choose(run, case, choice) if choice.resume else Start(list_versions(case))
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


def is_complete(run: Path, case: Case, say: Say = lambda text: None) -> bool:
    """Did an earlier run reach the end of the case as it is now, by its results? Not by results that cannot be read,
    which `say` is told."""
    complete, damage = look_at_results(run, case)
    if damage:
        say(f"{run / 'results.nc'}: {damage}; it is written anew")
    return complete


def look_at_results(run: Path, case: Case) -> tuple[bool, str]:
    """The same, and why results.nc cannot be read; "" where it can, or there is none."""
    path = run / "results.nc"
    if not path.exists():
        return False, ""
    try:
        with xr.open_dataset(path, decode_times=False) as results:
            is_sure = results.attrs.get("ended_by") == "until_error"
            at_end = is_sure or float(results["time"][-1]) >= case.end_time * _ALMOST
            return bool(results.attrs["complete"]) and at_end, ""
    except (OSError, ValueError, LookupError, TypeError, RuntimeError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
        return False, f"cannot be read ({reason})"


def _choose(run: Path, case: Case, choice: Choice) -> Start | None:
    """Where a run that is resumed goes on; None if there is nothing left to do."""
    say, until = choice.say, choice.until
    if is_complete(run, case, say):
        say(f"{run}: is complete: nothing is left to do")
        return None
    for stray in fbcouple.run_folder.checkpoint.list_strays(run):
        say(f"{format_path(stray)}: is no checkpoint and is left alone")
    checkpoint = _find_checkpoint(run, case, say)
    if checkpoint and checkpoint.time * _ALMOST > case.end_time + _find_dem_step(case):
        text = f"end_time: {case.end_time:g} s is given, and the run has come to t = {checkpoint.time:.6g} s"
        raise CaseError([f"{run}: {text}, its newest checkpoint; give a later one, or set up another run with it."])
    if checkpoint and until is not None and checkpoint.time >= until * _ALMOST:
        say(f"{run}: has reached t = {checkpoint.time:.6g} s already: nothing is left to do up to {until:g} s")
        return None
    versions = list_versions(case)
    if checkpoint is None:
        return Start(versions)
    updates = _list_updates(checkpoint, versions, choice.accept_update)
    if other := _note_moments(checkpoint, case):
        say(f"{run}: warning: {other}")
        updates = (*updates, other)
    if not checkpoint.index.own:
        updates = (*updates, _note_foreign(checkpoint, choice.trusted))
    return Start(versions, checkpoint, updates)


def _note_moments(checkpoint: Checkpoint, case: Case) -> str:
    """A line on moments for a checkpoint that are others than before, where the particles' solver is set up anew; "" if
    they are not."""
    before, now = checkpoint.index.moment_steps, case.checkpoint.moment_steps
    if before in (None, now):
        return ""
    text = f"checkpoint.moment_steps was {before} and is {now} now, equal to an uninterrupted run up to rounding"
    return f"from t = {checkpoint.time:.6g} s on: {text}"


def _note_foreign(checkpoint: Checkpoint, trusted: bool) -> str:
    """A line on a checkpoint that another wrote. Raises: CaseError if it is not trusted."""
    if not trusted:
        text = "its liggghts.restart is read by LIGGGHTS without a check; if you trust whoever made it say --trust"
        raise CaseError(
            [f"{format_path(checkpoint.folder)}: was not written by you, or not with the key in {key_file()}: {text}."]
        )
    return f"from t = {checkpoint.time:.6g} s on: a checkpoint of another user or machine"


def _find_dem_step(case: Case) -> float:
    """The DEM step [s], by less than which the end of a run is beyond its end_time; 0 without particles."""
    return dem_step(case.contact, case.particles) if case.contact and case.particles else 0.0


def _find_checkpoint(run: Path, case: Case, say: Say) -> Checkpoint | None:
    checkpoint, refusals = fbcouple.run_folder.checkpoint.choose(run, case)
    for line in refusals:
        say(line)
    say(
        f"{run}: resumes at t = {checkpoint.time:.6g} s from {checkpoint.folder.name}"
        if checkpoint
        else f"{run}: has no checkpoint yet: starts at t = 0"
    )
    return checkpoint


def _list_updates(checkpoint: Checkpoint, versions: Versions, accepted: bool) -> tuple[str, ...]:
    """With what else than before the run has gone on since its start, a line each time.

    Raises: CaseError if what wrote the checkpoint is not what is here, unless that is `accepted`.
    """
    before, now = checkpoint.index.made_by, list_makers(versions)
    changed = [name for name in sorted({*before, *now}) if before.get(name) != now.get(name)]
    if not changed:
        return tuple(checkpoint.index.updates)
    told = "; ".join(f"{name}: {before.get(name, 'none')} then, {now.get(name, 'none')} now" for name in changed)
    if not accepted:
        text = "the run would be of two programs; --accept-update goes on with it and notes it in results.nc"
        raise CaseError([f"{checkpoint.folder}: was written with other versions ({told}): {text}."])
    return (*checkpoint.index.updates, f"from t = {checkpoint.time:.6g} s on: {told}")


def _clear(run: Path, checkpoint: Checkpoint | None) -> None:
    """Remove what an earlier run left; of one that is resumed only what came after the checkpoint."""
    log = run / LOG
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
