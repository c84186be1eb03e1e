"""A run folder as something that may come from anybody: what may lie in it at all, and whether it is still there.

Nothing in a run folder is read or written before `require_plain` has seen it. Someone who changes the folder while a
command works in it is not kept out by this: it looks at what was handed over.
"""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from fbcouple.errors import CaseError, SolverError

_MOST_NAMED = 10


def require_plain(run: Path) -> None:
    """Raise CaseError unless all that lies in `run`, at any depth, is plain files and folders.

    A link leads files that a run writes to places outside of it, a pipe holds up who reads it for ever, and a file with
    a second name is changed under that name too. `run` itself may be a link. A `run` that is not there is plain.
    """
    problems: list[str] = []
    for path, trouble in _find_trouble(run):
        if len(problems) == _MOST_NAMED:
            problems.append(f"{format_path(run)}: holds more of this kind.")
            break
        problems.append(f"{format_path(path)}: {trouble}")
    if problems:
        raise CaseError(problems)


def _find_trouble(folder: Path) -> Iterator[tuple[Path, str]]:
    """What is no plain file or folder below `folder`, and what is wrong with it; no link is followed."""
    try:
        entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise SolverError(f"{format_path(folder)}: cannot be looked into: {error.strerror}") from error
    for entry in entries:
        path = folder / entry.name
        kind = entry.stat(follow_symlinks=False)
        if stat.S_ISDIR(kind.st_mode):
            yield from _find_trouble(path)
        elif stat.S_ISLNK(kind.st_mode):
            yield path, "is a link; in a run folder only plain files are allowed: put the file itself there."
        elif not stat.S_ISREG(kind.st_mode):
            yield path, "is a pipe, socket or device; in a run folder only plain files are allowed: remove it."
        elif kind.st_nlink > 1:
            yield path, "has another name elsewhere (hard link) and would change there too; put a copy in its place."


def format_path(path: Path) -> str:
    """`path` for a message, on one line whatever its name holds."""
    return str(path) if str(path).isprintable() else json.dumps(str(path))


def is_same(path: Path, other: Path | int) -> bool:
    """Is `path` there, and the same file or folder as `other`, a path or an open file number?"""
    try:
        return os.path.samestat(os.stat(path), os.stat(other))
    except (FileNotFoundError, NotADirectoryError):
        return False


def format_moved(run: Path) -> str:
    """Say that the run folder `run` is not where it was when a run began in it."""
    return (
        f"{run}: was moved or removed while a run was under way in it, which has ended; if it was moved, go on in its "
        "new place with --resume"
    )
