"""One run at a time in a folder: the lock of a run folder, which a process that dies does not leave behind."""

from __future__ import annotations

import fcntl
import json
import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fbcouple.errors import CaseError, SolverError
from fbcouple.run_folder import is_same, word_moved

NAME = "lock"
STALE_AFTER = 120.0
"""Wall time [s] without a heartbeat after which the holder on another host is taken for dead."""


@contextmanager
def hold(run: Path) -> Iterator[int]:
    """Hold the lock of `run`; yields its file number, which a job that inherits it goes on holding.

    On one host the system frees the lock of a dead process; what another host left is judged by its heartbeat.
    Raises CaseError if another run has the folder, SolverError if the lock cannot be written.
    """
    try:
        file = (run / NAME).open("a+b", buffering=0)
    except OSError as error:
        raise SolverError(f"{run}: cannot be written: {error}") from error
    with file:
        holder = _read(file)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise CaseError([_word(run, holder)]) from None
        if holder and holder["host"] != platform.node() and _find_age(run) < STALE_AFTER:
            raise CaseError([_word(run, holder)])
        try:
            file.truncate(0)
            file.write(json.dumps({"host": platform.node(), "pid": os.getpid()}).encode())
        except OSError as error:
            raise SolverError(f"{run}: cannot be written: {error}") from error
        try:
            yield file.fileno()
        finally:
            file.truncate(0)


def beat(run: Path, lock: int) -> None:
    """Tell other hosts that the holder is alive; `lock` is what `hold` gave.

    Raises SolverError if the folder, or the lock or the logs in it, are not there any more: without its lock two runs
    could be in one folder.
    """
    os.utime(lock)
    if is_same(run / NAME, lock) and (run / "logs").is_dir():
        return
    if not (run / NAME).exists() and not (run / "logs").exists():
        raise SolverError(word_moved(run))
    gone = run / (NAME if (run / "logs").is_dir() else "logs")
    raise SolverError(f"{gone}: was removed or replaced while a run was under way, which has ended; --resume goes on")


def _read(file: Any) -> dict[str, Any] | None:
    file.seek(0)
    try:
        return json.loads(file.read())
    except ValueError:
        return None


def _find_age(run: Path) -> float:
    """Seconds since the last heartbeat, by the clock of the file system."""
    probe = run / f".{NAME}-probe"
    probe.touch()
    age = probe.stat().st_mtime - (run / NAME).stat().st_mtime
    probe.unlink()
    return age


def _word(run: Path, holder: dict[str, Any] | None) -> str:
    who = f" (process {holder['pid']} on {holder['host']})" if holder else ""
    return f"{run}: another run is under way in it{who}; wait for its end, or set up another folder"
