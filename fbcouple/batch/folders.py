"""The run folders in a folder, and how long each of them will take."""

from __future__ import annotations

import shlex
from pathlib import Path

from fbcouple.case.cost.coefficients import SHIPPED
from fbcouple.case.cost.prediction import predict
from fbcouple.case.load import load_case
from fbcouple.case.source import FILE_NAME
from fbcouple.errors import CaseError


def is_set(folder: Path) -> bool:
    """Is `folder` no run folder, and holds some?"""
    return not (folder / FILE_NAME).is_file() and any(folder.glob(f"*/{FILE_NAME}"))


def find_runs(folder: Path) -> list[Path]:
    """The run folder `folder`, or the run folders in it, by name.

    Raises: CaseError if it is none and holds none.
    """
    if (folder / FILE_NAME).is_file():
        return [folder.resolve()]
    runs = sorted(path.parent.resolve() for path in folder.glob(f"*/{FILE_NAME}")) if folder.is_dir() else []
    if not runs:
        text = "is neither a run folder nor a folder of runs"
        raise CaseError([f"{folder}: {text}; write one with `fbcouple setup CASE -o {shlex.quote(str(folder))}`."])
    return runs


def predict_wall(run: Path) -> float:
    """Wall time [s] that the whole run in the folder `run` is predicted to take on one rank, by the costs that are
    shipped: what runs are put in order by, the same everywhere."""
    return predict(load_case(str(run)), 1, SHIPPED, run).wall
