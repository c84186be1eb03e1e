"""`fbcouple options`: what a case file can say."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

import dataclasses
import json

import click
from click.shell_completion import CompletionItem

from fbcouple.cli.table import print_table
from fbcouple.errors import CaseError


def complete_name(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Sections and dotted keys that begin with `incomplete`."""
    from fbcouple.case.schema.reference import list_names

    return [CompletionItem(name) for name in list_names() if name.startswith(incomplete)]


@click.command()
@click.argument("name", metavar="[SECTION|KEY]", required=False, default="", shell_complete=complete_name)
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
@click.option("--schema", "as_schema", is_flag=True, help="Print a JSON schema of the case file, for editors.")
def options(name: str, as_json: bool, as_schema: bool) -> None:
    """List the options of a case file: type, range, unit, default and meaning of each.

    SECTION is a table of the case file, as gas; KEY is one option, as gas.density or density.

    Editors with Taplo check a case file that begins with `#:schema ./fbcouple.schema.json`; write that file with
    `fbcouple options --schema > fbcouple.schema.json`.
    """
    from fbcouple.case.problems import show, write_hint
    from fbcouple.case.schema.json_schema import build_schema
    from fbcouple.case.schema.reference import find_options, list_names

    if as_schema:
        if name or as_json:
            raise click.UsageError("--schema is of the whole case file: give it alone")
        click.echo(json.dumps(build_schema(), indent=2))
        return
    found = find_options(name)
    if not found:
        hint = write_hint(name, list_names(), "`fbcouple options` lists all")
        raise CaseError([f"{show(name)}: no section or key of a case file{hint}."])
    if as_json:
        click.echo(json.dumps([dataclasses.asdict(option) for option in found], indent=2))
        return
    rows = []
    for option in found:
        unit = "" if option.unit == "1" else option.unit
        default = "required" if option.required else "none" if option.default is None else show(option.default)
        rows.append((option.key, option.allowed, unit, default, option.sentence))
    print_table(["key", "allowed", "unit", "default", "meaning"], rows)
