"""Replicas: run folders of one case with different seeds, in the folder that held the first of them."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from fbcouple.case.load import load_case
from fbcouple.case.schema.sections import Case
from fbcouple.case.seeds import change_seeds
from fbcouple.case.source import FILE_NAME
from fbcouple.decks.set_up import lay_out_run
from fbcouple.errors import CaseError
from fbcouple.paths import REPLICA, list_replicas
from fbcouple.run_folder.lock import NAME as LOCK
from fbcouple.run_folder.lock import hold
from fbcouple.run_folder.manifest import NAME as MANIFEST
from fbcouple.run_folder.plain_files import format_path, require_plain

Say = Callable[[str], None]


def make_replicas(folder: Path, count: int, say: Say = lambda text: None) -> list[Path]:
    """Make of the run folder `folder` a folder of `count` replicas; one that is such a folder stays as it is.

    What lies in the run folder becomes its first replica, whatever it has come to; the others are set up from it with
    other seeds. Cut short, it can be done again. say: is told where they lie.

    Returns: their folders. Raises: CaseError, before anything is written, if no seed changes the case, a run is under
    way in it, or there are another number of replicas.
    """
    require_plain(folder)
    if not (folder / FILE_NAME).is_file():
        return _require_number(folder, count)
    width = len(str(count))
    replicas = [folder / f"{REPLICA}{number:0{width}d}" for number in range(1, count + 1)]
    others = [path for path in folder.glob(f"{REPLICA}*") if path not in replicas]
    if others:
        text = f"holds {others[0].name}, which is none of {count} replicas"
        raise CaseError([f"{format_path(folder)}: {text}; give the number of before, or move it elsewhere."])
    changed = [] if _is_moving(replicas[0]) else _change(folder, count)
    with hold(folder):
        for case, run in zip(changed, replicas[1:], strict=False):
            lay_out_run(case, folder, run)
        _move(folder, replicas)
    say(f"{folder}: is a folder of {count} replicas now, {replicas[0].name} to {replicas[-1].name}, of different seeds")
    return replicas


def _is_moving(first: Path) -> bool:
    """Was an earlier call cut short as it moved the run into its first replica? Then the others are there."""
    return (first / MANIFEST).is_file()


def _change(folder: Path, count: int) -> list[Case]:
    """The cases of all replicas but the first."""
    case = load_case(str(folder))
    try:
        return [change_seeds(case, by) for by in range(1, count)]
    except CaseError as error:
        raise CaseError([f"{format_path(folder)}: {problem}" for problem in error.problems]) from None


def _require_number(folder: Path, count: int) -> list[Path]:
    found, shown = list_replicas(folder), format_path(folder)
    if not found:
        text = "is no run folder, and no folder of replicas"
        raise CaseError([f"{shown}: {text}; write one with `fbcouple setup CASE -o {shown}`."])
    if len(found) != count:
        text = f"holds {len(found)} replicas and {count} are asked for; their number stays as it is"
        mend = "give that number to go on with them, or set up another folder and pool both"
        raise CaseError([f"{shown}: {text}: {mend}."])
    return found


def _move(folder: Path, replicas: list[Path]) -> None:
    """Move all in `folder` but the replicas into the first of them, the case last: until then it is a run folder."""
    replicas[0].mkdir(exist_ok=True)
    names = sorted(path.name for path in folder.iterdir() if path not in replicas)
    first = [name for name in names if name == MANIFEST]
    for name in [*first, *(name for name in names if name not in (MANIFEST, FILE_NAME, LOCK)), FILE_NAME]:
        os.replace(folder / name, replicas[0] / name)
    (folder / LOCK).unlink()
