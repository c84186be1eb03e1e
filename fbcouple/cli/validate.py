"""`fbcouple validate`: measured beds, run and scored."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

from pathlib import Path

import click
from click.shell_completion import CompletionItem

from fbcouple.cli.arguments import take_ranks, take_settings, take_trust
from fbcouple.cli.table import print_explained, print_table
from fbcouple.machine.output import outlive_output
from fbcouple.run_folder.plain_files import require_plain


def complete_bed(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Shipped measured beds that begin with `incomplete`; the shell adds files where there is none."""
    from fbcouple.validate.source import list_beds

    names = [name for name in list_beds() if name.startswith(incomplete)]
    return [CompletionItem(incomplete, type="file"), *map(CompletionItem, names)]


@click.command()
@click.argument("name", required=False, shell_complete=complete_bed)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    help="Run folder; by default runs/validate/<name of the bed>. With --run the folder of the table alone; by default "
    "that of the run, of a file NAME.nc the folder NAME.",
)
@take_ranks
@click.option("--resume", is_flag=True, help="Go on with the run in the folder; one that is complete is scored again.")
@click.option(
    "--run", "finished", type=click.Path(path_type=Path), help="Score the run in this folder or file, and run nothing."
)
@take_settings
@take_trust
@outlive_output
def validate(
    name: str | None,
    output: Path | None,
    ranks: int,
    resume: bool,
    finished: Path | None,
    sets: tuple[str, ...],
    trusted: bool,
) -> None:
    """Run the measured bed NAME and score it against its data; without NAME list the measured beds.

    The score stands beside what others reached, in validation.html, .csv, .json and .png in the run folder.
    A folder with a case.toml and a validation.toml of your own is a NAME, too.
    """
    if name is None:
        if output or resume or finished or sets:
            raise click.UsageError("without NAME the measured beds are listed: give one, or no options")
        print_beds()
        return
    if finished and (resume or sets):
        raise click.UsageError("--run scores a run that was made: leave --resume and --set out")
    from fbcouple.machine.whole_files import require_writable
    from fbcouple.paths import find_home
    from fbcouple.postproc import open_results
    from fbcouple.results.tables import ELSEWHERE, show_cell
    from fbcouple.validate.page import COLUMNS, NAME, drop_blank, write_result
    from fbcouple.validate.runs import choose_folder, run_bed
    from fbcouple.validate.score import score
    from fbcouple.validate.source import read_bed

    bed = read_bed(name)
    run = finished or choose_folder(bed, output)
    require_plain(run)
    folder = output or find_home(run)
    require_writable(folder / f"{NAME}.json", ELSEWHERE)
    if finished is None:
        run_bed(bed, run, ranks, resume, sets, trusted, click.echo)
    results = open_results(run)
    result = score(bed, results)
    files, facts = write_result(bed, results, result, folder)
    rows = [drop_blank(row) for row in result.rows]
    print_table(COLUMNS, [[show_cell(row[column]) for column in COLUMNS] for row in rows])
    print_table(["run", ""], [(fact["what"], show_cell(fact["value"])) for fact in facts])
    for remark in result.remarks:
        click.echo(remark)
    for file in files:
        click.echo(str(file))


def print_beds() -> None:
    """Print the shipped measured beds: what is measured of each, by whom, and what a run takes."""
    from fbcouple.validate.source import list_beds, read_bed

    beds = [read_bed(name) for name in list_beds()]
    measured = ["; ".join(task.measurement.name for task in bed.tasks) for bed in beds]
    rows = [
        (bed.name, bed.about.cost, f"{bed.about.source}: {words}") for bed, words in zip(beds, measured, strict=True)
    ]
    print_explained(["bed", "a run takes", "measured"], rows)
