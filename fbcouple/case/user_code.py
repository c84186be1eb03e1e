"""What a case brings that has to be trusted: Python files of its own laws and tasks, which are read here and run only
then; a restart file."""

from __future__ import annotations

import ast
from pathlib import Path

from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

OWN = "own"
DRAG_FILE, NUSSELT_FILE = "exchange.drag_file", "heat.nusselt_file"
LAW_FILES = {
    DRAG_FILE: ("beta", ("voidage", "slip", "diameter", "density", "viscosity")),
    NUSSELT_FILE: ("nusselt", ("voidage", "reynolds", "prandtl")),
}
"""Options that name a file of a law of the case's own: the function in it and its arguments."""
TASK = "Task"
LARGEST = 1_000_000
"""Bytes that such a file may have."""


def list_code(case: Case) -> dict[str, str]:
    """Option -> name of each file of code that `case` brings."""
    return list_law_files(case) | ({"output.task_file": case.output.task_file} if case.output.task_file else {})


def list_law_files(case: Case) -> dict[str, str]:
    """Option -> name of each file with a law that `case` brings."""
    found = {DRAG_FILE: case.exchange.drag_file if case.exchange else None}
    found[NUSSELT_FILE] = case.heat.nusselt_file if case.heat else None
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


def examine_law_file(option: str, path: Path) -> None:
    """Read the file of a law, which `option` of LAW_FILES names, without running it.

    Raises: CaseError (one text, without the key) if it is missing, is not Python, or has no function of that option.
    """
    function, arguments = LAW_FILES[option]
    wanted = f"def {function}({', '.join(arguments)})"
    functions = _parse(path).body
    found = [part for part in functions if isinstance(part, ast.FunctionDef) and part.name == function]
    if not found:
        raise CaseError([f"{path.name} has no function `{function}`; write `{wanted}:` in it."])
    given = [argument.arg for argument in found[-1].args.args]
    if tuple(given) != arguments:
        text = f"{path.name}: `{function}` takes ({', '.join(given)})"
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
