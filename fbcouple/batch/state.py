"""How far a run has come, seen from outside, also while it goes on or where a batch job runs it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fbcouple.api import Run
from fbcouple.errors import CaseError
from fbcouple.run_folder.lock import find_holder
from fbcouple.run_folder.manifest import read_manifest

_RECENT = 20
"""Last rows of the history that the speed is taken of."""


@dataclass(frozen=True)
class RunState:
    """`state` as `fbcouple.Run.status` has it, `damaged` also of a folder that cannot be read; times in s; `left` and
    `pace` are nan where nothing tells them."""

    run: Path
    state: str
    time: float
    end_time: float
    wall: float
    """Wall time of all steps so far."""
    pace: float
    """Wall time a simulated second, of late."""
    ranks: int
    where: str
    """Host and process that run it now."""
    message: str
    """Why it ended early or failed, what is damaged, or that its start-up was not over at its end."""

    @property
    def left(self) -> float:
        """Wall time to its end at the pace of late; nan if it is not under way."""
        return self.pace * (self.end_time - self.time) if self.state == "running" else math.nan


def look_at(run: Path) -> RunState:
    """The state of the run in `run`. Raises: CaseError if it is no run folder."""
    found = Run(run)
    rows = found.history()
    status = found.status(rows)
    holder = find_holder(run) if status.state == "running" else None
    started = read_manifest(run).get("run", {})
    return RunState(
        run,
        status.state,
        status.time,
        status.end_time,
        sum(map(_sum_stages, rows)),
        _find_pace(rows),
        int(started.get("ranks", 0)) if isinstance(started, dict) else 0,
        f"{holder['host']}, process {holder['pid']}" if holder else "",
        status.message or ("" if holder else _tell_start_up(rows)),
    )


def look_at_all(runs: Sequence[Path]) -> list[RunState]:
    """The state of each run. One of several that cannot be read is `damaged`, and its message says why.

    Raises: CaseError if the only one cannot be read.
    """
    return [look_at(runs[0])] if len(runs) == 1 else list(map(_try_look, runs))


def _try_look(run: Path) -> RunState:
    try:
        return look_at(run)
    except CaseError as error:
        return RunState(run, "damaged", math.nan, math.nan, 0.0, math.nan, 0, "", str(error))


def _tell_start_up(rows: list[dict[str, Any]]) -> str:
    """Of a run that looks for the end of its start-up, that it is not over."""
    return "start-up not over" if rows and math.isnan(rows[-1].get("averages_start", 0.0)) else ""


def _sum_stages(row: dict[str, Any]) -> float:
    return float(sum(row["wall"].values()))


def _find_pace(rows: list[dict[str, Any]]) -> float:
    recent = rows[-_RECENT - 1 :]
    if len(recent) < 2 or recent[-1]["time"] <= recent[0]["time"]:
        return math.nan
    return sum(map(_sum_stages, recent[1:])) / float(recent[-1]["time"] - recent[0]["time"])
