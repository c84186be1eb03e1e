"""The run folders in a folder, and how long each of them will take."""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable
from pathlib import Path

from fbcouple.case.cost.coefficients import SHIPPED
from fbcouple.case.cost.prediction import predict
from fbcouple.case.load import load_case
from fbcouple.case.source import FILE_NAME
from fbcouple.errors import CaseError
from fbcouple.run_folder.manifest import NAME as MANIFEST
from fbcouple.run_folder.plain_files import format_path

Say = Callable[[str], None]


def is_set(folder: Path) -> bool:
    """Is `folder` no run folder, and holds some?"""
    return not (folder / FILE_NAME).is_file() and any(folder.glob(f"*/{FILE_NAME}"))


def find_runs(folder: Path, say: Say = lambda text: None) -> list[Path]:
    """The run folder `folder`, or the run folders in it, by name.

    A folder in it that holds a case and was never set up is left out, and `say` is told.

    Raises: CaseError if it is none and holds none.
    """
    quoted = shlex.quote(str(folder))
    if folder.is_file():
        mend = f"give the folder of a run (what a results file holds is shown by `fbcouple report {quoted}`)"
        raise CaseError([f"{folder}: is a file and no run folder; {mend}."])
    if (folder / FILE_NAME).is_file():
        if not (folder / MANIFEST).exists():
            mend = f"make a run of it with `fbcouple setup {quoted} -o RUN`"
            raise CaseError([f"{folder}: is a case, and no run folder; {mend}, and give that."])
        return [folder.resolve()]
    found = sorted(path.parent.resolve() for path in folder.glob(f"*/{FILE_NAME}")) if folder.is_dir() else []
    runs = [run for run in found if (run / MANIFEST).exists()]
    if not runs:
        cases = f"; {found[0].name} in it is a case that was not set up" if found else ""
        text = f"is neither a run folder nor a folder of runs{cases}"
        raise CaseError([f"{folder}: {text}; write one with `fbcouple setup CASE -o {quoted}`."])
    for case in found:
        if case not in runs:
            shown = format_path(case)
            say(
                f"{shown}: is a case, and no run folder: left out; make a run of it with: fbcouple setup {shown} -o RUN"
            )
    return runs


def predict_wall(run: Path) -> float:
    """Wall time [s] that the whole run in the folder `run` is predicted to take on one rank, by the costs that are
    shipped: what runs are put in order by, the same everywhere. Infinite where that cannot be told."""
    try:
        return predict(load_case(str(run)), 1, SHIPPED, run).wall
    except CaseError:
        return math.inf
