"""`fbcouple study`: error against run time, and stability."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

from pathlib import Path

import click

from fbcouple.cli.group import WholeSentences
from fbcouple.cli.table import print_table
from fbcouple.machine.output import outlive_output


def choose_folder(study: str, output: Path | None) -> Path:
    """Folder of the study's runs and tables: as given, or runs/studies/<name of the study>."""
    path = Path(study)
    name = path.name if path.suffix != ".toml" else (path.parent.name if path.stem == "study" else path.stem)
    return output or Path("runs/studies") / (name or path.resolve().name)


take_output = click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="Folder; by default runs/studies/<name of the study>."
)


take_jobs = click.option(
    "-j",
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    help='Runs side by side; they share the machine, so measure costs as CPU time (`cost = "cpu"` in the study).',
)


@click.group(cls=WholeSentences)
def study() -> None:
    """Run studies: error against run time, and stability."""


@study.command("list")
def list_shipped() -> None:
    """List the studies that come with fbcouple."""
    from fbcouple.case.source import read_toml
    from fbcouple.study.source import list_studies

    print_table(["study", "title"], [(name, read_toml(path, name)["title"]) for name, path in list_studies().items()])


@study.command("error-vs-time")
@click.argument("name", metavar="STUDY")
@take_output
@click.option("--dry", is_flag=True, help="Only list the members.")
@click.option(
    "--done", "only_done", is_flag=True, help="Run nothing; write tables and plot of the members that are done."
)
@click.option("--only", multiple=True, metavar="MEMBER", help="Run only this member; may be given several times.")
@take_jobs
@outlive_output
def error_vs_time(name: str, output: Path | None, dry: bool, only_done: bool, only: tuple[str, ...], jobs: int) -> None:
    """Run the members of STUDY that are not done, and tabulate error against run time."""
    from fbcouple.results.tables import describe_machine, show_cell, write_page, write_tables
    from fbcouple.study.error_vs_time import plan_members, run_members, tabulate
    from fbcouple.study.picture import draw
    from fbcouple.study.schema import Study
    from fbcouple.study.source import read_study

    loaded, source = read_study(name, Study)
    if dry:
        members = plan_members(loaded, source)
        print_table(["member", "knobs"], [(m.name, str(m.knobs)) for m in members])
        return
    folder = choose_folder(name, output)
    done = run_members(loaded, source, folder, click.echo, () if only_done else only or None, jobs)
    rows, knobs = tabulate(loaded, done)
    tables = {"members": rows, "knobs": knobs}
    files = write_tables(folder, "study", tables, {"title": loaded.title, "machine": describe_machine()})
    picture = draw(rows, list(done[0].member.knobs), loaded.title, folder / "study.png")
    page = write_page(
        folder / "study.html", loaded.title, describe_machine(), [picture], tables, lambda row: bool(row.get("pareto"))
    )
    columns = ["measure", "member", "error", "stderr", "core_seconds_per_second", "pareto", "over_cheapest"]
    print_table(columns, [[show_cell(row[column]) for column in columns] for row in rows])
    for text in dict.fromkeys(f"{row['measure']}, {row['member']}: {row['why']}" for row in rows if row["why"]):
        click.echo(text, err=True)
    columns = ["measure", "knob", "points", "order", "slope", "gain", "price"]
    print_table(columns, [[show_cell(row[column]) for column in columns] for row in knobs])
    for file in (*files, picture, page):
        click.echo(str(file))


@study.command()
@click.argument("name", metavar="STUDY")
@take_output
@click.option("--dry", is_flag=True, help="Only list the cases.")
@take_jobs
@outlive_output
def stability(name: str, output: Path | None, dry: bool, jobs: int) -> None:
    """Run the stiff and extreme cases of STUDY that are not done, and tabulate which exchange scheme is stable."""
    from fbcouple.results.tables import describe_machine, show_cell, write_page, write_tables
    from fbcouple.study.indicators import list_limits
    from fbcouple.study.map import draw_map
    from fbcouple.study.scenes import list_scenes
    from fbcouple.study.schema import Stability
    from fbcouple.study.source import read_study
    from fbcouple.study.stability import confuse, find_limits, run_scenes

    loaded, source = read_study(name, Stability)
    if dry:
        scenes = list_scenes(loaded, source)
        print_table(["scene", "end [s]"], [(scene.name, f"{scene.settings['end_time']:.4g}") for scene in scenes])
        return
    folder = choose_folder(name, output)
    rows = run_scenes(loaded, source, folder, click.echo, jobs)
    tables = {
        "scenes": rows,
        "confusion": confuse(rows),
        "limits": find_limits(rows),
        "indicators": list(list_limits()),
    }
    files = write_tables(folder, "stability", tables, {"title": loaded.title, "machine": describe_machine()})
    picture = draw_map(rows, loaded.title, folder / "stability.png")
    page = write_page(folder / "stability.html", loaded.title, describe_machine(), [picture], tables)
    for table in ("confusion", "limits"):
        if tables[table]:
            print_table(tables[table][0], [[show_cell(cell) for cell in row.values()] for row in tables[table]])
    for file in (*files, picture, page):
        click.echo(str(file))
