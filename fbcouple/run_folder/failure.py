"""Why a run failed: written down by the rank that knows, or read from the solvers' logs by the parent."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

_NOTE = "logs/failure.json"
_ROOM = "logs/failure.room"
_ROOM_SIZE = 32768
_LONGEST = 5000  # characters, of which each takes six bytes at most in JSON
_TAIL = 15
# LIGGGHTS' own word for a particle that went out of the box or is not finite.
_DIVERGED = "Lost atoms"
# What the launcher says at length, and what it means for a run.
_LAUNCHER_WORDS = {
    "There are not enough slots available": (
        "mpirun: the batch system gives this job fewer places than the run has ranks; "
        "ask it for as many tasks (--ntasks) or cores of the task (-c), or give fewer ranks by -n"
    ),
}
SOLVER_LOGS = {"liggghts.log": "LIGGGHTS", "openfoam.log": "OpenFOAM"}


def prepare_failure(run: Path) -> None:
    """Remove the note of an earlier failure, and keep room for one on a disk that will be full."""
    (run / _NOTE).unlink(missing_ok=True)
    with (run / _ROOM).open("w", encoding="utf-8") as file:
        file.write(" " * _ROOM_SIZE)
        file.flush()
        os.fsync(file.fileno())


def write_failure(run: Path, text: str, exit_code: int) -> None:
    """Write down why this rank ends the run; the first rank to do so is heard, also where the disk is full."""
    try:
        (run / _ROOM).rename(run / _NOTE)
    except FileNotFoundError:
        if (run / _NOTE).exists():
            return
    note = json.dumps({"text": text[:_LONGEST], "exit_code": exit_code})
    with open(run / _NOTE, "r+" if (run / _NOTE).exists() else "w", encoding="utf-8") as file:
        file.write(note)


def correct_note(run: Path, text: str, exit_code: int) -> None:
    """Put `text` in place of a rank's own note, if there is one; as long as that at most, for a disk that is full."""
    if note := _read_note(run):
        known = json.dumps({"text": text[: len(note[0])], "exit_code": exit_code})
        with open(run / _NOTE, "r+", encoding="utf-8") as file:
            file.write(known)
            file.truncate()


def give_room_back(run: Path) -> None:
    """Remove the room for a note that nobody needed."""
    (run / _ROOM).unlink(missing_ok=True)


def read_failure(run: Path, launcher_words: str) -> tuple[str, int]:
    """Text and exit code of a failed run: the rank's own note, a solver's last error, or the launcher's last words."""
    if note := _read_note(run):
        return note
    for name, solver in SOLVER_LOGS.items():
        words = _find_last_error(run / "logs" / name)
        if words:
            return f"{solver}: {words} (in logs/{name})", 4 if _DIVERGED in words else 3
    for phrase, meaning in _LAUNCHER_WORDS.items():
        if phrase in launcher_words:
            return f"{meaning} (in logs/launcher.log)", 3
    tail = "\n".join(launcher_words.strip().splitlines()[-_TAIL:])
    return f"the run ended without a word of its own; the MPI launcher said:\n{tail}", 3


def read_note(run: Path) -> str:
    """Why a rank ended the run, by its own note; "" where there is none."""
    note = _read_note(run)
    return note[0] if note else ""


def _read_note(run: Path) -> tuple[str, int] | None:
    try:
        known = json.loads((run / _NOTE).read_text(encoding="utf-8"))
        return str(known["text"]), int(known["exit_code"])
    except (OSError, ValueError, LookupError, TypeError):
        return None


def _find_last_error(log: Path) -> str | None:
    if not log.exists():
        return None
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    hits = [n for n, line in enumerate(lines) if re.match(r"ERROR|--> FOAM FATAL", line)]
    return " ".join(line.strip() for line in lines[hits[-1] : hits[-1] + 3]) if hits else None
