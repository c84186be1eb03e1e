"""What a person sees while a run goes on, and the table of where the time went at its end."""

from __future__ import annotations

import math
import time
from types import TracebackType
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

_LINE_EVERY = 15.0


class RunProgress:
    """A progress bar on a terminal, a line now and then elsewhere; give it each history row."""

    def __init__(self, console: Console, end: float) -> None:
        self._console = console
        self._end = end
        self._said = time.monotonic()
        self._first: tuple[float, float] | None = None
        self._walls: dict[str, float] = {}
        self._at_outlet = 0
        self._bar = Progress(
            TextColumn("t = {task.completed:.3f} s of {task.total:g}"),
            BarColumn(),
            TextColumn("{task.fields[state]}"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(elapsed_when_finished=False),
            console=console,
            disable=not console.is_terminal,
        )
        self._task = self._bar.add_task("run", total=end, state="starting the solvers")

    def __enter__(self) -> RunProgress:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()

    def show(self, row: dict[str, Any]) -> None:
        """Show a history row."""
        for stage, seconds in row["wall"].items():
            self._walls[stage] = self._walls.get(stage, 0.0) + seconds
        now = time.monotonic()
        if self._first is None:  # a resumed run does not start at 0
            self._first = row["time"], now
            self._bar.reset(self._task, completed=row["time"])
        self._at_outlet = max(self._at_outlet, row.get("particles_at_outlet", 0))
        state = self._describe(row, now)
        self._bar.update(self._task, completed=row["time"], state=state)
        if not self._console.is_terminal and now - self._said > _LINE_EVERY:
            self._said = now
            self._console.print(f"t = {row['time']:.3f} s of {self._end:g}, {state}", highlight=False)

    def _describe(self, row: dict[str, Any], now: float) -> str:
        assert self._first is not None
        parts = []
        simulated = row["time"] - self._first[0]
        if simulated > 0:
            parts.append(f"{(now - self._first[1]) / simulated:.0f} s wall per s")
        if "bed_height" in row:
            parts.append(f"bed {1e3 * row['bed_height']:.1f} mm")
        if math.isfinite(row.get("pressure_drop", math.nan)):
            parts.append(f"dp {row['pressure_drop']:.0f} Pa")
        if row.get("particles_at_outlet"):
            parts.append(f"{row['particles_at_outlet']} at the outlet")
        return ", ".join(parts)

    def list_warnings(self) -> list[str]:
        """What the rows shown tell that the run goes on with and a person has to know."""
        if not self._at_outlet:
            return []
        text = "reached the outlet, which lets gas through and is a wall for particles: they gather below it"
        return [f"up to {self._at_outlet} particles {text}; use a higher region or less gas"]

    def tabulate(self) -> Table:
        """Wall seconds of the slowest rank by stage, and their shares."""
        total = sum(self._walls.values()) or 1.0
        table = Table(title="where the time went (slowest rank)", box=None, title_justify="left")
        table.add_column("stage")
        table.add_column("seconds", justify="right")
        table.add_column("share", justify="right")
        for stage, seconds in self._walls.items():
            table.add_row(stage, f"{seconds:.1f}", f"{100 * seconds / total:.1f} %")
        outside = total - self._walls.get("dem", 0.0) - self._walls.get("cfd", 0.0)
        table.add_row("not in a solver", f"{outside:.1f}", f"{100 * outside / total:.1f} %")
        return table
