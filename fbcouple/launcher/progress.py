"""What a person sees while a run goes on, and the table of where the time went at its end."""

from __future__ import annotations

import math
import time
from types import TracebackType
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Column, Table

_LINE_EVERY = 15.0
_BACKFLOW = 0.01
"""Part of the gas at the outlets above which it is told that it comes back in."""
_BAR = 8
"""Columns of the shortest bar."""
_SPACES = 4
"""Columns between the parts of the line."""


class RunProgress:
    """A progress bar on a terminal, a line now and then elsewhere; give it each history row."""

    def __init__(self, console: Console, end: float) -> None:
        self._console = console
        self._end = end
        self._said = time.monotonic()
        self._first: tuple[float, float] | None = None
        self._walls: dict[str, float] = {}
        self._last = 0.0
        self._before: dict[str, float] = {}
        self._at_outlet = self._owed = 0
        self._backflow, self._worst = 0.0, 0
        self._begin: float | None = None
        self._bar = Progress(
            TextColumn("{task.fields[reached]}", table_column=Column(no_wrap=True)),
            BarColumn(None, table_column=Column(ratio=1, min_width=_BAR)),
            TextColumn("{task.fields[state]}", table_column=Column(no_wrap=True)),
            TextColumn("{task.fields[clock]}", table_column=Column(no_wrap=True)),
            console=console,
            disable=not (console.is_terminal or console.is_jupyter),
            expand=True,
        )
        reached = self._format_reached(0.0)
        self._task = self._bar.add_task("run", total=end, reached=reached, state="starting the solvers", clock="")

    def __enter__(self) -> RunProgress:
        return self

    def start(self) -> None:
        """Show the bar: from now on the run is under way."""
        self._bar.start()

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
            self._before = dict(self._walls)
            self._bar.reset(self._task, completed=row["time"])
        self._last = row["time"]
        self._at_outlet = max(self._at_outlet, row.get("particles_at_outlet", 0))
        self._owed = row.get("particles_owed", 0)
        if (backflow := row.get("gas_backflow", 0.0)) > self._backflow:
            parts = row.get("outlet_backflow", [])
            self._backflow, self._worst = backflow, parts.index(max(parts)) + 1 if parts else 0
        self._begin = row.get("averages_start")
        start, began = self._first
        pace = (now - began) / (row["time"] - start) if row["time"] > start else math.nan
        left = "" if math.isnan(pace) else f"left {format_clock(pace * (self._find_end(row) - row['time']))}"
        reached, parts = self._format_reached(row["time"]), _describe(row, pace)
        if self._console.is_terminal:
            clock = f"{format_clock(now - began)} {left}".rstrip()
            state = _choose_parts(parts, self._console.width - len(reached) - len(clock) - _BAR - _SPACES)
            self._bar.update(self._task, completed=row["time"], reached=reached, state=state, clock=clock)
        elif now - self._said > _LINE_EVERY:
            self._said = now
            self._console.print(
                ", ".join([reached, *parts, *([left] if left else [])]), highlight=False, soft_wrap=True
            )

    def _find_end(self, row: dict[str, Any]) -> float:
        """When the run is expected to end [s]: before its limit where its means are sure enough by then."""
        expected = row.get("expected_end", math.nan)
        return self._end if math.isnan(expected) else min(max(expected, row["time"]), self._end)

    def _format_reached(self, time: float) -> str:
        return f"t = {time:.3f} s of {self._end:g}"

    def list_warnings(self) -> list[str]:
        """What the rows shown tell that the run goes on with and a person has to know."""
        warnings = []
        if self._at_outlet:
            text = "reached the outlet, which lets gas through and is a wall for particles: they gather below it"
            warnings.append(f"up to {self._at_outlet:.10g} particles {text}; use a higher region or less gas")
        if self._backflow > _BACKFLOW:
            where = f", most of it by outlet {self._worst}" if self._worst else ""
            text = f"of the gas at the outlets came back in by them{where}, with the voidage of the cells there"
            mend = "move them further from the bed, or see gas_backflow in the report"
            warnings.append(f"up to {100.0 * self._backflow:.3g} % {text}; {mend}")
        if self._begin is not None and math.isnan(self._begin):
            text = "the start-up is not seen to be over; the means begin where maps and histories drift least"
            warnings.append(f"{text}: let it run longer, or see start-up in the report")
        if self._owed:
            text = "particles wait to be fed and find no free place"
            warnings.append(
                f"{self._owed} {text}; enlarge the box of the feed, have them leave it faster, or feed less"
            )
        return warnings

    def sum_up(self) -> tuple[float, dict[str, float]]:
        """Simulated time [s] from the first row shown to the last, and the wall seconds of each stage in it."""
        seconds = self._last - self._first[0] if self._first else 0.0
        return seconds, {stage: wall - self._before.get(stage, 0.0) for stage, wall in self._walls.items()}

    def format_begin(self) -> str:
        """For the last line of a run that found the end of its start-up: from when on its means are; or nothing."""
        if self._begin is None or math.isnan(self._begin):
            return ""
        return f"; its start-up ended at t = {self._begin:.4g} s, where its means begin"

    def tabulate(self) -> Table | None:
        """Wall seconds of the slowest rank by stage, and their shares; None where no step was taken."""
        total = sum(self._walls.values())
        if not total > 0.0:
            return None
        table = Table(title="where the time went (slowest rank)", box=None, title_justify="left")
        table.add_column("stage")
        table.add_column("seconds", justify="right")
        table.add_column("share", justify="right")
        for stage, seconds in self._walls.items():
            table.add_row(stage, f"{seconds:.1f}", f"{100 * seconds / total:.1f} %")
        outside = total - self._walls.get("dem", 0.0) - self._walls.get("cfd", 0.0)
        table.add_row("of which not in a solver", f"{outside:.1f}", f"{100 * outside / total:.1f} %")
        return table


def format_clock(seconds: float) -> str:
    """Wall time as H:MM:SS, with days where it is longer than one."""
    whole = max(round(seconds), 0)
    days, rest = divmod(whole, 86_400)
    clock = f"{rest // 3600}:{rest % 3600 // 60:02d}:{rest % 60:02d}"
    return f"{days} d {clock}" if days else clock


def _describe(row: dict[str, Any], pace: float) -> list[str]:
    """What is told of a row beside its time, the most important first; `pace`: wall time over simulated time."""
    parts = [f"{row['particles_at_outlet']:.10g} at the outlet"] if row.get("particles_at_outlet") else []
    parts += [f"{row['particles_owed']:.10g} wait to be fed"] if row.get("particles_owed") else []
    if math.isnan(row.get("averages_start", 0.0)):
        parts.append("start-up not over")
    if math.isfinite(row.get("averages_error", math.nan)):
        parts.append(f"error {100.0 * row['averages_error']:.3g} %")
    if math.isfinite(pace):
        parts.append(f"{pace:.0f} s wall per s")
    if math.isfinite(row.get("pressure_drop", math.nan)):
        parts.append(f"dp {row['pressure_drop']:.0f} Pa")
    if "bed_height" in row:
        parts.append(f"bed {1e3 * row['bed_height']:.1f} mm")
    return parts


def _choose_parts(parts: list[str], room: int) -> str:
    """As many of `parts` as fit into `room` columns, so that the clocks after them are never cut."""
    text = ""
    for part in parts:
        longer = f"{text}, {part}" if text else part
        if len(longer) > room:
            break
        text = longer
    return text
