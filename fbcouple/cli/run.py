"""`fbcouple run`: a run folder to its end, or the run folders of a set side by side."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

import math
import re
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import click
from rich.console import Console

from fbcouple.cli.arguments import take_ranks, take_trust
from fbcouple.errors import CaseError
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.output import outlive_output
from fbcouple.paths import require_usable
from fbcouple.run_folder.plain_files import require_plain

if TYPE_CHECKING:
    from fbcouple.launcher.progress import RunProgress


def require_finite(ctx: click.Context, parameter: click.Parameter, value: float | None) -> float | None:
    """Refuse nan and infinity, which click takes for numbers."""
    if value is not None and not math.isfinite(value):
        raise click.BadParameter("give a finite number of seconds")
    return value


def read_duration(ctx: click.Context, parameter: click.Parameter, value: str | None) -> float:
    """Read seconds or hours:minutes:seconds; no value is no limit."""
    if value is None:
        return math.inf
    words = re.fullmatch(r"(\d+):([0-5]\d):([0-5]\d)|(\d+(?:\.\d*)?)", value)
    if not words:
        raise click.BadParameter(f"{value!r}: give seconds, as 5400, or hours, minutes and seconds, as 1:30:00")
    hours, minutes, seconds, plain = words.groups()
    return float(plain) if plain else int(hours) * 3600.0 + int(minutes) * 60.0 + int(seconds)


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@take_ranks
@click.option(
    "-j", "--jobs", type=click.IntRange(min=1), help="Of a folder of runs: how many side by side; one by default."
)
@click.option(
    "--replicas",
    "count",
    type=click.IntRange(min=2),
    metavar="N",
    help="Run N replicas of the case, with different seeds: RUN becomes a folder of N run folders, and what lies in it "
    "the first of them. `fbcouple pool` and `report` take their means together.",
)
@click.option(
    "--until",
    type=click.FloatRange(min=0.0, min_open=True),
    callback=require_finite,
    help="Stop at the first possible checkpoint at or after this simulated time [s].",
)
@click.option("--resume", is_flag=True, help="Continue from the newest good checkpoint; without one, from the start.")
@click.option("--fresh", is_flag=True, help="Start again from zero and remove the results of the earlier run.")
@click.option(
    "--wall-limit",
    callback=read_duration,
    metavar="SECONDS|H:MM:SS",
    help="Stop with a checkpoint before this wall time is used up.",
)
@click.option(
    "--patience",
    type=click.FloatRange(min=1.0),
    callback=require_finite,
    default=600.0,
    show_default=True,
    help="Wall time [s] without a coupling step, at its start without a compiled loop or a log either, after which the "
    "run counts as hanging and is ended.",
)
@click.option(
    "--accept-update", is_flag=True, help="Resume also a run that another version of fbcouple or of a solver began."
)
@click.option(
    "--set",
    "sets",
    multiple=True,
    metavar="KEY=VALUE",
    help="With --resume: another value from the checkpoint on, as gas.inlet_velocity=1.2 or end_time=4; may be given "
    "several times. Another inlet is noted in the results.",
)
@take_trust
@outlive_output
def run(
    run: Path, ranks: int, jobs: int | None, count: int | None, resume: bool, fresh: bool, trusted: bool, **limits: Any
) -> None:
    """Run the simulation in the folder RUN; exit code 75 if it stopped early and can continue with --resume.

    Of a folder of runs, as `setup` writes a set of cases, all that are not complete, the longest first; the same
    command goes on where they stopped.
    """
    from fbcouple.batch.folders import is_set

    require_plain(run)
    if resume and fresh:
        raise click.UsageError("--resume continues, --fresh starts again: give one of them")
    if count is not None:
        from fbcouple.decks.replicas import make_replicas

        refuse_of_one_run(run, limits)
        make_replicas(run, count, click.echo)
    if is_set(run):
        run_many(run, ranks, jobs or 1, fresh, trusted, limits)
        return
    require_run(run)
    if jobs is not None:
        raise click.UsageError("-j runs several of a folder of runs side by side: this is one run; leave it out")
    if limits["sets"] and not resume:
        raise click.UsageError("--set changes a run from its checkpoint on: give --resume with it")
    with Requests() as requests:  # from here to the last word, a signal is a request to stop
        run_on(run, ranks, resume, fresh, trusted, requests, limits)
        if requests.first:
            late = "came too late to stop the run: no moment for a checkpoint was left before its end"
            click.echo(f"{run}: {requests.first} {late}")


def run_many(folder: Path, ranks: int, jobs: int, fresh: bool, trusted: bool, limits: dict[str, Any]) -> None:
    """Run the run folders in `folder`, each as `fbcouple run` does it."""
    from fbcouple.cli.run_set import run_set

    refuse_of_one_run(folder, limits)
    options = ["--fresh" if fresh else "--resume", "--patience", repr(limits["patience"])]
    options += ["--trust"] if trusted else []
    options += ["--accept-update"] if limits["accept_update"] else []
    with Requests() as requests:
        run_set(folder, jobs, ranks, options, requests, limits["wall_limit"])


def refuse_of_one_run(folder: Path, limits: dict[str, Any]) -> None:
    """Raise UsageError for options that a folder of runs does not take."""
    for name in ("until", "sets"):
        if limits[name]:
            option = "--set" if name == "sets" else f"--{name}"
            raise click.UsageError(f"{option} is of one run, and {folder} is a folder of runs: leave it out")


def run_on(
    run: Path, ranks: int, resume: bool, fresh: bool, trusted: bool, requests: Requests, limits: dict[str, Any]
) -> None:
    """Run what lies in `run` as far as it is asked to, with a display of its progress."""
    from fbcouple.case.load import load_case
    from fbcouple.case.user_code import require_trust
    from fbcouple.decks.unchanged import require_unchanged
    from fbcouple.errors import StoppedError
    from fbcouple.launcher.change_case import ask, changes_inlet
    from fbcouple.launcher.launch import launch
    from fbcouple.launcher.progress import RunProgress
    from fbcouple.launcher.resume import is_complete

    case, sets = load_case(str(run)), limits["sets"]
    require_trust(case, trusted)
    require_unchanged(case, run, trusted, changes_inlet(sets))
    if sets:
        case = ask(case, sets, run)
    end, was_complete = min(case.end_time, limits["until"] or case.end_time), not fresh and is_complete(run, case)
    console = Console()
    go_on = f"`fbcouple run {quote(str(run))} -n {ranks} --resume{' --trust' if trusted else ''}`"
    try:
        with RunProgress(console, end) as progress:
            options: dict[str, Any] = {
                "fresh": fresh,
                "resume": resume,
                "requests": requests,
                "begin": progress.start,
            } | limits
            launch(run, ranks, watch=progress.show, say=click.echo, trusted=trusted, **options)
    except StoppedError as error:
        raise StoppedError(f"{run}: {error}; go on with {go_on}") from error
    if costs := progress.tabulate():
        console.print(costs)
    if line := compare_prediction(run, progress):
        click.echo(f"{run}: {line}")
    for warning in progress.list_warnings():
        click.echo(f"{run}: warning: {warning}")
    if not is_complete(run, case):
        stopped_at = f"at or after {end:g} s of {case.end_time:g} s"
        click.echo(f"{run}: stopped at a moment for a checkpoint {stopped_at}; go on with {go_on}")
        return
    if end < case.end_time and not was_complete:
        text = f"no moment for a checkpoint came from --until {end:g} s to the end of the run"
        click.echo(f"{run}: {text}; checkpoint.moment_steps says after how many steps one comes")
    click.echo(f"{run}: done{progress.format_begin()}; draw its figures with `fbcouple post {quote(str(run))}`")


def compare_prediction(run: Path, progress: RunProgress) -> str:
    """What `run` was predicted to take beside what it took; empty where no step was taken or nothing was predicted."""
    from fbcouple.cli.prediction import format_outcome
    from fbcouple.run_folder.manifest import read_manifest

    predicted = read_manifest(run).get("run", {}).get("predicted")
    seconds, walls = progress.sum_up()
    return format_outcome(predicted, seconds, walls) if predicted and seconds > 0.0 else ""


def require_run(run: Path) -> None:
    """Raise CaseError unless `run` is a folder that `setup` wrote."""
    if not (run / "case.toml").is_file():
        raise CaseError(
            [f"{run}: is not a run folder (no case.toml); write one with `fbcouple setup CASE -o {quote(str(run))}`."]
        )
    require_usable(run)
