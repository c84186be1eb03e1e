"""What the kinds of new cases have in common: how their text looks, and numbers that are chosen alike."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from pathlib import Path

from fbcouple.case.bed.adopt_inlets import adopt_inlets
from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.speeds import estimate_overlap
from fbcouple.case.schema.sections import Case

HEAD = """\
# `fbcouple options` lists every option, `fbcouple options gas.walls` one of them.
# For completion in an editor with Taplo, write the schema beside this file with
# `fbcouple options --schema > fbcouple.schema.json` and make this the first line: #:schema ./fbcouple.schema.json
"""
COLUMN = 32
"""Column of the comments behind values."""
TRIAL_STIFFNESS = 1000.0
"""Spring [N m-1] that the overlap is looked at with."""


def align(text: str) -> str:
    """Put the comments behind values into their column."""
    return "\n".join(map(_align_line, text.split("\n")))


def _align_line(line: str) -> str:
    value, mark, comment = line.partition("  #")
    return f"{value.rstrip():<{COLUMN}}# {comment.strip()}" if mark and not line.startswith("#") else line


def read(text: str) -> Case:
    """The case that a text describes."""
    return adopt_inlets(Case.model_validate(tomllib.loads(text)))


def round_to(value: float, digits: int = 2) -> float:
    """To so many digits that tell."""
    return float(f"{value:.{digits}g}")


def choose_cells(size: Sequence[float], least: float) -> list[int]:
    """As many cells along each edge as are at least `least` [m] wide."""
    return [max(1, math.floor(edge / least + 1e-6)) for edge in size]


def choose_stiffness(case: Case, overlap: float) -> float:
    """Spring [N m-1] for that `overlap`, in diameters, of a case whose spring is `TRIAL_STIFFNESS`."""
    (found,) = estimate_overlap(case, find_region(case, Path()), None, Path())
    return round_to(TRIAL_STIFFNESS * (float(found.value) / overlap) ** 2)
