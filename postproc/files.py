"""How files of figures and reports reach the disk: whole or not at all, and told if they cannot."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from fbcouple.errors import CaseError
from fbcouple.machine.whole_files import require_writable

ELSEWHERE = "give another place with -o"
PAGE_ENDINGS = (".html", ".htm")


@contextmanager
def writing(path: Path, mend: str = ELSEWHERE) -> Iterator[None]:
    """Tell which of the user's files cannot be written, and the way out. Raises: CaseError in place of OSError."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise CaseError([f"{path}: cannot be written ({reason}); {mend}."]) from error


def write_whole(path: Path, write: Callable[[Path], object], mend: str = ELSEWHERE) -> Path:
    """Let `write` make the file under a temporary name, then move it into place, so that no half file is ever seen.

    Raises: CaseError if it cannot be written; an older file is left then.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    with writing(path, mend):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            write(temporary)
            os.replace(temporary, path)
        finally:
            with suppress(OSError):  # the reason why it could not be written is what counts
                temporary.unlink(missing_ok=True)
    return path


def name_numbers(page: Path) -> Path:
    """The JSON file beside an HTML page. Raises: CaseError if `page` has not the name of one, or cannot be written."""
    if page.suffix.lower() not in PAGE_ENDINGS:
        allowed = " or ".join(PAGE_ENDINGS)
        text = f"is given for an HTML page, a name that ends in {allowed} is allowed"
        raise CaseError([f"{page}: {text}: its numbers go beside it into a .json file."])
    numbers = page.with_suffix(".json")
    for path in (page, numbers):
        require_writable(path, ELSEWHERE)
    return numbers


def remove(path: Path) -> None:
    """Remove a file of an earlier time, if it is there. Raises: CaseError if it cannot be removed."""
    with writing(path):
        path.unlink(missing_ok=True)
