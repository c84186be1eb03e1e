"""`fbcouple init`: a case of one's own to begin with."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

from pathlib import Path
from shlex import quote

import click

DIAMETER, DENSITY, VELOCITY = click.FloatRange(1e-6, 1.0), click.FloatRange(10.0, 1e5), click.FloatRange(1e-4, 1e3)
KIND_NAMES = ("bubbling", "spout")


@click.command()
@click.argument("folder", metavar="NAME", type=click.Path(path_type=Path))
@click.option("--kind", type=click.Choice(KIND_NAMES), default="bubbling", show_default=True, help="Kind of the case.")
@click.option(
    "--diameter",
    type=DIAMETER,
    default=1e-3,
    show_default=True,
    help="Diameter of the particles [m].",
)
@click.option(
    "--density",
    type=DENSITY,
    default=2500.0,
    show_default=True,
    help="Density of the particles [kg m-3].",
)
@click.option(
    "--size",
    type=click.FloatRange(1e-5, 1e3),
    nargs=3,
    metavar="WIDTH DEPTH HEIGHT",
    help="Inner size of the box [m]; by default 40, 8 and 100 diameters, of a spout 60, 8 and 200.",
)
@click.option(
    "--velocity",
    type=VELOCITY,
    help="Superficial gas velocity [m s-1], of a spout that of its jet; by default twice U_mf, of a spout 1.3 U_mf in "
    "the column.",
)
def init(
    folder: Path,
    kind: str,
    diameter: float,
    density: float,
    size: tuple[float, float, float] | None,
    velocity: float | None,
) -> None:
    """Write the folder NAME with a case file: complete, commented and ready to run.

    The cells are chosen from the diameter, the mass from the size. Nothing but NAME/case.toml is written.
    """
    from fbcouple.case.kinds.registry import Wanted
    from fbcouple.case.new_case import write_new_case
    from fbcouple.decks.set_up import name_run

    unfit = write_new_case(folder, kind, Wanted(diameter, density, size, velocity))
    for number in unfit:
        click.echo(f"{number.verdict}: {number.name} is {number.value:.3g} {number.unit}, wanted {number.limit}")
    case, run = quote(str(folder)), quote(f"runs/{name_run(str(folder), folder / 'case.toml')}")
    click.echo(f"{folder / 'case.toml'}: written; next:")
    for command in (f"check {case}", f"setup {case}", f"run {run} -n 2", f"post {run}"):
        click.echo(f"  fbcouple {command}")
