"""`fbcouple post`, `report` and `claims`: what is drawn and told of runs that are over, or under way."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from shlex import quote

import click

from fbcouple.cli.arguments import JSON_ELSEWHERE, take_json
from fbcouple.cli.group import tell
from fbcouple.cli.table import print_table
from fbcouple.errors import CaseError
from fbcouple.run_folder.plain_files import require_plain


def require_lengths(ctx: click.Context, parameter: click.Parameter, values: tuple[float, ...]) -> tuple[float, ...]:
    """Refuse infinity and nan, which click takes for numbers."""
    if not all(math.isfinite(value) for value in values):
        raise click.BadParameter("give lengths in m")
    return values


take_heights = click.option(
    "--height",
    "heights",
    multiple=True,
    metavar="METRES",
    type=click.FloatRange(min=0.0, min_open=True),
    callback=require_lengths,
    help="Height of profiles above the floor [m]; may be given several times. By default those of the case "
    "(output.profile_heights), else that of the bed's centre of mass.",
)


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder of the figures; by default figures in the run folder (and vtk and tables there), of a file NAME.nc in "
    "the folder NAME.",
)
@click.option("--only", multiple=True, metavar="NAME", help="Only this figure, as history; may be given several times.")
@click.option(
    "--format", "ending", type=click.Choice(["png", "svg", "pdf"]), default="png", show_default=True, help="Of figures."
)
@take_heights
@click.option("--full-height", is_flag=True, help="Maps up to the top of the box, not only a little above the bed.")
@click.option(
    "--animate", "moving", is_flag=True, help="Also draw figures/bed.gif from the frames (output.particles_every)."
)
@click.option("--vtk", "exported", is_flag=True, help="Also write RUN/vtk: means and frames for ParaView.")
@click.option(
    "--csv",
    "tabulated",
    is_flag=True,
    help="Also write RUN/tables for a spreadsheet: history, probes, and profiles over the radius of a column.",
)
def post(
    run: Path,
    folder: Path | None,
    only: tuple[str, ...],
    ending: str,
    heights: tuple[float, ...],
    full_height: bool,
    moving: bool,
    exported: bool,
    tabulated: bool,
) -> None:
    """Draw the figures of RUN from its results.nc and its frames."""
    require_plain(run)
    from fbcouple.postproc import View, draw
    from fbcouple.postproc.views.views import animate

    for picture in draw(run, folder, only, ending, View(heights, full_height)):
        click.echo(str(picture))
    if moving:
        click.echo(str(animate(run, folder)))
    if exported:
        from fbcouple.postproc.views.vtk_files import export

        for file in export(run, folder and folder / "vtk"):
            click.echo(str(file))
    if tabulated:
        from fbcouple.postproc.spreadsheets import export_tables

        for file in export_tables(run, folder and folder / "tables"):
            click.echo(str(file))


@click.command()
@click.argument("runs", nargs=-1, required=True, metavar="RUN...", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    help="HTML file; by default report.html in the run folder, of a file NAME.nc in the folder NAME, for several runs "
    "in the current folder.",
)
@click.option(
    "--reference",
    "references",
    multiple=True,
    metavar="QUANTITY@HEIGHT=FILE",
    help="Measured line across the bed at HEIGHT [m], a CSV file of x, value, error, for all RUNs; may be given "
    "several times.",
)
@take_heights
def report(
    runs: tuple[Path, ...], output: Path | None, references: tuple[str, ...], heights: tuple[float, ...]
) -> None:
    """Write one self-contained HTML page on RUNs, compared with the first of them, and its numbers as JSON.

    Of a folder of runs it is on those in it; where they are beds of the reference paper (patil/all) it is that paper,
    figure by figure, also as Markdown with pictures and data in a folder beside it.
    """
    from fbcouple.paths import find_home, list_members

    members = list_members(runs[0]) if len(runs) == 1 else []
    for run in members or runs:
        require_plain(run)
    page = output or (find_home(runs[0]) if len(runs) == 1 else Path()) / "report.html"
    for file in _write_pages(runs, members, page, references, heights):
        click.echo(str(file))


def _write_pages(
    runs: tuple[Path, ...], members: list[Path], page: Path, references: tuple[str, ...], heights: tuple[float, ...]
) -> list[Path]:
    """The page of the paper, if the members of the set are of it, else the report of all."""
    from fbcouple.postproc import View
    from fbcouple.postproc.report.report import write_report

    if members and not references and not heights:
        from fbcouple.postproc.papers.hamidouche2019.page import is_of_the_paper, open_members
        from fbcouple.postproc.papers.hamidouche2019.page_files import write_page

        opened = open_members(members)
        if is_of_the_paper(opened):
            return write_page(runs[0], opened, page)
    return write_report(members or runs, page, references, View(heights))


@click.command()
@click.argument("runs", nargs=-1, required=True, metavar="RUN...", type=click.Path(path_type=Path))
@take_json
def claims(runs: tuple[Path, ...], file: Path | None) -> None:
    """Check which statements of the reference paper hold in RUNs, and which these runs cannot decide.

    Which of several runs of a bed counts, and what makes a run none of the paper's, is told beside, and on stderr whose
    means begin in the start-up.
    """
    from fbcouple.paths import list_members

    for run in runs:
        require_plain(run)
        if members := list_members(run):
            names = " ".join(quote(str(member)) for member in members)
            raise CaseError([f"{run}: a folder of runs; give those that are meant: `fbcouple claims {names}`."])
    from fbcouple.postproc.papers.hamidouche2019.told_claims import tell_claims
    from fbcouple.results.tables import write_json

    told = tell_claims(runs)
    tell(*(f"warning: {text}" for text in told.warnings))
    columns = ["statement", "place", "numerics", "beds", "measured", "wanted", "verdict", "why"]
    for text in filter(None, [told.numerics, *told.choices, *told.idle]):
        click.echo(text)
    if told.shown:
        print_table(columns, [[getattr(row, column) for column in columns] for row in told.shown])
    for text in told.tell_rest():
        click.echo(text)
    if file:
        about = {"numerics": told.numerics, "runs": told.choices + told.idle, "warnings": told.warnings}
        write_json(file, {"claims": [asdict(row) for row in told.rows]}, about, JSON_ELSEWHERE)
