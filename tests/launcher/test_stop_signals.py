"""Signals that ask a run to stop: one that comes twice at once is one request."""

from __future__ import annotations

import signal
import time

from fbcouple.launcher.stop_signals import ECHO, Requests


def test_a_signal_that_a_job_script_hands_on_too_counts_once():
    """A second request would end the run without a checkpoint."""
    with Requests() as requests:
        for number in (signal.SIGTERM, signal.SIGTERM, signal.SIGUSR1):
            signal.raise_signal(number)
        assert (requests.count, requests.first) == (1, "SIGTERM")
        time.sleep(1.2 * ECHO)
        signal.raise_signal(signal.SIGTERM)
        assert requests.count == 2
