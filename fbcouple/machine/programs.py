"""Other programs, run to their end."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path


def run_program(
    command: Sequence[str], environment: Mapping[str, str], folder: str | Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run `command` in `folder`, by default the current one, without input, and keep what it prints; what is no UTF-8
    in it is replaced. Whether its exit code is good is for the caller to say.

    Raises: FileNotFoundError if there is no such program.
    """
    return subprocess.run(
        command,
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        check=False,
    )
