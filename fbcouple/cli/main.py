"""The command line: the only place that prints and chooses exit codes.

Exit codes: 0 done; 1 the case or the input is wrong; 2 usage; 3 a solver or the machine failed; 4 the simulation
diverged or broke a conservation check; 75 stopped early, `--resume` goes on; 130 interrupted; 141 the reader of the
output went away. Heavy modules load inside commands.
"""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

import io
import sys
from pathlib import Path
from shlex import quote
from tempfile import TemporaryDirectory
from typing import Any

import click
from rich.text import Text

from fbcouple.batch.schedulers import SCHEDULERS
from fbcouple.cli.arguments import (
    read_clock,
    take_case,
    take_case_or_set,
    take_ranks,
    take_ranks_or_none,
    take_settings,
    take_trust,
)
from fbcouple.cli.bench import bench
from fbcouple.cli.doctor import doctor
from fbcouple.cli.group import Commands, finish
from fbcouple.cli.init import init
from fbcouple.cli.options import options
from fbcouple.cli.pictures import claims, post, report
from fbcouple.cli.placement import take_placement
from fbcouple.cli.plan import plan
from fbcouple.cli.pool import pool
from fbcouple.cli.run import run as run_command
from fbcouple.cli.status import status
from fbcouple.cli.study import study
from fbcouple.cli.table import print_explained, print_table
from fbcouple.cli.validate import validate
from fbcouple.cli.verify import verify
from fbcouple.errors import CaseError
from fbcouple.machine.output import open_standard_streams

COLOURS = {"fit": "green", "warn": "yellow", "unfit": "bold red"}


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
@take_ranks
@take_settings
@take_trust
def check(case: str, ranks: int, sets: tuple[str, ...], trusted: bool) -> None:
    """Report every mistake in CASE at once, the pre-flight numbers, and what a run will cost; start no solver.

    Exit code 1 if there is a mistake, or a number is unfit.
    """
    from fbcouple.case.cost.coefficients import load_coefficients
    from fbcouple.case.cost.prediction import predict
    from fbcouple.case.cost.ranks import propose_ranks
    from fbcouple.case.load import load_case
    from fbcouple.case.preflight import estimate
    from fbcouple.case.source import find_case
    from fbcouple.case.user_code import DRAG_FILE, list_law_files
    from fbcouple.cli.prediction import format_proposal, print_prediction

    folder = find_case(case).parent
    loaded = load_case(case, sets, click.echo)
    law, own_laws = None, list_law_files(loaded)
    if own_laws and trusted:
        from fbcouple.decks.set_up import read_own_laws

        law = read_own_laws(loaded, folder)
    with TemporaryDirectory(prefix="fbcouple-start-") as scratch:
        if loaded.start is not None and loaded.start.is_made:
            from fbcouple.decks.starts import make_start

            loaded = make_start(loaded, folder, Path(scratch), click.echo, pours=False)
        numbers = estimate(loaded, law, folder)
        costs = load_coefficients()
        predicted = predict(loaded, ranks, costs, folder, law)
        proposal = propose_ranks(loaded, costs, predicted)
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
    click.echo()
    print_prediction(predicted)
    click.echo(format_proposal(proposal))
    if unfit := [number for number in numbers if number.verdict == "unfit"]:
        mend = "fix the case; `setup` refuses it without --force."
        raise CaseError(
            [f"{case}: {number.name}: {number.format()}, {number.limit} is fit; {mend}" for number in unfit]
        )
    for key in () if trusted else own_laws:
        lost = "no numbers of the drag" if key == DRAG_FILE else "whether it compiles is not known"
        click.echo(f"{key} is not run: {lost}; --trust runs it")


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
    from fbcouple.cli.prediction import format_line
    from fbcouple.decks.needs import explain
    from fbcouple.decks.set_up import lay_out

    for run, loaded in lay_out(case, output, sets, trusted, forced, click.echo).items():
        if explained:
            rows = [(part.name, "in" if part.is_in else "out", part.why) for part in explain(loaded)]
            print_table(["part", "", "why"], rows)
        trust = " --trust" if list_code(loaded) else ""
        click.echo(f"{run}: {format_line(loaded, run)}")
        click.echo(f"{run}: set up; start it with `fbcouple run {quote(str(run))}{trust}`")


@cli.command()
@click.argument("folder", metavar="RUN", type=click.Path(path_type=Path))
@click.option("--scheduler", required=True, type=click.Choice(list(SCHEDULERS)), help="The batch system.")
@click.option(
    "--time", "limit", required=True, metavar="HH:MM:SS", callback=read_clock, help="Wall-time limit of a job."
)
@take_ranks_or_none
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
@click.option(
    "--replicas",
    "count",
    type=click.IntRange(min=2),
    metavar="N",
    help="Of N replicas of the case, with different seeds: RUN becomes their folder, as `run --replicas` has it.",
)
@take_trust
@take_placement
def batch(folder: Path, scheduler: str, ranks: int | None, count: int | None, placement: Any, **request: Any) -> None:
    """Write the job script of RUN for a batch system; an array job for a folder of runs."""
    from fbcouple.batch.jobs import Request, list_warnings, write_job

    if count is not None:
        from fbcouple.decks.replicas import make_replicas

        make_replicas(folder, count, click.echo)
    if ranks is None:
        from fbcouple.batch.placement import fill_nodes
        from fbcouple.batch.proposal import propose_for
        from fbcouple.cli.prediction import format_proposal

        if (ranks := placement.places) is None:
            run, proposal = propose_for(folder)
            click.echo(f"{run}: {format_proposal(proposal)}")
            ranks = fill_nodes(placement, proposal.ranks)
    asked = Request(ranks, **request, placement=placement)
    job, submit = write_job(folder, scheduler, asked)
    for warning in list_warnings(folder, asked):
        click.echo(f"warning: {warning}")
    click.echo(f"{job}: read it, then submit it with {submit}")


for command in (
    options,
    init,
    plan,
    run_command,
    status,
    pool,
    post,
    report,
    claims,
    study,
    bench,
    verify,
    validate,
    doctor,
):
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
