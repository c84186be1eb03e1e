"""Tables on the terminal."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console
from rich.table import Table
from rich.text import Text

NARROWEST_PIPE = 150


class TableConsole(Console):
    """A console that leaves it to the command what a reader that went away means."""

    def on_broken_pipe(self) -> None:
        """Raise the BrokenPipeError that led here."""
        raise  # noqa: PLE0704


def print_table(columns: Iterable[str], rows: Iterable[Iterable[str | Text]]) -> None:
    """Print a table; piped output is wide enough for a row a line in most cases."""
    console = TableConsole(soft_wrap=False)
    if not console.is_terminal:
        console = TableConsole(width=NARROWEST_PIPE)
    table = Table(box=None, pad_edge=False)
    for column in columns:
        table.add_column(column, overflow="fold")
    for row in rows:
        table.add_row(*(cell if isinstance(cell, Text) else Text(cell) for cell in row))
    console.print(table)


def format_verdict(is_ok: bool) -> Text:
    """A green or a red cell."""
    return Text("ok", style="green") if is_ok else Text("NOT OK", style="bold red")
