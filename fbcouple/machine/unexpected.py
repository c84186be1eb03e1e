"""Errors that nobody foresaw: one line for the user, the whole traceback for whoever fixes it."""

from __future__ import annotations

import os
import sys
import traceback
from pathlib import Path

from fbcouple.paths import ABOVE, cache_folder

EXIT_CODE = 3
TRACEBACK = "FBCOUPLE_TRACEBACK"
"""Environment variable: set to anything but 0, tracebacks are shown on stderr as well."""
LAST_ERROR = "last-error.txt"
_LONGEST = 300
_MEANINGS: dict[type[BaseException], str] = {
    MemoryError: "more memory is needed than this machine gives",
    RecursionError: "the input is nested too deeply",
    UnicodeError: "a text is not in the code that is read or written",
}


def describe(error: BaseException) -> str:
    """One line: the error, what it means where that is known, and the place in our own sources that it came from."""
    meanings = [text for kind, text in _MEANINGS.items() if isinstance(error, kind)]
    said = " ".join(str(error).split())
    said = said if len(said) <= _LONGEST else f"{said[:_LONGEST]} ..."
    return f"{': '.join(filter(None, [type(error).__name__, *meanings, said]))}{_find_place(error)}"


def _find_place(error: BaseException) -> str:
    calls = [(Path(call.filename).resolve(), call.lineno) for call in traceback.extract_tb(error.__traceback__)]
    ours = [call for call in calls if any(call[0].is_relative_to(ABOVE / name) for name in ("fbcouple", "postproc"))]
    return f" (at {ours[-1][0].relative_to(ABOVE)}:{ours[-1][1]})" if ours else ""


def report(error: BaseException) -> str:
    """Keep the traceback of `error` and return the line for the user: what, where, and how to report it."""
    text = "".join(traceback.format_exception(error))
    if os.environ.get(TRACEBACK, "0") not in ("", "0"):
        print(text, file=sys.stderr, flush=True)
    kept = _keep(text)
    where = f"its traceback is in {kept}" if kept else f"{TRACEBACK}=1 shows its traceback"
    return (
        f"fbcouple: unexpected error: {describe(error)}; {where}. If the machine is not the cause, "
        "`fbcouple doctor --bundle [RUN]` makes the archive for a bug report."
    )


def _keep(text: str) -> Path | None:
    """Write the traceback where the archive for a bug report looks for it; None if that cannot be written."""
    try:
        path = cache_folder() / LAST_ERROR
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_name(f".{LAST_ERROR}.{os.getpid()}")
        unfinished.write_text(text, encoding="utf-8", errors="backslashreplace")
        unfinished.replace(path)
    except OSError:
        return None
    return path
