"""A candidate of a plan: numerics, length of the means, replicas and ranks, with what it errs and what it costs."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fbcouple.case.checks.mirror import find_one_sided
from fbcouple.case.cost.coefficients import Coefficients
from fbcouple.case.cost.means import FACTOR, PERIODS, Sureness
from fbcouple.case.cost.prediction import Prediction, predict
from fbcouple.case.cost.ranks import count_worked
from fbcouple.case.cost.work import count_work
from fbcouple.case.load import load_case
from fbcouple.case.plan.knobs import Numerics
from fbcouple.case.schema.output import AUTO
from fbcouple.case.schema.sections import Case
from fbcouple.case.seeds import change_seeds
from fbcouple.errors import CaseError

LIMIT = FACTOR**2
"""Window of the means at most, over the one told: in it an error that is `FACTOR` larger becomes the wanted one."""
LARGEST = PERIODS / math.sqrt(2.0)
"""`averages.until_error` at most: a run tells no error of less than about one bubble period; two are room."""
SMALLEST, HALVINGS = 1e-4, 14
"""Least statistical error that is looked for, and how often its logarithm's range is halved."""
FITTING = 10.0
"""`end_time` [s] at least of a case that is given means, until the plan finds its own."""
MIRROR = "averages.mirror"
_LONG = 1e6
"""An end [s] that comes after any means that could be wanted."""


@dataclass(frozen=True)
class Member:
    """Numerics, the case that they make, and the contacts of a particle in it."""

    numerics: Numerics
    case: Case
    contacts: float


@dataclass(frozen=True)
class Candidate:
    """`replicas` of a run on `ranks` each, that ends at the standard error `until_error` of its means; what is
    predicted of one."""

    numerics: Numerics
    replicas: int
    ranks: int
    until_error: float
    prediction: Prediction

    @property
    def means(self) -> Sureness:
        """How sure the means of a replica are at its end."""
        assert self.prediction.means is not None
        return self.prediction.means

    @property
    def statistical(self) -> float:
        """Standard error of the means of all replicas."""
        return self.means.error / math.sqrt(self.replicas)

    @property
    def error(self) -> float:
        """Numerical and statistical error, in squares."""
        return math.hypot(self.numerics.error, self.statistical)

    @property
    def wall(self) -> float:
        """Wall time [s] where all replicas run side by side."""
        return self.prediction.wall

    @property
    def core_hours(self) -> float:
        """Of all replicas [h]."""
        return self.replicas * self.prediction.core_hours

    @property
    def factor(self) -> float:
        """Factor that its cost is within: that of the prediction and, by their share, that of the length of means."""
        share = self.means.window / self.means.end
        return math.exp(math.hypot(math.log(self.prediction.factor), share * math.log(LIMIT)))

    @property
    def end_limit(self) -> float:
        """`end_time` [s] of its case: where the run stops that is not sure enough by then, two digits."""
        begin = self.means.end - self.means.window
        unit = 10.0 ** (math.floor(math.log10(wanted := begin + LIMIT * self.means.window)) - 1)
        return float(f"{math.ceil(wanted / unit - 1e-9) * unit:.6g}")

    def format_split(self) -> str:
        """Runs and ranks in words."""
        ranks = f"{self.ranks} rank{'s' if self.ranks > 1 else ''}"
        return f"a run on {ranks}" if self.replicas == 1 else f"{self.replicas} replicas on {ranks} each"

    def list_settings(self) -> dict[str, Any]:
        """What it sets on top of the case."""
        ends = {"end_time": self.end_limit, "averages.until_error": float(f"{self.until_error:.3g}")}
        return dict(self.numerics.settings) | ends

    def describe(self) -> dict[str, Any]:
        """The numbers as tables and files have them."""
        return {
            **self.numerics.words,
            "replicas": self.replicas,
            "ranks": self.ranks,
            "numerical_error": self.numerics.error,
            "statistical_error": self.statistical,
            "error": self.error,
            "until_error": self.until_error,
            "simulated_seconds": self.means.end,
            "averaged_seconds": self.means.window,
            "wall_seconds": self.wall,
            "core_hours": self.core_hours,
            "factor": self.factor,
            "memory_bytes": self.replicas * self.prediction.memory,
            "settings": self.list_settings(),
        }


@dataclass(frozen=True)
class Pricing:
    """Tells what members cost, on a machine of which a step costs `found`; their own files lie in `folder`."""

    found: Coefficients
    folder: Path

    def make(self, member: Member, replicas: int, ranks: int, statistical: float) -> Candidate:
        """The candidate whose means together have the error `statistical`, or a smaller one where a run cannot end so
        early."""
        until = min(statistical * math.sqrt(replicas), LARGEST)
        found = self._predict(member, replicas, ranks, until)
        assert member.case.averages is not None
        least = member.case.averages.blocks * member.case.averages.every
        if found.means.window < least:  # a sample in each block
            found = self._predict(member, replicas, ranks, found.means.error * math.sqrt(found.means.window / least))
        return found

    def _predict(self, member: Member, replicas: int, ranks: int, until: float) -> Candidate:
        assert member.case.averages is not None
        averages = member.case.averages.model_copy(update={"until_error": until})
        case = member.case.model_copy(update={"averages": averages, "end_time": _LONG})
        case.remember_bases(member.case.base_folders)
        told = predict(case, ranks, self.found, self.folder, touching=member.contacts)
        return Candidate(member.numerics, replicas, ranks, until, told)

    def reach(self, member: Member, replicas: int, ranks: int, error: float) -> Candidate | None:
        """The cheapest candidate of these numerics, replicas and ranks with `error`, if there is one."""
        if member.numerics.error >= error:
            return None
        return self.make(member, replicas, ranks, math.sqrt(error**2 - member.numerics.error**2))

    def reach_within(self, member: Member, replicas: int, ranks: int, wall: float) -> Candidate | None:
        """The candidate of these numerics, replicas and ranks with the least error that ends within `wall` [s], if one
        does."""
        low, high = SMALLEST, LARGEST / math.sqrt(replicas)
        best = self.make(member, replicas, ranks, high)
        if best.wall > wall:
            return None
        for _ in range(HALVINGS):
            middle = math.sqrt(low * high)
            found = self.make(member, replicas, ranks, middle)
            if found.wall <= wall:
                best, high = found, middle
            else:
                low = middle
        return best


def make_member(name: str, sets: Sequence[str], numerics: Numerics, folder: Path) -> Member:
    """The case `name` with `sets` and the settings of `numerics` on top. Raises: CaseError if that is no case."""
    case = load_case(name, [*sets, *format_settings(numerics.settings)])
    return Member(numerics, case, count_work(case, folder).contacts)


def format_settings(settings: dict[str, Any]) -> list[str]:
    """Settings as `--set` takes them."""
    return [f"{key}={json.dumps(value)}" for key, value in settings.items()]


def list_splits(case: Case, ranks: int, folder: Path) -> Iterator[tuple[int, int]]:
    """Replicas and the ranks of each, powers of two and the most: what `ranks` cores can do with `case`, whose own
    files lie in `folder`, with work enough for each rank."""
    try:
        change_seeds(case, 1)
        can_be_another = True
    except CaseError:
        can_be_another = False
    work = count_work(case, folder)
    for each in _list_powers(min(ranks, count_worked(work.cells, int(work.particles)))):
        for replicas in _list_powers(ranks // each) if can_be_another else [1]:
            yield replicas, each


@functools.cache
def _list_powers(most: int) -> list[int]:
    return sorted({*(2**n for n in range(most.bit_length())), most})


def list_averages(case: Case, held: Sequence[str]) -> list[str]:
    """Settings that give a case without means some from where its start-up ends, and a run that they fit into; and
    mirror images in x where the bed is its own and `held`, the keys that are set, do not say."""
    found = [] if case.averages else [f'averages.start="{AUTO}"', f"end_time={max(case.end_time, FITTING):g}"]
    is_asked = MIRROR in held or (case.averages and case.averages.mirror)
    return found if is_asked or any(find_one_sided(case, "x")) else [*found, f'{MIRROR}=["x"]']
