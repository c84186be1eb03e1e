"""The signals that ask a run to stop, with a checkpoint, and what a process is sent at its parent's end."""

import ctypes
import os
import signal
from collections.abc import Callable
from functools import partial

SIGNALS = (signal.SIGTERM, signal.SIGUSR1, signal.SIGINT)
LONGEST_WAIT = 20.0
"""Wall time [s] after a signal that a run goes on at most, to come to a moment for a checkpoint."""
WALL_LIMIT = "the wall limit"
"""What stops a run whose wall time is over, in place of the name of a signal."""
_SIGNAL_AT_PARENTS_END = 1
"""PR_SET_PDEATHSIG of Linux (prctl(2))."""


def follow_parent(number: int) -> Callable[[], None]:
    """For `preexec_fn` of a new process: it is sent the signal `number` where this process, or the thread that began
    it, dies, also if that was before it could be told."""
    return partial(follow, number, os.getpid(), ctypes.CDLL(None))


def follow(number: int, parent: int, library: ctypes.CDLL | None = None) -> None:
    """From now on this process is sent the signal `number` where its `parent`, by its id, dies, or has died."""
    (library or ctypes.CDLL(None)).prctl(_SIGNAL_AT_PARENTS_END, number)
    if os.getppid() != parent:
        os.kill(os.getpid(), number)
