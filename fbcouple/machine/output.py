"""What a command prints, where the terminal, the pipe or the disk that takes it may go away."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import wraps
from typing import Any, TextIO


class SteadyStream:
    """A text stream that goes on without its file: what cannot be written any more is dropped."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.lost: OSError | None = None
        """Why nothing more is written, if nothing is."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write, or drop, `text`."""
        try:
            self._stream.write(text)
        except OSError as error:
            self._give_up(error)
        return len(text)

    def flush(self) -> None:
        """Bring to the file what it still takes."""
        try:
            self._stream.flush()
        except OSError as error:
            self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        self.lost = self.lost or error
        drop(self._stream)


@contextmanager
def steady_output() -> Iterator[SteadyStream]:
    """Let stdout and stderr, which must be open, go away without an end to the block; yields what stands for stdout."""
    before = sys.stdout, sys.stderr
    steady = SteadyStream(sys.stdout), SteadyStream(sys.stderr)
    sys.stdout, sys.stderr = steady  # type: ignore[assignment]
    try:
        yield steady[0]
    finally:
        for stream in steady:
            stream.flush()
        sys.stdout, sys.stderr = before


def outlive_output(command: Callable[..., Any]) -> Callable[..., Any]:
    """Let `command` go on to its end, and to its exit code, where its output cannot be written; told on stderr, but for
    a reader that went away."""

    @wraps(command)
    def go_on(*arguments: Any, **options: Any) -> Any:
        with steady_output() as output:
            try:
                return command(*arguments, **options)
            finally:
                if output.lost and not isinstance(output.lost, BrokenPipeError):
                    print(f"the output could not be written from some line on: {output.lost}", file=sys.stderr)

    return go_on


def drop(stream: TextIO) -> None:
    """Let the file of `stream` be nothing from here on, so that what it still holds does no harm at the end."""
    with suppress(OSError, ValueError):
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, stream.fileno())
        os.close(nothing)


def open_standard_streams() -> None:
    """Have the numbers 0, 1 and 2 taken, or a log would get one and be written over by what a child prints; letters
    that the terminal's code does not have are written as escapes."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    for name, number in (("stdout", 1), ("stderr", 2)):
        stream = getattr(sys, name) or os.fdopen(number, "w", encoding="utf-8")
        stream.reconfigure(errors="backslashreplace")
        setattr(sys, name, stream)
