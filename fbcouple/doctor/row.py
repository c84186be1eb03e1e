"""A row of what `fbcouple doctor` prints."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One thing that a run needs: what was found, what is wanted, and the command that fixes it."""

    name: str
    found: str
    wanted: str
    ok: bool
    mend: str
