"""Requests to stop a run: signals, as the process hears them that the user started, and those of other threads."""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from fbcouple.machine.stop_signals import SIGNALS

ECHO = 0.5
"""Wall time [s] after the first signal in which another is the same request: a batch system sends it to every process
of a job, and the job's script hands it on."""


class Requests:
    """Signals to this process (SIGTERM, SIGUSR1, SIGINT) that ask a run to stop, counted while in the context."""

    def __init__(self) -> None:
        self.count = 0
        self.first = ""
        """Name of the first of them."""
        self._heard = -math.inf
        self._is_at_once = False
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Requests:
        if threading.current_thread() is not threading.main_thread():
            return self  # only the main thread hears signals: from another, ask by `stop`
        self._before = {number: signal.signal(number, self._hear) for number in SIGNALS}
        return self

    def __exit__(self, *error: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def stop(self, reason: str) -> None:
        """Ask the run to stop, as a signal does."""
        self.count += 1
        self.first = self.first or reason
        if self._is_at_once:
            raise KeyboardInterrupt

    @contextmanager
    def at_once(self) -> Iterator[None]:
        """In the block, which is work that no checkpoint keeps, a request raises KeyboardInterrupt; so does one from
        before it."""
        if self.count:
            raise KeyboardInterrupt
        self._is_at_once = True
        try:
            yield
        finally:
            self._is_at_once = False

    def _hear(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if now - self._heard > ECHO:
            self._heard = now
            self.stop(signal.Signals(number).name)
