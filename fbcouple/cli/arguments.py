"""Arguments and options that several commands take, each declared once."""

# ruff: noqa: PLC0415  (what is not always needed is loaded only then)

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

Command = Callable[..., Any]
JSON_ELSEWHERE = "give another file with --json"


def read_clock(ctx: click.Context, parameter: click.Parameter, value: str | None) -> int | None:
    """Seconds of a time given as HH:MM:SS; None of none."""
    if value is None:
        return None
    parts = value.split(":")
    if len(parts) != 3 or not all(part.isascii() and part.isdigit() and len(part) <= 4 for part in parts):
        raise click.BadParameter("write it as HH:MM:SS")
    hours, minutes, seconds = map(int, parts)
    if minutes > 59 or seconds > 59 or hours + minutes + seconds == 0:
        raise click.BadParameter("minutes and seconds go to 59, and the limit is above 0")
    return 3600 * hours + 60 * minutes + seconds


def complete_case(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Shipped cases that begin with `incomplete`; the shell adds files where there is none."""
    from fbcouple.case.source import list_shipped

    names = [name for name in list_shipped() if name.startswith(incomplete)]
    # The item for files goes first: the shell clears its list when it meets it.
    return [CompletionItem(incomplete, type="file"), *map(CompletionItem, names)]


def complete_case_or_set(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """As `complete_case`, with the sets of cases that `setup` takes."""
    from fbcouple.case.source import list_sets

    sets = [CompletionItem(name) for name in list_sets() if name.startswith(incomplete)]
    return [*complete_case(ctx, parameter, incomplete), *sets]


def require_place(ctx: click.Context, parameter: click.Parameter, value: Path | None) -> Path | None:
    """A file that can be written, asked before the work whose result goes into it."""
    from fbcouple.machine.whole_files import require_writable

    if value is not None and not ctx.resilient_parsing:
        require_writable(value, f"give another file with {parameter.opts[-1]}")
    return value


def require_json(ctx: click.Context, parameter: click.Parameter, value: Path | None) -> Path | None:
    """As `require_place`, of a name that says what is in it: no results or case are replaced by a slip."""
    if value is not None and not ctx.resilient_parsing and value.suffix.lower() != ".json":
        text = f"{value} is given, a name that ends in .json is allowed; add it."
        raise click.BadParameter(text, ctx=ctx, param=parameter)
    return require_place(ctx, parameter, value)


take_case = click.argument("case", shell_complete=complete_case)
take_case_or_set = click.argument("case", shell_complete=complete_case_or_set)
take_ranks = click.option("-n", "--ranks", type=click.IntRange(min=1), default=1, show_default=True, help="MPI ranks.")
take_json = click.option(
    "--json",
    "file",
    type=click.Path(path_type=Path, dir_okay=False),
    callback=require_json,
    help="Write the tables to FILE.json.",
)
take_ranks_or_none = click.option(
    "-n", "--ranks", type=click.IntRange(min=1), help="MPI ranks; by default those that `check` proposes."
)


def take_settings(command: Command) -> Command:
    """Add `--set key.path=value`, which may be given several times."""
    text = "Put a value on top of the case file, as particles.mass=0.125; may be given several times."
    return click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help=text)(command)


def take_trust(command: Command) -> Command:
    """Add `--trust`, without which no code that a case brings is run."""
    text = "Run the code that the case brings (its own laws and tasks), and decks that were changed; read them first."
    return click.option("--trust", "trusted", is_flag=True, help=text)(command)
