"""Errors that Python raises speak of its arguments, where the command line speaks of its options."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

from fbcouple.errors import CaseError, FbcoupleError

WORDS: tuple[tuple[str, str], ...] = (
    (r"`?fbcouple setup \S+ -o(?: [^\s`,;]+)?`?", "fbcouple.setup(case, path)"),
    (r"`fbcouple pool RUN -o (\S+) --from (\w+)`", r'`fbcouple.pool([run], "\1", start=\2)`'),
    (r"`fbcouple pool RUN -o (\S+) --reduced`", r'`fbcouple.pool([run], "\1", reduced=True)`'),
    (r"`fbcouple bench scaling [^`]+`", "`fbcouple bench scaling` on the command line"),
    (r"`fbcouple run \S+ --resume --set`", "run.resume(values=...)"),
    (r"`fbcouple run \S+ --resume`", "run.resume()"),
    (r"`fbcouple run -n RANKS`", "run.start(ranks)"),
    (r"`fbcouple run \S+`", "run.start()"),
    (r"`fbcouple setup`", "`fbcouple setup` on the command line"),
    (
        r"--resume goes on(?: from it)?, --fresh starts again",
        "resume() or resume=True goes on, fresh=True starts again",
    ),
    (r"--resume\b", "resume() or resume=True"),
    (r"--fresh\b", "fresh=True"),
    (r"--trust\b", "trust=True"),
    (r"--force\b", "force=True"),
    (r"--accept-update\b", "accept_update=True"),
    (r"--until\b", "until"),
    (r"^--set: ", "values: "),
    (r" of --set\b", " of the values"),
    (r" with --set\b", " in values"),
    (r"^--only: ", "only: "),
    (r"^--(error|within): ", r"\1: "),
    (r"another folder with -o\b|another place with -o\b", "another path"),
    (r"give fewer ranks by -n\b", "give fewer ranks"),
)
"""Pattern of the command line's words -> Python's."""


def say_in_python(text: str) -> str:
    """The same message with the arguments of the functions of this package."""
    for pattern, words in WORDS:
        text = re.sub(pattern, words, text)
    return text


@contextmanager
def in_python() -> Iterator[None]:
    """Let errors of this package that are raised inside, or in a function that this decorates, say it in Python."""
    try:
        yield
    except FbcoupleError as error:
        if isinstance(error, CaseError):
            error.problems = [say_in_python(problem) for problem in error.problems]
            error.args = (error.problems,)
        else:
            error.args = (say_in_python(str(error)),)
        raise
