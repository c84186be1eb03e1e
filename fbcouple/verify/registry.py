"""Scenes by name. To add one: a generator of `Number` under `@check("name")` in a module listed in `MODULES`.

A check runs in a process of its own (a solver is opened once a process), on `ranks` MPI ranks. `fast` checks make up
the subset that every test run does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from typing import Any

MODULES = (
    "contact",
    "single_impact",
    "friction",
    "rest",
    "packed",
    "poured",
    "oblique",
    "hertz",
    "overlap",
    "gas",
    "turbulence",
    "manufactured",
    "bed",
    "fall",
    "forces",
    "conservation",
    "kernels",
    "fluidization",
    "inlet",
    "inlet_faces",
    "openings",
    "opening_profiles",
    "mixture",
    "cylinder",
    "weight",
    "vessel",
    "unequal_steps",
    "mesh_file",
    "traffic",
    "removal",
    "parcels",
    "settling",
    "standard_errors",
    "replicas",
    "cost",
    "start_up",
    "heat_contacts",
    "heat_gas",
    "heat_inlets",
    "ideal_gas",
)


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

    def as_row(self, check: str, seconds: float) -> dict[str, Any]:
        """A row of the `verify --json` table."""
        row = asdict(self) | {"name": f"{check}: {self.name}", "passed": self.passed, "seconds": seconds}
        return row | {"tolerance": self.tolerance * abs(self.expected) if self.relative else self.tolerance}


def name_variants(measured: dict[str, list[Number]]) -> Iterator[Number]:
    """For the judge of a check: the numbers of all variants, each with its variant in front."""
    for variant, numbers in measured.items():
        yield from (replace(number, name=f"{variant}: {number.name}") for number in numbers)


Function = Callable[..., Iterator[Number]]
Judge = Callable[[dict[str, list[Number]]], Iterator[Number]]


@dataclass(frozen=True)
class Check:
    """A check of the suite: what it does, on how many ranks, and whether it is in the fast subset.

    With `variants` the function runs once for each, in a process of its own, and `judge` makes the check's numbers
    from theirs: an order of convergence from the errors of several meshes.
    """

    name: str
    function: Function
    ranks: tuple[int, ...]
    fast: bool
    variants: tuple[str, ...] = ()
    judge: Judge | None = None


CHECKS: dict[str, Check] = {}


def check(
    name: str,
    ranks: tuple[int, ...] = (1,),
    fast: bool = True,
    variants: tuple[str, ...] = (),
    judge: Judge | None = None,
) -> Callable[[Function], Function]:
    """Register a check; its function gets an empty folder, the communicator and its variant if there are variants,
    and yields its numbers, the same on all ranks."""

    def register(function: Function) -> Function:
        assert name not in CHECKS, f"two checks have the name {name}"
        CHECKS[name] = Check(name, function, ranks, fast, variants, judge)
        return function

    return register


def load_checks() -> dict[str, Check]:
    """Every registered check by name."""
    for module in MODULES:
        import_module(f"fbcouple.verify.{module}")
    return CHECKS
