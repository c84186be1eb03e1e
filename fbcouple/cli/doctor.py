"""`fbcouple doctor`: whether a run can work here, and the archive for a bug report."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

from pathlib import Path

import click

from fbcouple.cli.table import format_verdict, print_table
from fbcouple.errors import SolverError
from fbcouple.run_folder.plain_files import require_plain

RECIPES = ("apptainer", "docker", "spack", "modules")
"""As `fbcouple.doctor.recipe` has them, which loads templates."""


@click.command()
@click.option("--fix", "fixes", is_flag=True, help="First repair what needs no package manager.")
@click.option("--bundle", "bundles", is_flag=True, help="Write an archive for a bug report, with RUN if one is given.")
@click.option("--recipe", type=click.Choice(RECIPES), help="Print what installs fbcouple there, and nothing else.")
@click.argument("run", required=False, type=click.Path(path_type=Path))
def doctor(fixes: bool, bundles: bool, recipe: str | None, run: Path | None) -> None:
    """Check the installation and how to repair it; exit code 0 only if a run can work.

    With --bundle, write versions, and of RUN the case, decks, manifest and logs, to an archive without secrets.
    """
    if recipe:
        from fbcouple.doctor.recipe import write_recipe

        if fixes or bundles or run:
            raise click.UsageError("--recipe stands alone")
        click.echo(write_recipe(recipe), nl=False)
        return
    if run and not bundles:
        raise click.UsageError("RUN goes into the archive of --bundle")
    if run:
        require_plain(run)
    from fbcouple.doctor import checks as examination

    if fixes:
        examination.fix()
    rows = examination.examine()
    columns = ["what", "found", "wanted", "", "fix"]
    print_table(
        columns, [(row.name, row.found, row.wanted, format_verdict(row.ok), "" if row.ok else row.mend) for row in rows]
    )
    if bundles:
        from fbcouple.doctor.bundle import write_bundle

        click.echo(f"{write_bundle(rows, run, Path())}: look through it, then attach it to the report")
    broken = [row.name for row in rows if not row.ok]
    if broken:
        raise SolverError(f"a run cannot work yet: {', '.join(broken)}")
