"""Measurements on a machine that does other things too: what those took is told, and turns are taken until they agree.

Whatever disturbs a measurement makes it longer, so the cheapest of several counts; how far the next one lies above it
says how sure it is.
"""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

AGREED = 0.03
"""Next cheapest over the cheapest, less 1, from which on no further turn is taken."""
QUIET = 0.1
"""Cores of others while something is measured, above which its times are too long to be trusted."""
OTHERS = "others_cores"

Row = dict[str, Any]


def take_turns(turn: Callable[[], dict[str, Row]], number: Callable[[Row], float], turns: int) -> dict[str, Row]:
    """The cheapest row of each name by its `number`, with its `turns` and the `spread` to the next cheapest.

    turn: measures all names, one after the other, so that what a busy machine does to one it does to the others. Turns
    end when the two cheapest of every name agree within `AGREED`, or after `turns` of them.
    """
    found: dict[str, list[Row]] = {}
    for taken in range(turns):
        for name, row in turn().items():
            found.setdefault(name, []).append(row)
        if taken and all(_find_spread(rows, number) <= AGREED for rows in found.values()):
            break
    return {name: min(rows, key=number) | _tell(rows, number) for name, rows in found.items()}


def _tell(rows: list[Row], number: Callable[[Row], float]) -> Row:
    return {"turns": len(rows), "spread": _find_spread(rows, number) if len(rows) > 1 else None}


def _find_spread(rows: list[Row], number: Callable[[Row], float]) -> float:
    cheapest, following = sorted(map(number, rows))[:2]
    return following / cheapest - 1.0


@contextmanager
def watch_others(row: Row) -> Iterator[None]:
    """Put into `row` the cores that others had, on the mean, while the block waited for the processes it started.

    Of the cores that this process may use: their busy time, what the host of a virtual machine takes away among it,
    less this process's own and that of its children that have ended. Nothing where the system does not tell it.
    """
    begin, busy, own = time.perf_counter(), _read_busy(), _read_own()
    yield
    seconds = time.perf_counter() - begin
    if busy is not None and (busy_after := _read_busy()) is not None:
        row[OTHERS] = max(busy_after - busy - (_read_own() - own), 0.0) / seconds


def _read_busy() -> float | None:
    """Busy seconds of the cores that this process may use, since the system started."""
    cores = {f"cpu{number}" for number in os.sched_getaffinity(0)}
    try:
        lines = [line.split() for line in Path("/proc/stat").read_text(encoding="ascii").splitlines()]
    except OSError:
        return None
    ticks = 0
    for name, *counts in lines:
        if name in cores:
            user, nice, system, _idle, _wait, interrupts, soft, stolen = map(int, counts[:8])
            ticks += user + nice + system + interrupts + soft + stolen
    return ticks / os.sysconf("SC_CLK_TCK")


def _read_own() -> float:
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


def warn_of_others(rows: list[Row]) -> str:
    """What to say below a table whose rows were disturbed; empty where the machine was quiet."""
    most = max((row.get(OTHERS) or 0.0 for row in rows), default=0.0)
    if most <= QUIET:
        return ""
    cores = len(os.sched_getaffinity(0))
    words = f"up to {most:.2g} of {cores} cores were others' while this was measured"
    return f"{words}: its times are too long, and its ratios unsure; measure again when nothing else runs"
