"""Files that are there whole or not at all, whatever stops the process that writes them."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fbcouple.errors import CaseError

UNFINISHED = ".part"
"""What the name of a file ends in while it is being written."""


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a name beside `path`; the file that is written under it takes the place of `path`, once it is on the disk.

    After an error nothing of it is left, and `path` is as it was. Raises: OSError.
    """
    fresh = path.with_name(path.name + UNFINISHED)
    try:
        yield fresh
        with fresh.open("rb") as file:
            os.fsync(file.fileno())
        fresh.replace(path)
    except BaseException:
        fresh.unlink(missing_ok=True)
        raise


def require_writable(path: Path, mend: str) -> None:
    """Raise CaseError, which ends in `mend`, unless a file can be written at `path`, in folders that may be made for
    it: asked before work whose result would be lost. Nothing is left behind."""
    try:
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        above = next(one for one in path.absolute().parents if os.path.lexists(one))
        with tempfile.TemporaryFile(dir=above):
            pass
    except OSError as error:
        raise CaseError([f"{path}: cannot be written ({error.strerror or error}); {mend}."]) from error


def write_whole(path: Path, text: str) -> None:
    """Replace `path` by `text` in UTF-8, all of it or nothing. Raises: OSError."""
    with replacing(path) as fresh:
        fresh.write_text(text, encoding="utf-8", newline="\n")
