"""The signals that ask a run to stop, with a checkpoint."""

import signal

SIGNALS = (signal.SIGTERM, signal.SIGUSR1, signal.SIGINT)
