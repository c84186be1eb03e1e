"""A new case file, complete, commented and checked: what `fbcouple init` does."""

from __future__ import annotations

import tomllib
from pathlib import Path

from pydantic import ValidationError

import fbcouple.case.kinds.bubbling
import fbcouple.case.kinds.column
import fbcouple.case.kinds.riser
import fbcouple.case.kinds.spout  # noqa: F401  (each registers its kind)
from fbcouple.case.bed.adopt_inlets import adopt_inlets
from fbcouple.case.bed.adopt_spring import adopt_spring
from fbcouple.case.bed.number import Number
from fbcouple.case.checks.registry import list_problems
from fbcouple.case.kinds.registry import KINDS, Wanted
from fbcouple.case.preflight import estimate
from fbcouple.case.presets import apply_preset
from fbcouple.case.problems import show
from fbcouple.case.schema.sections import Case
from fbcouple.case.source import FILE_NAME
from fbcouple.errors import CaseError

LONG = 1.0
"""Edge of a box [m] from which on it may have been given in another unit."""


def write_new_case(folder: Path, kind: str, wanted: Wanted) -> list[Number]:
    """Write `folder`/case.toml of the `kind`, one of KINDS, and nothing else; folders above it are made.

    Returns: the pre-flight numbers of the case.
    Raises: CaseError, before anything is written, if there is such a file, or no case can have what is `wanted`.
    """
    path = folder / FILE_NAME
    if path.exists() or path.is_symlink():
        raise CaseError([f"{show(str(path))}: is there already; give another name, or remove it first."])
    text, numbers = _write_text(kind, wanted)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise CaseError([f"{show(str(path))}: cannot be written ({reason}); give another name."]) from error
    return numbers


def _write_text(kind: str, wanted: Wanted) -> tuple[str, list[Number]]:
    """The text of the case, and its pre-flight numbers."""
    try:
        text = KINDS[kind](wanted)
        raw = tomllib.loads(text)
        apply_preset(raw)
        case = adopt_inlets(Case.model_validate(raw))
        problems = list_problems(case, Path(), set())
        if not problems and case.contact and case.contact.max_overlap is not None:
            case, problems = adopt_spring(case, Path())
    except (ValidationError, ArithmeticError):
        text = "the values are too large or too small to calculate with; give every one in SI units."
        raise CaseError([f"init: {text}"]) from None
    if problems:
        hint = " Lengths are in m." if max(wanted.size or [0.0]) > LONG else ""
        raise CaseError([f"init: {problem}{hint}" for problem in problems])
    return text, estimate(case)
