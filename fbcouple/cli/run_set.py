"""`fbcouple run` on a folder of runs: all of them side by side, with one table of how far they are."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

import click
from rich.console import Console
from rich.live import Live

from fbcouple.cli.status import make_table, summarise
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.launchers import tell_crowd

if TYPE_CHECKING:
    from fbcouple.batch.side_by_side import Ended

_REDRAW_EVERY = 2.0
_LINE_EVERY = 60.0


def run_set(folder: Path, jobs: int, ranks: int, options: Sequence[str], requests: Requests, wall_limit: float) -> None:
    """Run what is not complete in `folder`, `jobs` runs at a time on `ranks` ranks each, with `options`, and stop all
    with checkpoints before `wall_limit` [s] is over.

    Raises: as `fbcouple.batch.side_by_side.require_done`.
    """
    from fbcouple.batch.folders import find_runs
    from fbcouple.batch.side_by_side import require_done, run_all

    runs, console = find_runs(folder, partial(click.echo, err=True)), Console()
    if crowd := tell_crowd(ranks, min(jobs, len(runs))):
        click.echo(f"{folder}: warning: {crowd}")
    told = 0
    with _show(console, runs) as redraw:

        def watch(running: list[Path], ended: list[Ended]) -> None:
            nonlocal told
            for one in ended[told:]:
                console.print(f"{one.run}: {one.words}", highlight=False, soft_wrap=True, markup=False)
            told = len(ended)
            redraw()

        ended = run_all(runs, jobs, ["-n", str(ranks), *options], requests, watch, wall_limit)
    kept = ["--trust"] if "--trust" in options else []
    command = " ".join(["fbcouple run", quote(str(folder)), "-j", str(jobs), "-n", str(ranks), *kept])
    require_done(runs, ended, f"`{command}`")
    click.echo(f"{folder}: all {len(runs)} runs are complete")


@contextmanager
def _show(console: Console, runs: list[Path]) -> Iterator[Callable[[], None]]:
    """Gives what shows, if it is time, a table of all runs on a terminal, elsewhere a line."""
    shown = time.monotonic()

    def show(every: float, draw: Callable[[], object]) -> None:
        nonlocal shown
        if time.monotonic() - shown >= every:
            draw()
            shown = time.monotonic()

    if console.is_terminal:
        with Live(make_table(runs), console=console, auto_refresh=False) as live:
            yield lambda: show(_REDRAW_EVERY, lambda: live.update(make_table(runs), refresh=True))
            live.update(make_table(runs), refresh=True)
    else:
        yield lambda: show(_LINE_EVERY, lambda: console.print(summarise(runs), highlight=False, soft_wrap=True))
