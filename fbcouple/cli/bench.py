"""`fbcouple bench`: where the time goes, and how it scales."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from fbcouple.cli.arguments import JSON_ELSEWHERE, complete_case, take_case, take_json, take_ranks, take_settings
from fbcouple.cli.group import WholeSentences
from fbcouple.cli.table import print_table
from fbcouple.errors import CaseError

Row = dict[str, Any]
take_warm = click.option(
    "--warm",
    type=click.FloatRange(min=0.0),
    default=0.01,
    show_default=True,
    help="Simulated time before the measurement [s].",
)
take_turns = click.option(
    "--turns",
    type=click.IntRange(min=1),
    default=3,
    show_default=True,
    help="Most turns of each measurement, one after the other; none follows once the two cheapest agree within 3 %.",
)


def show(rows: list[Row]) -> None:
    """Print a table of rows that have the same columns, and what disturbed their measurement."""
    from fbcouple.bench.turns import warn_of_others
    from fbcouple.results.tables import show_cell

    columns = list(dict.fromkeys(key for row in rows for key in row))
    print_table(columns, [[show_cell(row.get(column)) for column in columns] for row in rows])
    if warning := warn_of_others(rows):
        click.echo(warning)


def write(file: Path | None, tables: dict[str, list[Row]], about: Row | None = None) -> None:
    """Write the tables as JSON, one object a row, after the machine and what `about` says of all of them."""
    from fbcouple.results.tables import describe_machine, write_json

    if file:
        write_json(file, tables, {"machine": describe_machine()} | (about or {}), JSON_ELSEWHERE)


@click.group(cls=WholeSentences)
def bench() -> None:
    """Measure where the time goes, next to the solvers alone, and how it scales."""


@bench.command()
@click.option("--fresh", is_flag=True, help="Measure again where this machine has been measured.")
@take_json
def calibrate(fresh: bool, file: Path | None) -> None:
    """Measure what a step costs on this machine, for the predictions of `check`; 2 minutes, with nothing else running.

    The costs are kept in the cache, by host.
    """
    from fbcouple.bench.calibrate import calibrate as measure
    from fbcouple.bench.calibrate import tabulate
    from fbcouple.case.cost.coefficients import find_file, load_coefficients, save_coefficients

    try:
        kept = None if fresh else load_coefficients()
    except CaseError as error:
        click.echo(f"warning: {error} It is written anew.", err=True)
        kept = None
    if kept and not kept.is_shipped:
        show(tabulate(kept))
        click.echo(f"{find_file()}: the costs of {kept.measured}; --fresh measures again")
        return
    found, rows = measure(click.echo)
    show(rows)
    costs = tabulate(found)
    show(costs)
    write(file, {"scenes": rows, "costs": costs})
    click.echo(f"{save_coefficients(found, {'scenes': rows})}: the costs of {found.measured}")


@bench.command()
@click.argument("cases", nargs=-1, required=True, metavar="CASE [CASE ...]", shell_complete=complete_case)
@take_ranks
@click.option(
    "--seconds",
    type=click.FloatRange(min=0.0, min_open=True),
    default=0.05,
    show_default=True,
    help="Simulated time measured [s].",
)
@click.option(
    "--warm",
    type=click.FloatRange(min=0.0),
    default=0.15,
    show_default=True,
    help="Simulated time before the measurement [s], in which the bed begins to move.",
)
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), help="Write the table to a folder.")
@take_settings
def predictions(
    cases: tuple[str, ...], ranks: int, seconds: float, warm: float, output: Path | None, sets: tuple[str, ...]
) -> None:
    """Hold what `check` predicts of each CASE against the first part of its run, in processor time."""
    from fbcouple.bench.predictions import hold_predictions, write_predictions
    from fbcouple.case.cost.coefficients import load_coefficients
    from fbcouple.machine.whole_files import require_writable
    from fbcouple.results.tables import ELSEWHERE

    if output:
        require_writable(output / "predictions.json", ELSEWHERE)
    rows = hold_predictions(cases, sets, ranks, warm, seconds, click.echo)
    show(rows)
    for path in write_predictions(output, rows, load_coefficients()) if output else ():
        click.echo(f"{path}: written")


@bench.command()
@take_case
@take_ranks
@click.option("--seconds", type=click.FloatRange(min=0.1), default=20.0, show_default=True, help="Wall time measured.")
@click.option("--warm", type=click.FloatRange(min=0.0), default=0.0, help="Simulated time before the measurement [s].")
@take_turns
@take_settings
@take_json
def overhead(
    case: str, ranks: int, seconds: float, warm: float, turns: int, sets: tuple[str, ...], file: Path | None
) -> None:
    """Measure each stage and rank of CASE, next to LIGGGHTS and the gas solver alone on the same steps."""
    from fbcouple.bench.suite import measure_overhead

    found = measure_overhead(case, sets, ranks, warm, seconds, turns)
    show(found["ranks"])
    show([found["total"]])
    write(file, {"ranks": found["ranks"], "total": [found["total"]]})


@bench.command()
@take_case
@click.option("--warm", type=click.FloatRange(min=0.0), default=0.0, help="Simulated time before the measurement [s].")
@click.option(
    "--steps",
    type=click.IntRange(min=1),
    default=200,
    show_default=True,
    help="Steps a turn; the cheapest tenth counts.",
)
@take_turns
@take_settings
@take_json
def parts(case: str, warm: float, steps: int, turns: int, sets: tuple[str, ...], file: Path | None) -> None:
    """Measure CASE without each of its parts: friction, damping, filter, sub-grid model, gas, particles and more."""
    from fbcouple.bench.suite import measure_parts

    rows = measure_parts(case, sets, warm, steps, turns)
    show(rows)
    write(file, {"parts": rows})


@bench.command()
@take_case
@take_ranks
@take_settings
@take_json
def memory(case: str, ranks: int, sets: tuple[str, ...], file: Path | None) -> None:
    """Measure the memory of each rank of CASE per particle and cell, next to the solvers' own."""
    from fbcouple.bench.suite import measure_memory

    rows = measure_memory(case, sets, ranks)
    show(rows)
    write(file, {"memory": rows})


@bench.command()
@take_case
@take_ranks
@take_warm
@click.option("--steps", type=click.IntRange(min=5), default=20, show_default=True, help="Fluid steps measured.")
@take_turns
@take_settings
@take_json
def peers(case: str, ranks: int, warm: float, steps: int, turns: int, sets: tuple[str, ...], file: Path | None) -> None:
    """Run CASE in stock DPMFoam and in this program, and its particles alone in LAMMPS, for comparison."""
    from fbcouple.bench.lammps import explain_absence
    from fbcouple.bench.peers import NOT_COMPARABLE
    from fbcouple.bench.suite import measure_peers
    from fbcouple.case.load import load_case

    tables = measure_peers(case, sets, ranks, warm, steps, turns)
    show(tables["peers"])
    click.echo(NOT_COMPARABLE)
    show(tables["particles"])
    if why := explain_absence(load_case(case, sets)):
        click.echo(why)
    write(file, tables)


@bench.command()
@take_case
@click.option(
    "--skin",
    "skins",
    type=click.FloatRange(min=0.05, max=10.0),
    multiple=True,
    help="Skin in diameters; may be given several times.  [default: 0.2, 0.3, 0.4, 0.5, 0.7]",
)
@take_ranks
@take_warm
@click.option("--steps", type=click.IntRange(min=1), default=100, show_default=True, help="Fluid steps measured.")
@take_turns
@take_settings
@take_json
def skin(
    case: str,
    skins: tuple[float, ...],
    ranks: int,
    warm: float,
    steps: int,
    turns: int,
    sets: tuple[str, ...],
    file: Path | None,
) -> None:
    """Measure LIGGGHTS in CASE with several skins of the neighbour lists, to choose `contact.skin`."""
    from fbcouple.bench.suite import measure_skins

    rows = measure_skins(case, sets, skins or (0.2, 0.3, 0.4, 0.5, 0.7), ranks, warm, steps, turns)
    show(rows)
    best = min(rows, key=lambda row: row["cheapest"])["skin"]
    click.echo(f"fastest: --set contact.skin={best:g}, or skin = {best:g} in [contact] of the case")
    write(file, {"skins": rows})


@bench.command()
@take_case
@click.option(
    "-n",
    "--ranks",
    "counts",
    type=click.IntRange(min=1),
    multiple=True,
    help="Number of MPI ranks; may be given several times.",
)
@take_warm
@click.option("--steps", type=click.IntRange(min=1), default=50, show_default=True, help="Fluid steps a turn.")
@take_turns
@take_settings
@take_json
def strong(
    case: str, counts: tuple[int, ...], warm: float, steps: int, turns: int, sets: tuple[str, ...], file: Path | None
) -> None:
    """Measure the strong scaling of CASE: the same steps on each number of ranks."""
    from fbcouple.bench.suite import measure_strong

    rows = measure_strong(case, sets, counts or (1, 2), warm, steps, turns)
    show(rows)
    write(file, {"strong": rows})


@bench.command()
@click.option("--cells", type=click.IntRange(min=10), default=12, show_default=True, help="Cells along an edge.")
@click.option(
    "-n",
    "--ranks",
    "counts",
    type=click.IntRange(min=1),
    multiple=True,
    help="Number of MPI ranks, with --traffic-only of ranks counted; may be given several times.",
)
@click.option("--steps", type=click.IntRange(min=1), default=20, show_default=True, help="Fluid steps a turn.")
@take_turns
@click.option(
    "--tetrahedra", is_flag=True, help="Cut each cell into six tetrahedra with 11 particles each, as in the paper."
)
@click.option("--traffic-only", is_flag=True, help="Run nothing; only count messages and bytes of the halo exchange.")
@take_json
def scaling(
    cells: int,
    counts: tuple[int, ...],
    steps: int,
    turns: int,
    tetrahedra: bool,
    traffic_only: bool,
    file: Path | None,
) -> None:
    """Measure strong and weak scaling of the canonical box (eqs 46-47), and count its messages up to 64 ranks."""
    from fbcouple.bench.suite import count_traffic, measure_scaling
    from fbcouple.results.tables import TETRAHEDRA

    tables = {}
    if not traffic_only:
        tables["scaling"] = measure_scaling(cells, counts or (1, 2), steps, turns, tetrahedra)
        show(tables["scaling"])
    tables["traffic"] = count_traffic(cells, (traffic_only and counts) or (1, 2, 4, 8, 16, 32, 64))
    show(tables["traffic"])
    write(file, tables, {"cells": TETRAHEDRA if tetrahedra else "hexahedra"})
