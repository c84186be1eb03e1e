"""The runs of a set, side by side, each as `fbcouple run` does it in a process of its own."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from fbcouple.batch.folders import predict_wall
from fbcouple.errors import BusyError, CaseError, DivergedError, FbcoupleError, SolverError, StoppedError
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.environment import child_environment
from fbcouple.machine.stop_signals import LONGEST_WAIT, follow_parent

CONSOLE = "logs/console.log"
"""In a run folder: what `fbcouple run` said, where it was one of several."""
STOPPED = (StoppedError.exit_code, -signal.SIGTERM)
"""Exit codes of a run that was stopped; the second of one that had not begun to listen yet."""
TO_STOP = LONGEST_WAIT + 10.0
"""Wall time [s] that runs need to stop with checkpoints."""
_LOOK_EVERY = 0.2
_ERRORS: dict[int, type[FbcoupleError]] = {kind.exit_code: kind for kind in (SolverError, DivergedError, StoppedError)}


@dataclass(frozen=True)
class Ended:
    """How one of the runs ended: its exit code, its last words, and its wall time [s]."""

    run: Path
    code: int
    words: str
    seconds: float


def run_all(
    runs: Sequence[Path],
    jobs: int,
    options: Sequence[str],
    requests: Requests,
    watch: Callable[[list[Path], list[Ended]], None] = lambda running, ended: None,
    wall_limit: float = math.inf,
) -> list[Ended]:
    """Run the folders `runs`, the longest first, `jobs` at a time, each by `fbcouple run RUN` with `options`.

    What one of them comes to does not end the others. A request to stop is handed to those that are under way, which
    stop with checkpoints, and no other is begun; so they do where this process, or the thread of the call, dies.
    watch: is given the runs that are under way and those that have ended, five times a second; wall_limit [s]: of all
    together, they are asked to stop `TO_STOP` before it is over.

    Returns: how each ended, in the order of their ends; those that were not begun are missing.
    """
    waiting = sorted(runs, key=predict_wall, reverse=True)
    running: dict[Path, tuple[subprocess.Popen[bytes], float]] = {}
    ended: list[Ended] = []
    heard, deadline = 0, time.monotonic() + wall_limit - TO_STOP
    while running or (waiting and not requests.count):
        if time.monotonic() > deadline and not requests.count:
            requests.stop("--wall-limit")
        while waiting and len(running) < jobs and not requests.count:
            run = waiting.pop(0)
            running[run] = _begin(run, options), time.monotonic()
        if requests.count > heard:
            heard = requests.count
            for process, _ in running.values():
                process.send_signal(signal.SIGTERM)
        for run, (process, begun) in list(running.items()):
            if process.poll() is not None:
                del running[run]
                ended.append(Ended(run, process.returncode, _read_last(run), time.monotonic() - begun))
        watch(list(running), ended)
        time.sleep(_LOOK_EVERY)
    return ended


def require_done(runs: Sequence[Path], ended: Sequence[Ended], command: str) -> None:
    """Raise the error of the first of `runs` that failed, with a text for each that did; StoppedError, with the
    `command` that goes on, if none failed and not all were done."""
    failed = [one for one in ended if one.code not in (0, *STOPPED)]
    texts = [f"{one.run}: {one.words or f'ended with exit code {one.code}'}" for one in failed]
    if failed and failed[0].code in _ERRORS:
        raise _ERRORS[failed[0].code]("\n".join(texts))
    if failed:
        raise (BusyError if failed[0].code == BusyError.exit_code else CaseError)(texts)
    done = sum(one.code == 0 for one in ended)
    if done < len(runs):
        raise StoppedError(f"{done} of {len(runs)} runs are complete; go on with {command}")


def _begin(run: Path, options: Sequence[str]) -> subprocess.Popen[bytes]:
    """A session of its own: a Ctrl-C of the terminal comes once, by the one who started them all."""
    (run / CONSOLE).parent.mkdir(exist_ok=True)
    command = [sys.executable, "-P", "-m", "fbcouple", "run", str(run), *options]
    with (run / CONSOLE).open("wb") as log:
        return subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            env=child_environment(),
            start_new_session=True,
            preexec_fn=follow_parent(signal.SIGTERM),  # noqa: PLW1509  (nothing between fork and exec takes a lock)
        )


def _read_last(run: Path) -> str:
    """The last line that a run said, without its own name in front."""
    lines = (run / CONSOLE).read_text(encoding="utf-8", errors="replace").splitlines()
    return next((line.strip() for line in reversed(lines) if line.strip()), "").removeprefix(f"{run}: ")
