"""What is said where the disk does not take a file of the run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fbcouple.errors import SolverError
from fbcouple.run_folder.checkpoint import format_newest


@contextmanager
def writing(run: Path, name: str) -> Iterator[None]:
    """Raise SolverError with the file that could not be written, and what the run goes on from."""
    try:
        yield
    except OSError as error:
        raise SolverError(f"{name} cannot be written: {error}; {format_newest(run)}") from error
