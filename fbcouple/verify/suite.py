"""Run checks one after the other, each in processes of its own, and collect their numbers."""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from fbcouple.case.problems import show, write_hint
from fbcouple.errors import CaseError, SolverError
from fbcouple.machine.environment import mpi_environment
from fbcouple.machine.launchers import mpi_command
from fbcouple.machine.programs import run_program
from fbcouple.verify.process import NUMBERS
from fbcouple.verify.registry import Check, Number, load_checks

_TAIL = 12


def choose_checks(names: Sequence[str], fast: bool) -> list[Check]:
    """The checks of `names`, or all; only the fast ones if `fast`. Raises CaseError with a suggestion."""
    checks = load_checks()
    problems = []
    for name in names:
        if name not in checks:
            hint = write_hint(name, checks, f"allowed are: {', '.join(checks)}")
            problems.append(f"verify: {show(name)}: no check{hint}.")
    if problems:
        raise CaseError(problems)
    return [checks[name] for name in names or checks if not fast or checks[name].fast]


def run_checks(checks: Sequence[Check]) -> Iterator[dict[str, Any]]:
    """Rows of the numbers of each check on each of its rank counts, as they come."""
    for check in checks:
        for ranks in check.ranks:
            label = check.name if len(check.ranks) == 1 else f"{check.name} -n {ranks}"
            begin = time.monotonic()
            numbers = _run_check(check, ranks)
            seconds = time.monotonic() - begin
            for number in numbers:
                yield number.as_row(label, seconds)


def _run_check(check: Check, ranks: int) -> list[Number]:
    if check.judge is None:
        return _run_process(check, ranks, [])
    measured = {variant: _run_process(check, ranks, [variant]) for variant in check.variants}
    return list(check.judge(measured))


def _run_process(check: Check, ranks: int, variant: list[str]) -> list[Number]:
    with tempfile.TemporaryDirectory(prefix="fbcouple-verify-") as folder:
        program = [sys.executable, "-m", "fbcouple.verify.process", check.name, folder, *variant]
        environment = mpi_environment() | {"PWD": os.getcwd()}
        command = mpi_command(ranks, program)
        done = run_program(command, environment)
        if done.returncode:
            words = "\n".join((done.stdout + done.stderr).strip().splitlines()[-_TAIL:])
            raise SolverError(f"verify {check.name} on {ranks} ranks failed:\n{words}")
        return [Number(**row) for row in json.loads((Path(folder) / NUMBERS).read_text(encoding="utf-8"))]
