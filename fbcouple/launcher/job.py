"""The MPI job of a run, as its parent sees it: started, followed, told to stop, and ended if it hangs."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from fbcouple.errors import CaseError, DivergedError, FbcoupleError, SolverError, StoppedError
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.cache import list_compiled
from fbcouple.machine.environment import missing_program, mpi_environment
from fbcouple.machine.stop_signals import LONGEST_WAIT, follow_parent
from fbcouple.paths import HEARTBEAT, LOG
from fbcouple.results.line_log import read_line
from fbcouple.run_folder.checkpoint import format_newest
from fbcouple.run_folder.failure import correct_note, give_room_back, read_failure
from fbcouple.run_folder.lock import Lock

ERRORS: dict[int, type[FbcoupleError]] = {4: DivergedError, 75: StoppedError}
PASSED_ON = signal.SIGUSR1
"""The signal that mpirun hands on to the ranks, whichever of them this process was sent."""
_PAUSE = 0.25
_LONGEST_PASS = 1.0
"""Wall time [s] of a pass of the loop that counts as waiting at most: a longer one was not given, but suspended."""
_GRACE = 5.0

Watch = Callable[[dict[str, Any]], None]
Say = Callable[[str], None]


class Job:
    """An MPI job on the run folder `run`.

    A first request to stop makes the job write a checkpoint and end; a second one ends it at once. The end of this
    process, whatever ended it, is a first request.
    """

    def __init__(
        self, command: list[str], run: Path, patience: float, lock: Lock, requests: Requests, say: Say
    ) -> None:
        """`patience` [s] of wall time without a coupling step, after which the job is taken for hanging; `lock`: of
        the run folder, which the job holds on if this process dies; `say` is told that a request was heard."""
        self._requests, self._say = requests, say
        self._command, self._run, self._patience = command, run, patience
        self._words = run / "logs/launcher.log"
        self._lock = lock
        self._seen, self._waited, self._looked = 0, 0.0, time.monotonic()

    def follow(self, watch: Watch) -> None:
        """Run the job to its end; `watch` sees each new history row.

        Raises the error that the job ended by, StoppedError among them.
        """
        log = self._run / LOG
        before = log.stat().st_size if log.exists() else 0
        with self._words.open("w", encoding="utf-8") as words:
            job = self._start(words)
            try:
                for row in self._read_rows(job, before):
                    watch(row)
            except OSError as error:
                _end(job)
                raise SolverError(f"{self._run}: cannot be followed any more: {error}; the run was ended") from error
            except BaseException:
                _end(job)
                raise
        self._lock.beat()
        self._judge(job)

    def _start(self, words: Any) -> subprocess.Popen:
        try:
            # A session of its own: Ctrl-C at the terminal is for this process, which asks the job to stop.
            return subprocess.Popen(
                self._command,
                env=mpi_environment(),
                stdout=words,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                pass_fds=(self._lock.number,),
                preexec_fn=follow_parent(signal.SIGUSR1),  # noqa: PLW1509  (no threads here)
            )
        except FileNotFoundError as error:
            raise missing_program(self._command[0], "openmpi-bin") from error

    def _judge(self, job: subprocess.Popen) -> None:
        try:
            give_room_back(self._run)
        except OSError as error:  # nor could a rank write down why it ended
            text = f"{self._run}: cannot be written any more: {error}; {format_newest(self._run)}"
            raise SolverError(text) from error
        note = (self._run / "logs/failure.json").exists()
        if job.returncode or note or not (self._run / "results.nc").exists():
            if self._requests.count > 1 and not note:
                raise SolverError(f"ended at once by a second signal ({self._requests.first} was the first)")
            text, code = read_failure(self._run, self._words.read_text(encoding="utf-8", errors="replace"))
            if self._requests.first:
                text = text.replace(f"stopped by {PASSED_ON.name}", f"stopped by {self._requests.first}", 1)
                correct_note(self._run, text, code)
            raise CaseError([text]) if code == 1 else ERRORS.get(code, SolverError)(text)

    def _read_rows(self, job: subprocess.Popen, offset: int) -> Iterator[dict[str, Any]]:
        """History rows as the job writes them behind the first `offset` bytes of the log, until it ends."""
        log = self._run / LOG
        told = 0
        over = False
        while not over:
            over = job.poll() is not None
            if log.exists():
                with log.open(encoding="utf-8") as file:
                    file.seek(offset)
                    while (line := file.readline()).endswith("\n"):
                        offset = file.tell()
                        row = read_line(line)
                        if row is not None:
                            yield row
            if not over:
                told = self._tell(job, told)
                self._require_progress(job)
                self._lock.beat()
                with suppress(subprocess.TimeoutExpired):
                    job.wait(_PAUSE)

    def _tell(self, job: subprocess.Popen, told: int) -> int:
        """Pass on what this process was asked, once the ranks listen: first a signal for a checkpoint, then the end."""
        asked = self._requests.count
        if asked > 1 and asked > told:
            _end(job)
        elif asked > told and (self._run / HEARTBEAT).exists():
            job.send_signal(PASSED_ON)
            text = f"stops at its next checkpoint, at most {LONGEST_WAIT:g} s and a step from now"
            self._say(f"{self._run}: {self._requests.first}: {text}; a second signal ends it at once, without one")
        else:
            return told
        return asked

    def _require_progress(self, job: subprocess.Popen) -> None:
        """Raise SolverError if the job has not moved for longer than it may; the caller ends it.

        Time in which this process, or every process of the job with its launcher, was stopped from outside does not
        count: the job goes on when they do.
        """
        seen = _read_time(self._run / HEARTBEAT)
        now = time.monotonic()
        self._waited += min(now - self._looked, _LONGEST_PASS)
        self._looked = now
        if seen != self._seen:
            self._seen, self._waited = seen, 0.0
        if self._waited > self._patience:
            if not seen and self._starts():
                self._waited = 0.0
                return
            states = _find_session(job.pid)
            stopped = [number for number, state in states.items() if state in "Tt"]
            if len(stopped) == len(states):
                self._waited = 0.0
                return
            which = f"; stopped: process {', '.join(map(str, stopped))}" if stopped else ""
            raise SolverError(f"no coupling step for {self._patience:g} s of wall time: the job was ended{which}")

    def _starts(self) -> bool:
        """Has the job, which has taken no step yet, compiled a loop or written a log within its patience?

        On a busy machine that takes minutes a loop; a start that does neither is taken for hanging as a step is.
        """
        signs = [*(self._run / "logs").iterdir(), *list_compiled()]
        return any(time.time() - 1e-9 * _read_time(sign) < self._patience for sign in signs)


def _read_time(path: Path) -> int:
    """When a file was last written [ns], 0 of one that is not there: a file may go between any two looks at it."""
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return 0


def _find_session(session: int) -> dict[int, str]:
    """Processes of the job's session and the state of each, as /proc has them."""
    found = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, _, owner = stat.read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()[:4]
        except OSError:
            continue
        if int(owner) == session:
            found[int(stat.parent.name)] = state
    return found


def _end(job: subprocess.Popen) -> None:
    """End the job and all its ranks."""
    job.terminate()
    try:
        job.wait(_GRACE)
    except subprocess.TimeoutExpired:
        job.kill()
        job.wait()
    for number in _find_session(job.pid):
        with suppress(ProcessLookupError):
            os.kill(number, signal.SIGKILL)
