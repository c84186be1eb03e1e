"""The runs of a study, one after the other or in processes of their own, and what a signal does to them."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from types import FrameType
from typing import Any, TypeVar

from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.environment import child_environment, hand_down
from fbcouple.machine.stop_signals import SIGNALS, follow

T = TypeVar("T")
_LOOK_EVERY = 0.2
_HANDED_ON = signal.SIGUSR2
"""The signal by which a process hears that the study was asked to stop. Those that ask may reach it as well, with all
of the study's processes or alone: it does not listen to them, so that one request is not taken for two."""
_ALL = (*SIGNALS, _HANDED_ON)
_requests = Requests()
"""Of a process that was begun for runs of a study."""


def run_side_by_side(
    work: Callable[..., T], calls: Sequence[tuple[Any, ...]], jobs: int, requests: Requests
) -> Iterator[T | None]:
    """What `work`, a function of a module, gives for each of `calls`, its arguments, in their order; up to `jobs` of
    them run at a time, in processes of their own where that is more than one. Its last argument are the requests to
    stop that it has to heed: those of `requests`, handed on. None for a call that was not begun any more."""
    if jobs == 1:
        for call in calls:
            yield None if requests.count else work(*call, requests)
        return
    with hand_down():  # its lock begins a process that counts locks
        numbers = get_context("spawn").SimpleQueue()
    told: dict[int, int] = {}
    with _begin_all(work, calls, jobs, numbers) as futures:
        for future in futures:
            while not wait([future], timeout=_LOOK_EVERY).done:
                while not numbers.empty():
                    told[numbers.get()] = 0
                _hand_on(requests, told)
            yield future.result()


def _hand_on(requests: Requests, told: dict[int, int]) -> None:
    """Send each process, by its number, a signal where it has been told of fewer `requests` than there are."""
    for number, count in told.items():
        if count < requests.count:
            told[number] = requests.count
            with suppress(ProcessLookupError):
                os.kill(number, _HANDED_ON)


@contextmanager
def _begin_all(
    work: Callable[..., T], calls: Sequence[tuple[Any, ...]], jobs: int, numbers: Any
) -> Iterator[list[Future[T | None]]]:
    """All calls handed to `jobs` processes, which put their numbers into `numbers` as soon as they listen; those that
    are not begun at the end of the block are given up."""
    environment = child_environment()
    pool = ProcessPoolExecutor(
        jobs, get_context("spawn"), initializer=_begin, initargs=(environment, numbers, os.getpid())
    )
    # A process starts with this one's mask: a signal waits until it listens, and does not end it.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _ALL)
    try:
        with hand_down():
            futures = [pool.submit(_work, work, call) for call in calls]
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    with pool:
        try:
            yield futures
        finally:
            for future in futures:
                future.cancel()


def _begin(environment: dict[str, str], numbers: Any, study: int) -> None:
    """A process inherits also what an MPI in the one that started it has told its C library, and no run could start.

    It ends with the `study`, by its id; the run in it is then asked to stop.
    """
    follow(signal.SIGKILL, study)
    os.environ.clear()
    os.environ.update(environment)
    for number in SIGNALS:
        signal.signal(number, _ignore)
    signal.signal(_HANDED_ON, _hear)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _ALL)
    numbers.put(os.getpid())


def _ignore(number: int, frame: FrameType | None) -> None:
    """In place of SIG_IGN, which the programs that this process starts would inherit."""


def _hear(number: int, frame: FrameType | None) -> None:
    _requests.stop("a signal to the study")


def _work(work: Callable[..., T], call: tuple[Any, ...]) -> T | None:
    return None if _requests.count else work(*call, _requests)
