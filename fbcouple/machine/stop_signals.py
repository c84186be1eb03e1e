"""The signals that ask a run to stop, with a checkpoint, and what a process is sent at its parent's end."""

import ctypes
import os
import signal
from collections.abc import Callable

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
    library, parent = ctypes.CDLL(None), os.getpid()

    def follow() -> None:
        library.prctl(_SIGNAL_AT_PARENTS_END, number)
        if os.getppid() != parent:
            os.kill(os.getpid(), number)

    return follow
