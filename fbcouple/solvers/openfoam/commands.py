"""Outside programs that a build needs: a failure becomes an error with the program's own last words."""

import shlex
from collections.abc import Sequence
from pathlib import Path

from fbcouple.errors import SolverError
from fbcouple.machine.environment import child_environment
from fbcouple.machine.programs import run_program

_LAST_LINES = 30


def run_command(command: Sequence[str], *, mend: str, folder: Path | None = None) -> str:
    """Run one outside program and return what it printed on stdout; what it and the loader warn of is not part of it.

    Parameters
    ----------
    command : the program and its arguments
    fix : what the user can do if the program is missing or fails, ends the error's text
    folder : where it runs, the present folder if not given

    Raises
    ------
    SolverError : the program is missing or failed; the text holds the command and its last lines
    """
    try:
        done = run_program(command, child_environment(), folder)
    except FileNotFoundError as error:
        raise SolverError(f"program '{command[0]}' is not on PATH; {mend}") from error
    if done.returncode != 0:
        words = "\n".join((done.stdout + done.stderr).splitlines()[-_LAST_LINES:])
        raise SolverError(
            f"command failed with exit code {done.returncode} (0 is allowed): {shlex.join(command)}\n{words}\n{mend}"
        )
    return done.stdout
