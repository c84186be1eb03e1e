"""The tasks that a case brings: classes of `Task` in a Python file beside it, which is run."""

from __future__ import annotations

import runpy
from collections.abc import Sequence
from pathlib import Path

from fbcouple.errors import CaseError
from fbcouple.simulation.tasks.task import Task, name_task

_MODULE = "task_file"


def load_tasks(path: Path) -> list[Task]:
    """Run the file `path` and make a task of each class of `Task` in it, in their order, without arguments.

    Raises: CaseError if it cannot be run.
    """
    key = f"output.task_file: {path.name}"
    try:
        found = runpy.run_path(str(path), run_name=_MODULE)
        kinds = [kind for kind in found.values() if isinstance(kind, type) and issubclass(kind, Task)]
        return [kind() for kind in kinds if kind.__module__ == _MODULE]
    except Exception as error:  # whatever the user's file raises is the user's to read
        raise CaseError([f"{key}: fails ({type(error).__name__}: {error}); fix the file."]) from error


def require_names(tasks: Sequence[Task]) -> None:
    """Raise CaseError unless each of `tasks` is of a class with a name of its own, by which a checkpoint knows it."""
    names = [name_task(task) for task in tasks]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise CaseError([f"two tasks are named {' and '.join(twice)}; give the class of one of them another name."])
