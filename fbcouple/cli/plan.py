"""`fbcouple plan`: what reaches an error at least cost."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

import json
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

import click

from fbcouple.cli.arguments import read_clock, require_place, take_case, take_settings
from fbcouple.cli.table import print_table

if TYPE_CHECKING:
    from fbcouple.case.plan.candidates import Candidate
    from fbcouple.case.plan.choice import Plan

NOT_TOLD = "not told: what the case's own mesh errs, as a coarser one is only compared with it, and what models err"


@click.command()
@take_case
@click.option(
    "--error",
    type=float,
    required=True,
    metavar="PART",
    help="Error of the mean map of vertical solids flux over the map that is to be reached, as 0.05.",
)
@click.option(
    "--within",
    metavar="HH:MM:SS",
    callback=read_clock,
    help="Wall time in which it is to end; of what does the cheapest in core-hours is chosen, else what ends first.",
)
@click.option(
    "-n",
    "--ranks",
    type=click.IntRange(1, 100_000),
    default=1,
    show_default=True,
    help="MPI ranks that all replicas have together.",
)
@take_settings
@click.option(
    "--write", "target", type=click.Path(path_type=Path), help="Write the case that reaches the error to FILE.toml."
)
@click.option(
    "--picture",
    type=click.Path(path_type=Path, dir_okay=False),
    callback=require_place,
    help="Draw error against cost, with the Pareto front, to FILE: png, svg or pdf.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the plan as JSON.")
def plan(
    case: str,
    error: float,
    within: int | None,
    ranks: int,
    sets: tuple[str, ...],
    target: Path | None,
    picture: Path | None,
    as_json: bool,
) -> None:
    """Find which preset, fluid step, overlap, mesh, length of the means, replicas and ranks reach an error of CASE at
    least cost.

    Options that --set gives stay as they are. Exit code 1 if nothing reaches the error; the best that can be had is
    told.
    """
    from fbcouple.case.plan.case_file import require_free
    from fbcouple.case.plan.choice import make_plan
    from fbcouple.errors import CaseError

    if target:
        require_free(target)
    if picture:
        from fbcouple.postproc.plan_front import require_format

        require_format(picture)
    made = make_plan(case, error, within, ranks, sets)
    if as_json:
        click.echo(json.dumps(made.describe(), indent=1))
    else:
        _print(made)
    if picture:
        from fbcouple.postproc.plan_front import draw_front

        click.echo(str(draw_front(made.describe(), picture)), err=as_json)
    if made.chosen is None:
        raise CaseError([f"{case}: {made.tell_miss()}"])
    if target:
        file = made.write(target)
        click.echo(f"{file}: written; next:", err=as_json)
        for command in _list_commands(file, made.chosen):
            click.echo(f"  fbcouple {command}", err=as_json)


def _print(made: Plan) -> None:
    best = made.chosen or made.best
    shown = [*made.front, *([best] if best is not None and best not in made.front else [])]
    columns = ["error", "numerical", "statistical", *(shown[0].numerics.words if shown else ()), "runs x ranks"]
    columns += ["simulated", "wall time", "core-hours", "factor", ""]
    print_table(columns, [_make_row(one, made) for one in sorted(shown, key=lambda one: -one.error)])
    click.echo()
    for sentence in _tell(made):
        click.echo(sentence)


def _make_row(one: Candidate, made: Plan) -> list[str]:
    from fbcouple.cli.prediction import format_time

    mark = "chosen" if one is made.chosen else "best" if one is made.best else ""
    errors = [f"{value:.2g}" for value in (one.error, one.numerics.error, one.statistical)]
    split = f"{one.replicas} x {one.ranks}"
    costs = [f"{one.means.end:.3g} s", format_time(one.wall), f"{one.core_hours:.2g}", f"{one.factor:.2g}"]
    return [*errors, *one.numerics.words.values(), split, *costs, mark]


def _tell(made: Plan) -> list[str]:
    """What the choice is made of, and what of it is known how well."""
    from fbcouple.case.plan.measured_errors import FACTOR
    from fbcouple.cli.prediction import format_time, tell_source

    sentences = []
    if (one := made.chosen) is not None:
        until, end = one.list_settings()["averages.until_error"], one.end_limit
        cost = f"about {format_time(one.wall)}, {one.core_hours:.2g} core-hours, within a factor of {one.factor:.2g}"
        sentences.append(f"chosen: {one.numerics.format()}; {one.format_split()}, {cost}")
        text = f"each run ends by itself at a statistical error of {until:g}, at about {one.means.end:.3g} s"
        sentences.append(f"{text} and at {end:g} s at the latest")
    sentences.append(
        f"numerical errors: the larger of mueller/0.9 and patil/c2 as they are lifted, within a factor of {FACTOR:g}"
    )
    sentences.append(NOT_TOLD)
    if made.left_out:
        sentences.append(f"left out: {len(made.left_out)} numerics with which it is no case that is fit (--json)")
    if best := made.chosen or made.best:
        sentences.append(tell_source(best.prediction))
    return sentences


def _list_commands(file: Path, one: Candidate) -> list[str]:
    run = quote(f"runs/{file.stem}")
    replicas = f" --replicas {one.replicas} -j {one.replicas}" if one.replicas > 1 else ""
    commands = [f"setup {quote(str(file))} -o {run}", f"run {run}{replicas} -n {one.ranks}"]
    return [*commands, f"pool {run}"] if one.replicas > 1 else commands
