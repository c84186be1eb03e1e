"""One run at a time in a folder: the lock of a run folder, which a process that dies does not leave behind.

On one host the system frees the lock of a dead process. What another host left, and anything on a file system without
locks, is judged by its heartbeat: the parent's on the lock itself, the ranks' on the pulse.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import platform
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from fbcouple.errors import BusyError, SolverError
from fbcouple.machine.environment import is_in_mpi_job
from fbcouple.paths import HEARTBEAT
from fbcouple.run_folder.plain_files import format_moved, is_same

NAME = "lock"
STALE_AFTER = 120.0
"""Wall time [s] without a heartbeat after which the holder is taken for dead, where the system cannot tell."""
NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)
"""What a file system without locks answers: NFS without its lock daemon, Lustre mounted without `flock`, ..."""
_SETTLE = 1.0
"""Wall time [s] after which a claim that nobody has written over is ours, where there are no locks."""
_SKEW = 5.0
Holder = dict[str, Any]
Say = Callable[[str], None]


class Lock:
    """The lock of `run` while this process holds it; `number` is its file, which a job that inherits it holds on."""

    def __init__(self, run: Path, file: Any) -> None:
        self.number: int = file.fileno()
        self._run, self._file = run, file
        self._holder = {"host": platform.node(), "pid": os.getpid(), "token": uuid.uuid4().hex}
        self._beaten = time.monotonic()

    def claim(self) -> None:
        """Write down who holds it."""
        self._file.truncate(0)
        self._file.write(json.dumps(self._holder).encode())

    @property
    def is_ours(self) -> bool:
        """Is what stands in it still this process's claim?"""
        return _read(self._file) == self._holder

    def beat(self) -> None:
        """Tell other hosts that the holder is alive.

        Raises SolverError if the folder or the lock is gone, if another run has it, or if it could not be told for
        half the time after which others take the holder for dead.
        """
        try:
            if not (self._run / NAME).exists() and not (self._run / "logs").exists():
                raise SolverError(format_moved(self._run))
            if not (is_same(self._run / NAME, self.number) and (self._run / "logs").is_dir()):
                gone = self._run / (NAME if (self._run / "logs").is_dir() else "logs")
                text = f"{gone}: was removed or replaced while a run was under way, which has ended"
                raise SolverError(f"{text}; --resume goes on")
            if not self.is_ours:
                raise SolverError(f"{self._run}/{NAME}: was taken{_format_holder(_read(self._file))}")
            os.utime(self.number)
            self._beaten = time.monotonic()
        except OSError as error:
            if time.monotonic() - self._beaten > STALE_AFTER / 2:
                raise SolverError(f"{self._run}/{NAME}: cannot be written any more: {error}") from error

    def free(self) -> None:
        """Leave an empty file; where that cannot be written, or another run has it, it is left as it is."""
        with suppress(OSError):
            if self.is_ours:
                self._file.truncate(0)


@contextmanager
def hold(run: Path, say: Say = lambda text: None) -> Iterator[Lock]:
    """Hold the lock of `run`; `say` is told where the file system has no locks.

    Raises BusyError if another run has the folder, SolverError if the lock cannot be written.
    """
    try:
        file = (run / NAME).open("a+b", buffering=0)
    except OSError as error:
        raise SolverError(f"{run}: cannot be written: {error}") from error
    with file:
        lock = Lock(run, file)
        try:
            _take(run, file, lock, say)
        except OSError as error:
            raise SolverError(f"{run}: cannot be written: {error}") from error
        try:
            yield lock
        finally:
            lock.free()


def find_holder(run: Path) -> Holder | None:
    """Host and process that stand in the lock of `run`; None if nobody does."""
    try:
        with (run / NAME).open("rb") as file:
            return _read(file)
    except FileNotFoundError:
        return None


def is_held(run: Path) -> bool:
    """Is a run under way in `run`, as far as can be seen from here?"""
    path = run / NAME
    try:
        with path.open("rb") as file:
            holder = _read(file)
            try:
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except BlockingIOError:
                return True
            except OSError as error:
                if error.errno not in NO_LOCKS:
                    raise
            beats = [beat.stat().st_mtime for beat in (path, run / HEARTBEAT) if beat.exists()]
            here = holder is not None and holder["host"] == platform.node()
            return holder is not None and not here and time.time() - max(beats) < STALE_AFTER
    except FileNotFoundError:
        return False


def _take(run: Path, file: Any, lock: Lock, say: Say) -> None:
    """Raise BusyError unless this process can have the lock."""
    holder = _read(file)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        locked = True
    except BlockingIOError:
        raise BusyError([_word(run, holder)]) from None
    except OSError as error:
        if error.errno not in NO_LOCKS:
            raise
        locked = False
        say(f"{run}: no file locks here ({error.strerror}): two runs in it are told apart by their heartbeats")
    if holder and not (locked and holder["host"] == platform.node()):
        age = _find_age(run)
        if age < STALE_AFTER:
            raise BusyError([_word(run, holder, age)])
    lock.claim()
    if not locked:
        time.sleep(_SETTLE)
        if not lock.is_ours:
            raise BusyError([_word(run, _read(file))])


def _read(file: Any) -> Holder | None:
    """Who stands in the lock; what is not written as this program does it is nobody."""
    file.seek(0)
    try:
        found = json.loads(file.read())
    except ValueError:
        return None
    named = isinstance(found, dict) and isinstance(found.get("host"), str) and isinstance(found.get("pid"), int)
    return found if named else None


def _find_age(run: Path) -> float:
    """Seconds since the last heartbeat of parent or ranks, by the clock of the file system."""
    probe = run / f".{NAME}-probe"
    probe.touch()
    now = probe.stat().st_mtime
    probe.unlink()
    beats = [path.stat().st_mtime for path in (run / NAME, run / HEARTBEAT) if path.exists()]
    return now - max(beats)


def _word(run: Path, holder: Holder | None, age: float | None = None) -> str:
    text = f"{run}: another run is under way in it{_format_holder(holder)}"
    if age is not None and age < -_SKEW:
        text += f"; its heartbeat is {-age:.0f} s in the future, so a clock was set back; if it is over, remove {NAME}"
    elif age is not None:
        text += f"; its heartbeat is {max(age, 0.0):.0f} s old, and it counts as dead from {STALE_AFTER:g} s on"
    hint = "; the ranks are started by `fbcouple run -n RANKS`, not by mpirun or srun" if is_in_mpi_job() else ""
    return f"{text}; wait for its end, or set up another folder{hint}"


def _format_holder(holder: Holder | None) -> str:
    return f" (process {holder['pid']} on {holder['host']})" if holder else ""
