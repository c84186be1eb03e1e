"""Ask a LIGGGHTS library what it can do: `python -m fbcouple.solvers.liggghts_probe FOLDER`.

FOLDER has a folder for each question: a deck, DEM/in.liggghts with its files, and task.json, which says what is asked
of its particles besides. A command that LIGGGHTS does not know ends its process, so each question has one of its own,
a fork from before MPI begins. The answers are printed as JSON: question -> "" or the command and LIGGGHTS' words.
"""

from __future__ import annotations

import json
import os
import re
import signal
import sys
from pathlib import Path
from typing import Any

import mpi4py
import numpy as np

mpi4py.rc.initialize = False

from mpi4py import MPI  # noqa: E402  (MPI begins in the forks)

from fbcouple.errors import SolverError  # noqa: E402
from fbcouple.solvers.c_library import load_library  # noqa: E402
from fbcouple.solvers.liggghts import Liggghts  # noqa: E402
from fbcouple.solvers.site_files import find_liggghts  # noqa: E402

DECK, TASK, LOG = "DEM/in.liggghts", "task.json", "liggghts.log"
_LAST, _DONE = "last", "done"
"""Files in a question's folder: the command that is being given, and that all were."""
_PLACES = re.compile(r" *\([\w./]+:\d+\)$")
"""Where in LIGGGHTS' own sources an error is from."""


class _Asked(Liggghts):
    """LIGGGHTS that notes each command before it is given."""

    def read(self, deck: Path) -> None:
        for line in deck.read_text(encoding="utf-8").splitlines():
            if words := line.partition("#")[0].strip():
                self.command(words)

    def command(self, line: str) -> None:
        Path(_LAST).write_text(line, encoding="utf-8")
        super().command(line)


def main() -> None:
    """Ask every question in the folder; a library that cannot be loaded ends it with the loader's words on stderr."""
    try:
        load_library(find_liggghts(), {}, "name LIGGGHTS' library")
    except SolverError as error:
        sys.exit(str(error))
    folder = Path(sys.argv[1]).resolve()
    answers = {one.name: _ask(one) for one in sorted(folder.iterdir()) if (one / TASK).is_file()}
    print(json.dumps(answers))


def _ask(question: Path) -> str:
    if (child := os.fork()) == 0:
        os.chdir(question)
        os.environ["PWD"] = str(question)
        try:
            _try_out(json.loads(Path(TASK).read_text(encoding="utf-8")))
            Path(_DONE).touch()
        finally:
            os._exit(0)  # nothing of the parent's is ended by a child
    status = os.waitpid(child, 0)[1]
    return "" if (question / _DONE).is_file() else _tell_end(question, status)


def _tell_end(question: Path, status: int) -> str:
    """The command that was not done, and LIGGGHTS' words or how the process ended."""
    last, log = question / _LAST, question / LOG
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines() if log.is_file() else []
    errors = [_PLACES.sub("", line.strip()) for line in lines if line.startswith("ERROR")]
    code = os.waitstatus_to_exitcode(status)
    ended = f"ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
    told = last.read_text(encoding="utf-8") if last.is_file() else "library functions"
    return f"{' '.join(told.split())}: {errors[-1] if errors else ended}"[:300]


def _try_out(task: dict[str, Any]) -> None:
    """Read the deck, take steps, and use what the coupling uses of the particles."""
    MPI.Init()
    asked = _Asked(Path(DECK), Path(LOG), MPI.COMM_WORLD, None, task["remembers"], task["identifies"])
    asked.advance(1, first=True)
    asked.advance(1)
    for one in task["arrays"]:
        Path(_LAST).write_text(f"array {one}", encoding="utf-8")
        getattr(asked, one).sum()
    if task["openings"]:
        asked.read(Path(task["openings"]))
    if task["identifies"]:
        asked.remove(np.empty(0, dtype=int))
        x, y, z = task["place"]
        asked.create(np.array([1]), np.array([[x, y, z]]), np.array([task["diameter"]]), np.array([task["density"]]))
    asked.advance(1, first=True)
    asked.command("write_restart probe.restart")


if __name__ == "__main__":
    main()
