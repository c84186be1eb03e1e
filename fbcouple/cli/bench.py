"""`fbcouple bench`: where the time goes, and how it scales."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from fbcouple.cli.table import print_table

Row = dict[str, Any]
take_file = click.option(
    "--json", "file", type=click.Path(path_type=Path, dir_okay=False), help="Write the tables to FILE."
)


def show(rows: list[Row]) -> None:
    """Print a table of rows that have the same columns."""
    from fbcouple.study.tables import show_cell

    columns = list(dict.fromkeys(key for row in rows for key in row))
    print_table(columns, [[show_cell(row.get(column)) for column in columns] for row in rows])


def write(file: Path | None, tables: dict[str, list[Row]]) -> None:
    """Write the tables as JSON, one object a row."""
    from fbcouple.study.tables import describe_machine

    if file:
        file.write_text(json.dumps({"machine": describe_machine()} | tables, indent=1) + "\n", encoding="utf-8")


@click.group()
def bench() -> None:
    """Where the time goes, beside what the solvers alone take, and how it scales."""


@bench.command()
@click.argument("case")
@click.option("-n", "--ranks", type=click.IntRange(min=1), default=1, show_default=True, help="MPI ranks.")
@click.option("--seconds", type=click.FloatRange(min=0.1), default=20.0, show_default=True, help="Wall time measured.")
@click.option("--warm", type=click.FloatRange(min=0.0), default=0.0, help="Simulated time before it [s].")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Put a value on top of the case file.")
@take_file
def overhead(case: str, ranks: int, seconds: float, warm: float, sets: tuple[str, ...], file: Path | None) -> None:
    """Seconds of each stage and rank of CASE, beside LIGGGHTS and the gas solver alone on the same steps."""
    from fbcouple.bench.suite import measure_overhead

    found = measure_overhead(case, sets, ranks, warm, seconds)
    show(found["ranks"])
    show([found["total"]])
    write(file, {"ranks": found["ranks"], "total": [found["total"]]})


@bench.command()
@click.argument("case")
@click.option("--warm", type=click.FloatRange(min=0.0), default=0.0, help="Simulated time before it [s].")
@click.option(
    "--steps",
    type=click.IntRange(min=1),
    default=200,
    show_default=True,
    help="Steps a turn; the cheapest tenth counts.",
)
@click.option("--repeats", type=click.IntRange(min=1), default=3, show_default=True, help="Turns; the cheapest counts.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Put a value on top of the case file.")
@take_file
def parts(case: str, warm: float, steps: int, repeats: int, sets: tuple[str, ...], file: Path | None) -> None:
    """What CASE costs without each of its parts: friction, damping, filter, sub-grid model, gas, particles ..."""
    from fbcouple.bench.suite import measure_parts

    rows = measure_parts(case, sets, warm, steps, repeats)
    show(rows)
    write(file, {"parts": rows})


@bench.command()
@click.argument("case")
@click.option("-n", "--ranks", type=click.IntRange(min=1), default=1, show_default=True, help="MPI ranks.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Put a value on top of the case file.")
@take_file
def memory(case: str, ranks: int, sets: tuple[str, ...], file: Path | None) -> None:
    """Bytes that each rank of CASE keeps a particle and a cell, beside the solvers' own."""
    from fbcouple.bench.suite import measure_memory

    rows = measure_memory(case, sets, ranks)
    show(rows)
    write(file, {"memory": rows})


@bench.command()
@click.argument("case")
@click.option("-n", "--ranks", type=click.IntRange(min=1), default=1, show_default=True, help="MPI ranks.")
@click.option("--warm", type=click.FloatRange(min=0.0), default=0.01, show_default=True, help="Time before it [s].")
@click.option("--steps", type=click.IntRange(min=5), default=20, show_default=True, help="Fluid steps measured.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Put a value on top of the case file.")
@take_file
def peers(case: str, ranks: int, warm: float, steps: int, sets: tuple[str, ...], file: Path | None) -> None:
    """CASE through stock DPMFoam, beside this program, per simulated second; its particles alone through LAMMPS."""
    from fbcouple.bench.lammps import explain_absence
    from fbcouple.bench.peers import NOT_COMPARABLE
    from fbcouple.bench.suite import measure_peers
    from fbcouple.case.load import load_case

    tables = measure_peers(case, sets, ranks, warm, steps)
    show(tables["peers"])
    click.echo(NOT_COMPARABLE)
    show(tables["particles"])
    if why := explain_absence(load_case(case, sets)):
        click.echo(why)
    write(file, tables)


@bench.command()
@click.argument("case")
@click.option(
    "--skin",
    "skins",
    type=click.FloatRange(min=0.05, max=10.0),
    multiple=True,
    help="Skin in diameters; several times.  [default: 0.2, 0.3, 0.4, 0.5, 0.7]",
)
@click.option("-n", "--ranks", type=click.IntRange(min=1), default=1, show_default=True, help="MPI ranks.")
@click.option("--warm", type=click.FloatRange(min=0.0), default=0.01, show_default=True, help="Time before it [s].")
@click.option("--steps", type=click.IntRange(min=1), default=100, show_default=True, help="Fluid steps measured.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Put a value on top of the case file.")
@take_file
def skin(
    case: str,
    skins: tuple[float, ...],
    ranks: int,
    warm: float,
    steps: int,
    sets: tuple[str, ...],
    file: Path | None,
) -> None:
    """LIGGGHTS in CASE with neighbour lists of several skins: which is the fastest for `contact.skin`."""
    from fbcouple.bench.suite import measure_skins

    rows = measure_skins(case, sets, skins or (0.2, 0.3, 0.4, 0.5, 0.7), ranks, warm, steps)
    show(rows)
    best = min(rows, key=lambda row: row["cheapest"])["skin"]
    click.echo(f"fastest: --set contact.skin={best:g}, or skin = {best:g} in [contact] of the case")
    write(file, {"skins": rows})


@bench.command()
@click.argument("case")
@click.option("-n", "--ranks", "counts", type=click.IntRange(min=1), multiple=True, help="Ranks to run; several times.")
@click.option("--warm", type=click.FloatRange(min=0.0), default=0.01, show_default=True, help="Time before it [s].")
@click.option("--steps", type=click.IntRange(min=1), default=50, show_default=True, help="Fluid steps a repeat.")
@click.option("--repeats", type=click.IntRange(min=1), default=3, show_default=True, help="The fastest counts.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Put a value on top of the case file.")
@take_file
def strong(
    case: str, counts: tuple[int, ...], warm: float, steps: int, repeats: int, sets: tuple[str, ...], file: Path | None
) -> None:
    """Strong scaling of CASE: the same steps on each number of ranks."""
    from fbcouple.bench.suite import measure_strong

    rows = measure_strong(case, sets, counts or (1, 2), warm, steps, repeats)
    show(rows)
    write(file, {"strong": rows})


@bench.command()
@click.option("--cells", type=click.IntRange(min=10), default=12, show_default=True, help="Cells along an edge.")
@click.option("-n", "--ranks", "counts", type=click.IntRange(min=1), multiple=True, help="Ranks to run; several times.")
@click.option("--steps", type=click.IntRange(min=1), default=20, show_default=True, help="Fluid steps a repeat.")
@click.option("--repeats", type=click.IntRange(min=1), default=3, show_default=True, help="The fastest counts.")
@click.option("--tetrahedra", is_flag=True, help="Cut each cell into six, as the paper's are, with 11 particles each.")
@click.option("--traffic-only", is_flag=True, help="Run nothing: only messages and bytes of the exchange plans.")
@take_file
def scaling(
    cells: int,
    counts: tuple[int, ...],
    steps: int,
    repeats: int,
    tetrahedra: bool,
    traffic_only: bool,
    file: Path | None,
) -> None:
    """The canonical box, strong and weak, by eqs 46-47; messages and bytes of the plan of hexahedra to 64 ranks."""
    from fbcouple.bench.suite import count_traffic, measure_scaling

    tables = {}
    if not traffic_only:
        tables["scaling"] = measure_scaling(cells, counts or (1, 2), steps, repeats, tetrahedra)
        show(tables["scaling"])
    tables["traffic"] = count_traffic(cells, (1, 2, 4, 8, 16, 32, 64))
    show(tables["traffic"])
    write(file, tables)
