"""What a case brings that has to be trusted: Python files of its own drag law and tasks, which are read here and run
only then; a restart file."""

from __future__ import annotations

import ast
from pathlib import Path

from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

OWN = "own"
FUNCTION = "beta"
ARGUMENTS = ("voidage", "slip", "diameter", "density", "viscosity")
TASK = "Task"
LARGEST = 1_000_000
"""Bytes that such a file may have."""


def list_code(case: Case) -> dict[str, str]:
    """Option -> name of each file of code that `case` brings."""
    found = {"exchange.drag_file": case.exchange.drag_file if case.exchange else None}
    found["output.task_file"] = case.output.task_file
    return {key: name for key, name in found.items() if name}


def require_trust(case: Case, trusted: bool) -> None:
    """Raise CaseError if `case` brings code, or what nothing can check, and the caller has not said to trust it."""
    text = "is Python code, which a run executes; read it, and if you trust it say --trust."
    problems = [f"{key}: {name} {text}" for key, name in list_code(case).items()]
    if case.start is not None and case.start.restart is not None:
        text = f"start.restart: {case.start.restart} is a restart file, which LIGGGHTS reads and nothing can check"
        mend = "if you trust who wrote it say --trust, or give what `write_data` writes of it as particles.positions."
        problems.append(f"{text}; {mend}")
    if problems and not trusted:
        raise CaseError(problems)


def examine_drag_file(path: Path) -> None:
    """Read a drag file without running it.

    Raises: CaseError (one text, without the key) if it is missing, is not Python, or has no
    `beta(voidage, slip, diameter, density, viscosity)`.
    """
    wanted = f"def {FUNCTION}({', '.join(ARGUMENTS)})"
    functions = _parse(path).body
    found = [part for part in functions if isinstance(part, ast.FunctionDef) and part.name == FUNCTION]
    if not found:
        raise CaseError([f"{path.name} has no function `{FUNCTION}`; write `{wanted}:` in it."])
    given = [argument.arg for argument in found[-1].args.args]
    if tuple(given) != ARGUMENTS:
        text = f"{path.name}: `{FUNCTION}` takes ({', '.join(given)})"
        raise CaseError([f"{text}; write `{wanted}:`, all numbers in SI units."])


def examine_task_file(path: Path) -> None:
    """Read a file of tasks without running it.

    Raises: CaseError (one text, without the key) if it is missing, is not Python, or has no class of `Task`.
    """
    classes = [part for part in _parse(path).body if isinstance(part, ast.ClassDef)]
    if not any(ast.unparse(base).rpartition(".")[2] == TASK for part in classes for base in part.bases):
        raise CaseError([f"{path.name} has no class of fbcouple.Task; write `class Mine(fbcouple.Task):` in it."])


def _parse(path: Path) -> ast.Module:
    try:
        if path.stat().st_size > LARGEST:
            raise CaseError([f"{path.name} is larger than {LARGEST / 1e6:g} MB; such a file has a few lines."])
        return ast.parse(path.read_bytes())
    except OSError as error:
        raise CaseError([f"{path.name} cannot be read: {error.strerror}; put it beside the case file."]) from None
    except (SyntaxError, ValueError, RecursionError) as error:
        line = f", line {error.lineno}" if isinstance(error, SyntaxError) else ""
        raise CaseError([f"{path.name} is not Python{line}; fix it."]) from None
