"""Tables on the terminal."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console
from rich.table import Table
from rich.text import Text

NARROWEST_PIPE = 150
NARROWEST_SENTENCE = 40
"""Letters that the sentences of a table have to have beside its numbers, or they go below it."""


class TableConsole(Console):
    """A console that leaves it to the command what a reader that went away means."""

    def on_broken_pipe(self) -> None:
        """Raise the BrokenPipeError that led here."""
        raise  # noqa: PLE0704


def print_table(columns: Iterable[str], rows: Iterable[Iterable[str | Text]]) -> None:
    """Print a table; piped output is wide enough for a row a line in most cases."""
    _open_console().print(_lay_out(list(columns), [list(row) for row in rows]))


def print_explained(columns: Iterable[str], rows: Iterable[Iterable[str | Text]]) -> None:
    """Print a table whose last column is sentences; on a narrow terminal these stand below, beside the first column."""
    console, names, cells = _open_console(), list(columns), [list(row) for row in rows]
    numbers = _lay_out(names[:-1], [row[:-1] for row in cells])
    if console.width - console.measure(numbers).maximum >= NARROWEST_SENTENCE:
        console.print(_lay_out(names, cells))
        return
    console.print(numbers)
    console.print()
    console.print(_lay_out([names[0], names[-1]], [[row[0], row[-1]] for row in cells]))


def _open_console() -> Console:
    console = TableConsole(soft_wrap=False)
    return console if console.is_terminal else TableConsole(width=NARROWEST_PIPE)


def _lay_out(columns: list[str], rows: list[list[str | Text]]) -> Table:
    table = Table(box=None, pad_edge=False)
    for column in columns:
        table.add_column(column, overflow="fold")
    for row in rows:
        table.add_row(*(cell if isinstance(cell, Text) else Text(cell) for cell in row))
    return table


def format_verdict(is_ok: bool) -> Text:
    """A green or a red cell."""
    return Text("ok", style="green") if is_ok else Text("NOT OK", style="bold red")
