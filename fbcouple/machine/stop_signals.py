"""The signals that ask a run to stop, with a checkpoint."""

import signal

SIGNALS = (signal.SIGTERM, signal.SIGUSR1, signal.SIGINT)
LONGEST_WAIT = 20.0
"""Wall time [s] after a signal that a run goes on at most, to come to a moment for a checkpoint."""
