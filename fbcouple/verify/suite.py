"""Run scenes one after the other, each in processes of its own, and collect their numbers."""

from __future__ import annotations

import difflib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from fbcouple.errors import CaseError, SolverError
from fbcouple.machine.environment import mpi_command, mpi_environment
from fbcouple.verify.process import NUMBERS
from fbcouple.verify.registry import Number, Scene, load_scenes

_TAIL = 12


def choose_scenes(names: Sequence[str], fast: bool) -> list[Scene]:
    """The scenes of `names`, or all; only the fast ones if `fast`. Raises CaseError with a suggestion."""
    scenes = load_scenes()
    problems = []
    for name in names:
        if name not in scenes:
            near = difflib.get_close_matches(name, scenes, 1)
            hint = f"did you mean {near[0]}?" if near else f"allowed: {', '.join(scenes)}"
            problems.append(f"verify: no scene {name!r}; {hint}")
    if problems:
        raise CaseError(problems)
    return [scenes[name] for name in names or scenes if not fast or scenes[name].fast]


def run_scenes(scenes: Sequence[Scene]) -> Iterator[dict[str, Any]]:
    """Rows of the numbers of each scene on each of its rank counts, as they come."""
    for scene in scenes:
        for ranks in scene.ranks:
            label = scene.name if len(scene.ranks) == 1 else f"{scene.name} -n {ranks}"
            begin = time.monotonic()
            numbers = _run_scene(scene, ranks)
            seconds = time.monotonic() - begin
            for number in numbers:
                yield number.as_row(label, seconds)


def _run_scene(scene: Scene, ranks: int) -> list[Number]:
    if scene.judge is None:
        return _run_process(scene, ranks, [])
    measured = {variant: _run_process(scene, ranks, [variant]) for variant in scene.variants}
    return list(scene.judge(measured))


def _run_process(scene: Scene, ranks: int, variant: list[str]) -> list[Number]:
    with tempfile.TemporaryDirectory(prefix="fbcouple-verify-") as place:
        program = [sys.executable, "-m", "fbcouple.verify.process", scene.name, place, *variant]
        environment = mpi_environment() | {"PWD": os.getcwd()}
        command = mpi_command(ranks, program)
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, check=False, encoding="utf-8", errors="replace"
        )
        if done.returncode:
            words = "\n".join((done.stdout + done.stderr).strip().splitlines()[-_TAIL:])
            raise SolverError(f"verify {scene.name} on {ranks} ranks failed:\n{words}")
        return [Number(**row) for row in json.loads((Path(place) / NUMBERS).read_text(encoding="utf-8"))]
