"""`fbcouple status`: how far a run, or each run in a folder, has come."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from fbcouple.launcher.progress import format_clock

if TYPE_CHECKING:
    from fbcouple.batch.state import RunState

COLOURS = {"complete": "green", "running": "cyan", "failed": "bold red", "damaged": "bold red", "stopped": "yellow"}


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print a JSON list, a run an entry, times in seconds.")
def status(folder: Path, as_json: bool) -> None:
    """Tell how far the run, or each run, in FOLDER has come; it may be under way, here or in a batch job."""
    from fbcouple.batch.folders import find_runs
    from fbcouple.batch.state import look_at_all

    runs = find_runs(folder, partial(click.echo, err=True))
    if as_json:
        click.echo(json.dumps([_list_values(state) for state in look_at_all(runs)], indent=1))
        return
    console = Console()
    if not console.is_terminal:
        console.width = max(console.width, 160)
    console.print(make_table(runs))


def _list_values(state: RunState) -> dict[str, Any]:
    """What JSON can say: no path, and null for what nothing tells."""
    values = asdict(state) | {"run": str(state.run), "left": state.left}
    return {name: None if isinstance(value, float) and math.isnan(value) else value for name, value in values.items()}


def make_table(runs: list[Path]) -> Table:
    """State, time, wall time and what is left of each run."""
    from fbcouple.batch.state import look_at_all

    table = Table(box=None, pad_edge=False)
    table.add_column("run", overflow="fold")
    table.add_column("state", no_wrap=True)
    for column in ("t, s", "of", "wall", "wall s per s", "left", "ranks"):
        table.add_column(column, justify="right", no_wrap=True)
    table.add_column("", overflow="fold")
    for state in look_at_all(runs):
        table.add_row(*_write(state))
    return table


def _write(state: RunState) -> list[str | Text]:
    return [
        state.run.name,
        Text(state.state, style=COLOURS.get(state.state, "")),
        f"{state.time:.3f}" if math.isfinite(state.time) else "",
        f"{state.end_time:g}" if math.isfinite(state.end_time) else "",
        format_clock(state.wall) if state.wall else "",
        f"{state.pace:.0f}" if math.isfinite(state.pace) else "",
        format_clock(state.left) if math.isfinite(state.left) else "",
        str(state.ranks or ""),
        Text((state.message or state.where).partition("\n")[0]),
    ]


def summarise(runs: list[Path]) -> str:
    """A line: how many runs are in which state, and how far those under way are."""
    from fbcouple.batch.state import look_at_all

    states = look_at_all(runs)
    counts = Counter(state.state for state in states)
    parts = [f"{count} {name}" for name, count in counts.items()]
    parts += [_tell(state) for state in states if state.state == "running"]
    return ", ".join(parts)


def _tell(state: RunState) -> str:
    left = f", left {format_clock(state.left)}" if math.isfinite(state.left) else ""
    return f"{state.run.name} t = {state.time:.3f} s of {state.end_time:g}{left}"
