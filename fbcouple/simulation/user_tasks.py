"""The tasks that a case brings: classes of `Task` in a Python file beside it, which is run."""

from __future__ import annotations

import runpy
from collections.abc import Sequence
from pathlib import Path

from fbcouple.errors import CaseError
from fbcouple.simulation.tasks.task import Task

_MODULE = "task_file"


def load_tasks(path: Path, others: Sequence[Task]) -> list[Task]:
    """Run the file `path` and make a task of each class of `Task` in it, in their order, without arguments.

    Raises: CaseError if it cannot be run, or a class has the name of one of `others`, by which a checkpoint knows it.
    """
    key = f"output.task_file: {path.name}"
    try:
        found = runpy.run_path(str(path), run_name=_MODULE)
        kinds = [kind for kind in found.values() if isinstance(kind, type) and issubclass(kind, Task)]
        tasks = [kind() for kind in kinds if kind.__module__ == _MODULE]
    except Exception as error:  # whatever the user's file raises is the user's to read
        raise CaseError([f"{key}: fails ({type(error).__name__}: {error}); fix the file."]) from error
    taken = {type(task).__name__ for task in others} & {type(task).__name__ for task in tasks}
    if taken:
        raise CaseError(
            [f"{key}: {', '.join(sorted(taken))} is a task of fbcouple's own; give the class another name."]
        )
    return tasks
