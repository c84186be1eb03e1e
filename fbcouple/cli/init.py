"""`fbcouple init`: a case of one's own to begin with."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

import math
from pathlib import Path
from shlex import quote
from typing import Any

import click


class Metres(click.FloatRange):
    """A length in m, with what was meant where it is too long for one."""

    name = "metres"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The length; click's usage error if it is none, or out of range."""
        length = click.FLOAT.convert(value, param, ctx)
        if self.max is not None and self.max < length < math.inf:
            text = f"{length:g} m is given, at most {self.max:g} m is allowed"
            self.fail(f"{text}; lengths are in m: write {length:g} mm as {1e-3 * length:g}", param, ctx)
        return float(super().convert(value, param, ctx))


DIAMETER, LENGTH = Metres(1e-6, 0.05), Metres(1e-5, 30.0)
DENSITY, VELOCITY = click.FloatRange(10.0, 1e5), click.FloatRange(1e-4, 1e3)
KIND_NAMES = ("bubbling", "column", "riser", "spout")


@click.command()
@click.argument("folder", metavar="NAME", type=click.Path(path_type=Path))
@click.option(
    "--kind",
    type=click.Choice(KIND_NAMES),
    default="bubbling",
    show_default=True,
    help="A bubbling bed in a box or a round column, a riser, or a spouted bed.",
)
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
    type=LENGTH,
    nargs=3,
    metavar="WIDTH DEPTH HEIGHT",
    help="Inner size of the box [m], of a column its diameter, twice, and height; by default 40, 8 and 100 particle "
    "diameters, of a column 20, 20 and 100, of a riser 20, 20 and 200, of a spout 60, 8 and 200.",
)
@click.option(
    "--velocity",
    type=VELOCITY,
    help="Superficial gas velocity [m s-1], of a spout that of its jet; by default twice U_mf, of a riser 1.5 times "
    "the terminal velocity, of a spout 1.3 U_mf in the column.",
)
@click.option(
    "--bed-height",
    type=LENGTH,
    help="Height of the bed at rest [m], for its mass; by default a quarter of the box, of a spout a fifth. "
    "A riser starts empty.",
)
def init(
    folder: Path,
    kind: str,
    diameter: float,
    density: float,
    size: tuple[float, float, float] | None,
    bed_height: float | None,
    velocity: float | None,
) -> None:
    """Write the folder NAME with a case file: complete, commented and ready to run.

    The cells are chosen from the diameter, the mass from the height of the bed. Nothing but NAME/case.toml is written.
    """
    from fbcouple.case.kinds.registry import Wanted
    from fbcouple.case.new_case import write_new_case
    from fbcouple.decks.set_up import name_run

    numbers = write_new_case(folder, kind, Wanted(diameter, density, size, velocity, bed_height))
    for number in numbers:
        if number.verdict in (None, "fit"):
            continue
        click.echo(f"{number.verdict}: {number.name} is {number.format()}, wanted {number.limit}")
    case, run = quote(str(folder)), quote(f"runs/{name_run(str(folder), folder / 'case.toml')}")
    count = next(int(number.value) for number in numbers if number.name == "particles")
    bed = f"{count} particles" if count else "starts empty, fed with particles"
    click.echo(f"{folder / 'case.toml'}: written, {bed} of {1e3 * diameter:g} mm; next:")
    for command in (f"check {case}", f"setup {case}", f"run {run} -n 2", f"post {run}"):
        click.echo(f"  fbcouple {command}")
