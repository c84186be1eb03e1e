"""A case's own drag law: a Python file beside the case. It is code, so it is read here and run only when trusted."""

from __future__ import annotations

import ast
from pathlib import Path

from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

OWN = "own"
FUNCTION = "beta"
ARGUMENTS = ("voidage", "slip", "diameter", "density", "viscosity")
LARGEST = 1_000_000
"""Bytes that a drag file may have."""


def examine_drag_file(path: Path) -> None:
    """Read a drag file without running it.

    Raises: CaseError (one text, without the key) if it is missing, is not Python, or has no
    `beta(voidage, slip, diameter, density, viscosity)`.
    """
    wanted = f"def {FUNCTION}({', '.join(ARGUMENTS)})"
    try:
        if path.stat().st_size > LARGEST:
            raise CaseError([f"{path.name} is larger than {LARGEST / 1e6:g} MB; a drag law has a few lines."])
        functions = ast.parse(path.read_bytes()).body
    except OSError as error:
        raise CaseError([f"{path.name} cannot be read: {error.strerror}; put it beside the case file."]) from None
    except (SyntaxError, ValueError, RecursionError) as error:
        line = f", line {error.lineno}" if isinstance(error, SyntaxError) else ""
        raise CaseError([f"{path.name} is not Python{line}; mend it."]) from None
    found = [part for part in functions if isinstance(part, ast.FunctionDef) and part.name == FUNCTION]
    if not found:
        raise CaseError([f"{path.name} has no function `{FUNCTION}`; write `{wanted}:` in it."])
    given = [argument.arg for argument in found[-1].args.args]
    if tuple(given) != ARGUMENTS:
        text = f"{path.name}: `{FUNCTION}` takes ({', '.join(given)})"
        raise CaseError([f"{text}; write `{wanted}:`, all numbers in SI units."])


def require_trust(case: Case, trusted: bool) -> None:
    """Raise CaseError if `case` brings code and the caller has not said that it may run."""
    if case.exchange and case.exchange.drag_file and not trusted:
        text = f"{case.exchange.drag_file} is Python code, which a run executes"
        raise CaseError([f"exchange.drag_file: {text}; read it, and if you trust it say --trust."])
