"""Job scripts for a run, or for a folder of runs as an array job: as long as it takes, in pieces that fit the limit."""

from __future__ import annotations

import math
import re
import shlex
import sys
from dataclasses import dataclass, field
from pathlib import Path

from fbcouple.batch.folders import find_runs
from fbcouple.batch.placement import Placement, describe_placement, list_placement_problems
from fbcouple.batch.schedulers import SCHEDULERS, Scheduler
from fbcouple.case.bed.particle_types import particle_count
from fbcouple.case.bed.region import find_region
from fbcouple.case.cost.memory import FACTOR, find_job_memory
from fbcouple.case.cost.ranks import count_worked
from fbcouple.case.load import load_case
from fbcouple.case.problems import naming, show
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import require_trust
from fbcouple.decks.render import make_environment
from fbcouple.errors import BusyError, CaseError
from fbcouple.machine.environment import find_package
from fbcouple.machine.whole_files import replacing
from fbcouple.run_folder.lock import STALE_AFTER
from fbcouple.run_folder.plain_files import require_plain

_SHORTEST = 60
_SLOW_CLOCKS = 30.0
"""Wall time [s] beyond that after which a lock counts as left by the dead: clocks of nodes and of their file system."""
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._/+:=@-]{0,99}")
_PATH = re.compile(r"/[A-Za-z0-9._/+:=@,-]{1,3000}")


@dataclass(frozen=True)
class Request:
    """What a job asks for: ranks, wall-time limit and notice before it [s], memory [MiB], modules, queue, account.

    `memory` None: estimated from the case. `chain`: jobs that are handed in one after the other; None: one job that
    requeues itself until the run is done. `trusted`: the job may run the code that the case brings. `placement`: nodes
    and what is the site's.
    """

    ranks: int
    limit: int
    notice: int = 300
    memory: int | None = None
    modules: tuple[str, ...] = ()
    queue: str | None = None
    account: str | None = None
    chain: int | None = None
    trusted: bool = False
    placement: Placement = field(default_factory=Placement)


def write_job(target: Path, scheduler: str, request: Request) -> tuple[Path, Path]:
    """Write TARGET/batch/SCHEDULER.sh, the job script, and submit-SCHEDULER.sh, which hands it in.

    Raises: CaseError if `request` cannot be met or a name or path could be taken for something else than a name.
    """
    runs, system = find_runs(target), SCHEDULERS[scheduler]
    _require_sound(target.resolve(), runs, system, scheduler, request)
    folder = target.resolve() / "batch"
    for read in (*runs, folder):
        require_plain(read)
    job, submit = folder / f"{scheduler}.sh", folder / f"submit-{scheduler}.sh"
    cases = [load_case(str(run)) for run in runs]
    for run, case in zip(runs, cases, strict=True):
        with naming(str(run)):
            require_trust(case, request.trusted)
    needed = (request_memory(case, run, request.ranks) for case, run in zip(cases, runs, strict=True))
    memory = request.memory or max(needed)
    limit = "" if system.warns else f" --wall-limit {request.limit - request.notice}"
    minutes = request.limit // 60
    first, then = system.submit(shlex.quote(str(job)))
    context = {
        "name": re.sub(r"[^A-Za-z0-9._-]", "-", target.resolve().name)[:60],
        "runs": [str(run) for run in runs],
        "folder": str(folder),
        "index": system.index if len(runs) > 1 else "0",
        "ranks": request.ranks,
        "memory": memory,
        "memory_per_rank": math.ceil(memory / request.ranks),
        "clock_limit": f"{minutes // 60:02d}:{minutes % 60:02d}:{request.limit % 60:02d}",
        "minutes_limit": minutes,
        "notice": request.notice,
        "minutes_notice": math.ceil(request.notice / 60),
        "options": limit + (" --trust" if request.trusted else ""),
        "requeues": request.chain is None,
        "modules": request.modules,
        "queue": request.queue,
        "account": request.account,
        "python": sys.executable,
        "package": ":".join(find_package()),
        "jobs": request.chain or 1,
        "first": first,
        "next": then,
        "submit": str(submit),
        "busy": BusyError.exit_code,
        "patience": math.ceil(STALE_AFTER + _SLOW_CLOCKS),
        **describe_placement(request.placement, request.ranks, memory, system),
    }
    environment = make_environment()
    environment.filters["shell"] = shlex.quote
    folder.mkdir(exist_ok=True)
    for path, template in ((job, f"batch/{scheduler}.sh"), (submit, "batch/submit.sh")):
        with replacing(path) as fresh:
            fresh.write_text(environment.get_template(template).render(context), encoding="utf-8")
            fresh.chmod(0o755)
    return job, submit


def request_memory(case: Case, folder: Path, ranks: int) -> int:
    """Memory [MiB] to ask for all `ranks` of `case`, whose own files lie in `folder`: what is predicted, times the
    factor that this is within; by what is shipped, for a job may run on another machine."""
    return math.ceil(FACTOR * find_job_memory(case, folder, ranks) / 2**20)


def list_warnings(folder: Path, request: Request) -> list[str]:
    """What in `folder` no job is for, and what of `request` is of little use: more ranks than there is work for, less
    memory than is predicted."""
    warnings: list[str] = []
    runs = find_runs(folder, warnings.append)
    for run in runs if request.ranks > 1 or request.memory else []:
        case = load_case(str(run))
        if request.memory and request.memory < (needed := request_memory(case, run, request.ranks)):
            text = f"--memory: {request.memory} MiB are given for all ranks, and without it {needed} are asked for"
            warnings.append(f"{run}: {text}; a job that needs more than it asks for is ended.")
        cells = find_region(case, run).cells if case.gas else 0
        particles = particle_count(case.particles) if case.particles else 0
        useful = count_worked(cells, particles)
        if request.ranks > useful:
            work = f"{cells} cells and {particles} particles on {request.ranks} ranks"
            share = f"{cells // request.ranks} and {particles // request.ranks} a rank"
            warnings.append(f"{run}: {work} ({share}): more than about {useful} ranks make it no faster.")
    return warnings


def _require_sound(folder: Path, runs: list[Path], system: Scheduler, scheduler: str, request: Request) -> None:
    problems = []
    for option, given in _list_names(request):
        if not _NAME.fullmatch(given):
            allowed = "letters, digits and . _ / + : = @ - are allowed"
            problems.append(f"{option}: {show(given)} is given, {allowed}; give the bare name.")
    for path in (folder, *runs):
        if not _PATH.fullmatch(str(path)):
            text = "has characters in its path that a batch script takes for something else"
            problems.append(f"{show(str(path))}: {text}; move it to a path of letters, digits and . _ / + : = @ , -.")
    if request.limit < _SHORTEST:
        problems.append(f"--time: {request.limit} s is given, at least a minute is allowed; give hours.")
    elif request.notice >= request.limit:
        text = f"{request.notice} s is given and the limit is {request.limit} s"
        problems.append(f"--notice: {text}; give less, but enough to write a checkpoint.")
    if request.chain is None and not system.requeues:
        text = f"a {scheduler} job cannot start itself again"
        problems.append(f"--chain: {text}; say how many jobs of this length the run may take.")
    problems += list_placement_problems(request.placement, request.ranks, system, scheduler)
    if problems:
        raise CaseError(problems)


def _list_names(request: Request) -> list[tuple[str, str]]:
    named = [("--module", module) for module in request.modules]
    named += [("--queue", request.queue)] if request.queue is not None else []
    return named + ([("--account", request.account)] if request.account is not None else [])
