"""The command line: the only place that prints and chooses exit codes.

Exit codes: 0 done; 1 the case or the input is wrong; 2 usage; 3 a solver or the machine failed; 4 the simulation
diverged or broke a conservation check; 75 stopped early, `--resume` goes on; 130 interrupted; 141 the reader of the
output went away. Heavy modules load inside commands.
"""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

import io
import math
import re
import sys
from pathlib import Path
from shlex import quote
from tempfile import TemporaryDirectory
from typing import Any

import click
from rich.console import Console
from rich.text import Text

from fbcouple.batch.schedulers import SCHEDULERS
from fbcouple.cli.arguments import take_case, take_case_or_set, take_ranks, take_settings, take_trust
from fbcouple.cli.bench import bench
from fbcouple.cli.doctor import doctor
from fbcouple.cli.group import Commands, finish
from fbcouple.cli.init import init
from fbcouple.cli.options import options
from fbcouple.cli.pictures import claims, post, report
from fbcouple.cli.study import study
from fbcouple.cli.table import print_explained, print_table
from fbcouple.cli.validate import validate
from fbcouple.cli.verify import verify
from fbcouple.errors import CaseError
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.output import open_standard_streams, outlive_output
from fbcouple.paths import require_usable
from fbcouple.run_folder.plain_files import require_plain

PROGRESS_EVERY = 5.0
"""Wall time [s] between lines of progress."""
COLOURS = {"fit": "green", "warn": "yellow", "unfit": "bold red"}


def require_finite(ctx: click.Context, parameter: click.Parameter, value: float | None) -> float | None:
    """Refuse nan and infinity, which click takes for numbers."""
    if value is not None and not math.isfinite(value):
        raise click.BadParameter("give a finite number of seconds")
    return value


def read_clock(ctx: click.Context, parameter: click.Parameter, value: str) -> int:
    """Seconds of a time given as HH:MM:SS."""
    parts = value.split(":")
    if len(parts) != 3 or not all(part.isascii() and part.isdigit() and len(part) <= 4 for part in parts):
        raise click.BadParameter("write it as HH:MM:SS")
    hours, minutes, seconds = map(int, parts)
    if minutes > 59 or seconds > 59 or hours + minutes + seconds == 0:
        raise click.BadParameter("minutes and seconds go to 59, and the limit is above 0")
    return 3600 * hours + 60 * minutes + seconds


def read_duration(ctx: click.Context, parameter: click.Parameter, value: str | None) -> float:
    """Read seconds or hours:minutes:seconds; no value is no limit."""
    if value is None:
        return math.inf
    words = re.fullmatch(r"(\d+):([0-5]\d):([0-5]\d)|(\d+(?:\.\d*)?)", value)
    if not words:
        raise click.BadParameter(f"{value!r}: give seconds, as 5400, or hours, minutes and seconds, as 1:30:00")
    hours, minutes, seconds, plain = words.groups()
    return float(plain) if plain else int(hours) * 3600.0 + int(minutes) * 60.0 + int(seconds)


def print_version(ctx: click.Context, parameter: click.Parameter, is_asked: bool) -> None:
    """Print the version, in a checkout with its commit, and end."""
    if is_asked and not ctx.resilient_parsing:
        from fbcouple.solvers.versions import format_own_version

        click.echo(f"fbcouple, version {format_own_version()}")
        ctx.exit()


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=print_version,
    help="Show the version, with the commit in a checkout, and exit.",
)
def cli() -> None:
    """CFD-DEM of fluidized beds: OpenFOAM and LIGGGHTS from one case file to figures."""


@cli.command()
def cases() -> None:
    """List the shipped cases, and the sets of cases, which `setup` takes in place of a case."""
    from fbcouple.case.base import read_case
    from fbcouple.case.source import list_sets, list_shipped

    # Not by load_case: a shipped case may be too large for this machine.
    rows = [(name, str(read_case(path, name)[0]["title"])) for name, path in list_shipped().items()]
    sets = [(name, f"{len(members)} cases: {', '.join(members)}") for name, members in list_sets().items()]
    print_table(["case", "title"], [*rows, *sets])


@cli.command()
@take_case
@take_settings
@take_trust
def check(case: str, sets: tuple[str, ...], trusted: bool) -> None:
    """Report every mistake in CASE at once and the pre-flight numbers; start no solver.

    Exit code 1 if there is a mistake, or a number is unfit.
    """
    from fbcouple.case.load import load_case
    from fbcouple.case.preflight import estimate
    from fbcouple.case.source import find_case

    folder = find_case(case).parent
    loaded = load_case(case, sets, click.echo)
    brings_code = loaded.exchange is not None and loaded.exchange.drag_file is not None
    law = None
    if brings_code and trusted:
        from fbcouple.decks.set_up import read_own_law

        law = read_own_law(loaded, folder)
    with TemporaryDirectory(prefix="fbcouple-start-") as scratch:
        if loaded.start is not None and loaded.start.is_made:
            from fbcouple.decks.starts import make_start

            loaded = make_start(loaded, folder, Path(scratch), click.echo, pours=False)
        numbers = estimate(loaded, law, folder)
    rows = [
        (
            number.name,
            number.format_value(),
            "" if number.unit == "1" else number.unit,
            number.limit or "",
            Text(number.verdict or "", style=COLOURS.get(number.verdict or "", "")),
            number.meaning,
        )
        for number in numbers
    ]
    print_explained(["number", "value", "unit", "wanted", "verdict", "meaning"], rows)
    if unfit := [number for number in numbers if number.verdict == "unfit"]:
        mend = "fix the case; `setup` refuses it without --force."
        raise CaseError(
            [f"{case}: {number.name}: {number.format()}, {number.limit} is fit; {mend}" for number in unfit]
        )
    if brings_code and not trusted:
        click.echo("exchange.drag_file is not run: no numbers of the drag; --trust runs it")


@cli.command()
@take_case_or_set
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Run folder; by default runs/<name of the case>.")
@take_settings
@click.option("--explain", "explained", is_flag=True, help="List what is in the decks, what is left out, and why.")
@click.option("--force", "forced", is_flag=True, help="Also if a pre-flight number of `check` is unfit.")
@take_trust
def setup(case: str, output: Path | None, sets: tuple[str, ...], explained: bool, forced: bool, trusted: bool) -> None:
    """Write the run folder of CASE: effective case, decks, start positions.

    A set of cases gives one folder of run folders.
    """
    from fbcouple.case.user_code import list_code
    from fbcouple.decks.needs import explain
    from fbcouple.decks.set_up import lay_out

    for run, loaded in lay_out(case, output, sets, trusted, forced, click.echo).items():
        if explained:
            rows = [(part.name, "in" if part.is_in else "out", part.why) for part in explain(loaded)]
            print_table(["part", "", "why"], rows)
        trust = " --trust" if list_code(loaded) else ""
        click.echo(f"{run}: set up; start it with `fbcouple run {quote(str(run))}{trust}`")


@cli.command()
@click.argument("run", type=click.Path(path_type=Path))
@take_ranks
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
    help="Wall time [s] without a coupling step after which the run counts as hanging and is ended.",
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
    "several times. It is noted in the results.",
)
@take_trust
@outlive_output
def run(run: Path, ranks: int, resume: bool, fresh: bool, trusted: bool, **limits: Any) -> None:
    """Run the simulation in the folder RUN; exit code 75 if it stopped early and can continue with --resume."""
    require_plain(run)
    require_run(run)
    if resume and fresh:
        raise click.UsageError("--resume continues, --fresh starts again: give one of them")
    if limits["sets"] and not resume:
        raise click.UsageError("--set changes a run from its checkpoint on: give --resume with it")
    with Requests() as requests:  # from here to the last word, a signal is a request to stop
        run_on(run, ranks, resume, fresh, trusted, requests, limits)
        if requests.first:
            late = "came too late to stop the run: no moment for a checkpoint was left before its end"
            click.echo(f"{run}: {requests.first} {late}")


def run_on(
    run: Path, ranks: int, resume: bool, fresh: bool, trusted: bool, requests: Requests, limits: dict[str, Any]
) -> None:
    """Run what lies in `run` as far as it is asked to, with a display of its progress."""
    from fbcouple.case.load import load_case
    from fbcouple.case.user_code import require_trust
    from fbcouple.decks.unchanged import require_unchanged
    from fbcouple.errors import StoppedError
    from fbcouple.launcher.change_case import ask, changes_inlet
    from fbcouple.launcher.launch import is_complete, launch
    from fbcouple.launcher.progress import RunProgress

    case, sets = load_case(str(run)), limits["sets"]
    require_trust(case, trusted)
    require_unchanged(case, run, trusted, changes_inlet(sets))
    if sets:
        case = ask(case, sets, run)
    end = min(case.end_time, limits["until"] or case.end_time)
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
    for warning in progress.list_warnings():
        click.echo(f"{run}: warning: {warning}")
    if not is_complete(run, case):
        stopped_at = f"at or after {end:g} s of {case.end_time:g} s"
        click.echo(f"{run}: stopped at a moment for a checkpoint {stopped_at}; go on with {go_on}")
        return
    if end < case.end_time:
        text = f"no moment for a checkpoint came from --until {end:g} s to the end of the run"
        click.echo(f"{run}: {text}; checkpoint.moment_steps says after how many steps one comes")
    click.echo(f"{run}: done; draw its figures with `fbcouple post {quote(str(run))}`")


def require_run(run: Path) -> None:
    """Raise CaseError unless `run` is a folder that `setup` wrote."""
    if not (run / "case.toml").is_file():
        raise CaseError(
            [f"{run}: is not a run folder (no case.toml); write one with `fbcouple setup CASE -o {quote(str(run))}`."]
        )
    require_usable(run)


@cli.command()
@click.argument("folder", metavar="RUN", type=click.Path(path_type=Path))
@click.option("--scheduler", required=True, type=click.Choice(list(SCHEDULERS)), help="The batch system.")
@click.option(
    "--time", "limit", required=True, metavar="HH:MM:SS", callback=read_clock, help="Wall-time limit of a job."
)
@take_ranks
@click.option(
    "--notice",
    type=click.IntRange(min=1),
    default=300,
    show_default=True,
    metavar="SECONDS",
    help="Stop this long before the limit.",
)
@click.option("--memory", type=click.IntRange(min=1), help="Memory of all ranks [MiB]; by default estimated.")
@click.option("--module", "modules", multiple=True, help="Load this module first; may be given several times.")
@click.option("--queue", help="Partition or queue.")
@click.option("--account", help="Account or project.")
@click.option(
    "--chain", type=click.IntRange(min=1), help="Submit this many jobs, one after the other, without requeueing."
)
@take_trust
def batch(folder: Path, scheduler: str, **request: Any) -> None:
    """Write the job script of RUN for a batch system; an array job for a folder of runs."""
    from fbcouple.batch.jobs import Request, list_warnings, write_job

    asked = Request(**request)
    job, submit = write_job(folder, scheduler, asked)
    for warning in list_warnings(folder, asked):
        click.echo(f"warning: {warning}")
    click.echo(f"{job}: read it, then submit it with {submit}")


for command in (options, init, post, report, claims, study, bench, verify, validate, doctor):
    cli.add_command(command)


def main() -> None:
    """Entry point of the `fbcouple` command."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a terminal that has not all letters gets their numbers
    open_standard_streams()
    code: Any = 0
    try:
        cli(prog_name="fbcouple")
    except SystemExit as end:
        code = end.code
    sys.exit(finish(code))


if __name__ == "__main__":
    main()
