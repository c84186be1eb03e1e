"""Where a C library writes that knows no other file than the standard output."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fbcouple.errors import SolverError

LARGEST = 2_000_000
"""Bytes that a log may have before it is shortened."""
_BEGINNING, _END = 200_000, 200_000
_LINE_BY_LINE = 1  # _IOLBF
_c = ctypes.CDLL(None, use_errno=True)
_c.fopen.restype, _c.fopen.argtypes = ctypes.c_void_p, [ctypes.c_char_p, ctypes.c_char_p]
_c.setvbuf.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_size_t]


@contextmanager
def standard_output_into(log: Path) -> Iterator[None]:
    """Let `log` be what a C library takes for its standard output while it starts; it may keep it afterwards.

    Each line goes to the disk as it is written and behind what is there, so that the last words of any rank are read
    even if the process is ended in the next moment. Python's own output stays where it is.

    Raises: SolverError if `log` cannot be opened.
    """
    stream = _c.fopen(os.fsencode(log), b"a")
    if not stream:
        raise SolverError(f"{log}: cannot be written: {os.strerror(ctypes.get_errno())}")
    _c.setvbuf(stream, None, _LINE_BY_LINE, 0)
    variable = ctypes.c_void_p.in_dll(_c, "stdout")  # a variable that may be set, as the GNU C library's manual says
    before, variable.value = variable.value, stream
    try:
        yield
    finally:
        variable.value = before


def shorten(log: Path) -> None:
    """Leave out the middle of a log that has become too long; who writes it goes on behind its end."""
    size = log.stat().st_size
    if size <= LARGEST:
        return
    with log.open("rb+") as file:
        file.seek(size - _END)
        end = file.read(_END).partition(b"\n")[2]
        file.seek(_BEGINNING)
        file.truncate()
        file.write(f"\n[... {size - _BEGINNING - len(end)} bytes are left out ...]\n".encode() + end)
