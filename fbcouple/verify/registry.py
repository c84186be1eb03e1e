"""Scenes by name. To add one: a generator of `Number` under `@scene("name")` in a module listed in `MODULES`.

A scene runs in a process of its own (a solver is opened once a process), on `ranks` MPI ranks. `fast` scenes make up
the subset that every test run does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from mpi4py import MPI

MODULES = ("contact",)


@dataclass(frozen=True)
class Number:
    """A measured value against what is expected; `tolerance` is absolute, in `unit`, unless `relative` is said."""

    name: str
    value: float
    expected: float
    tolerance: float
    unit: str = "1"
    relative: bool = False

    @property
    def passed(self) -> bool:
        """Is the value within the tolerance? A value that is not a number is not."""
        allowed = self.tolerance * abs(self.expected) if self.relative else self.tolerance
        return abs(self.value - self.expected) <= allowed

    def as_row(self, scene: str, seconds: float) -> dict[str, Any]:
        """A row of the `verify --json` table."""
        row = asdict(self) | {"name": f"{scene}: {self.name}", "passed": self.passed, "seconds": seconds}
        return row | {"tolerance": self.tolerance * abs(self.expected) if self.relative else self.tolerance}


Function = Callable[[Path, MPI.Comm], Iterator[Number]]


@dataclass(frozen=True)
class Scene:
    """A scene of the suite: what it does, on how many ranks, and whether it is in the fast subset."""

    name: str
    function: Function
    ranks: tuple[int, ...]
    fast: bool


SCENES: dict[str, Scene] = {}


def scene(name: str, ranks: tuple[int, ...] = (1,), fast: bool = True) -> Callable[[Function], Function]:
    """Register a scene; its function gets an empty folder and the communicator, and yields its numbers on rank 0."""

    def register(function: Function) -> Function:
        SCENES[name] = Scene(name, function, ranks, fast)
        return function

    return register


def load_scenes() -> dict[str, Scene]:
    """Every registered scene by name."""
    for module in MODULES:
        import_module(f"fbcouple.verify.{module}")
    return SCENES
