"""Wall time, core-hours and memory of a run on so many ranks, each with a factor that it is likely within."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fbcouple.case.bed.number import Law
from fbcouple.case.cost.coefficients import USUAL_DIGITS, Coefficients, load_coefficients
from fbcouple.case.cost.means import Sureness, predict_means
from fbcouple.case.cost.memory import FACTOR, find_memory
from fbcouple.case.cost.work import Work, count_work, share_ghosts
from fbcouple.case.load import load_case
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

MODEL = 1.15
"""Factor within which the model meets runs whose work is known, on the machine that it was measured on."""
CONTACTS = 2.0
"""Factor of the contacts a particle."""
STEPS = 1.2
"""Factor of the fluid steps."""
MESH = 1.5
"""Factor of gas and exchange on a mesh that is no plain box, which nothing was measured on."""
DOUBLING = 1.1
"""Factor for each doubling of the ranks beyond the two that are measured."""
PHASES = {"dem": ("dem",), "cfd": ("cfd",), "exchange": ("map", "drag", "react")}
"""What is predicted -> stages of the loop; means, records and waiting are not."""


@dataclass(frozen=True)
class Prediction:
    """What a run takes: seconds of wall time by `stages` ("start-up" among them), bytes over all ranks, and factors.

    A true value is expected between the one told over its factor and the one told times it.
    """

    ranks: int
    work: Work
    stages: dict[str, float]
    factor: float
    memory: float
    memory_factor: float
    means: Sureness | None
    measured: str

    @property
    def wall(self) -> float:
        """Wall time [s] where every rank has a core of its own."""
        return sum(self.stages.values())

    @property
    def core_hours(self) -> float:
        """Wall time times the ranks [h]."""
        return self.wall * self.ranks / 3600.0

    def describe(self) -> dict[str, Any]:
        """The numbers as tables and files have them."""
        return {
            "ranks": self.ranks,
            "wall_seconds": self.wall,
            "wall_factor": self.factor,
            "core_hours": self.core_hours,
            "memory_bytes": self.memory,
            "memory_factor": self.memory_factor,
            "stages": dict(self.stages),
            "simulated_seconds": self.work.seconds,
            "dem_steps": self.work.dem_steps,
            "fluid_steps": self.work.fluid_steps,
            "means_error": self.means.error if self.means else None,
            "means_factor": self.means.factor if self.means else None,
            "coefficients": self.measured or "shipped",
        }


def predict(
    case: Case,
    ranks: int,
    found: Coefficients,
    folder: Path = Path(),
    law: Law | None = None,
    touching: float | None = None,
) -> Prediction:
    """Predict what `case` costs on `ranks` ranks, from its start to its end.

    found: what this machine takes for a step; folder: where the case's own files lie; law: the case's own drag law;
    touching: as `count_work`.

    Raises: CaseError if the values of the case are too large or small to calculate with.
    """
    try:
        return _predict(case, ranks, found, folder, law, touching)
    except ArithmeticError:
        text = "the values are too large or too small to calculate with; give every one in SI units."
        raise CaseError([f"case: {text}"]) from None


def predict_run(run: Path, ranks: int, say: Callable[[str], None]) -> dict[str, Any] | None:
    """What the run in `run` is predicted to cost on this machine, as `Prediction.describe` has it, or None where that
    cannot be told, of which `say` is told: it is no reason not to run."""
    try:
        return predict(load_case(str(run / "case.toml")), ranks, load_coefficients(), run).describe()
    except CaseError as error:
        say(f"{run}: what it will cost is not predicted: {error}")
        return None


def _predict(
    case: Case, ranks: int, found: Coefficients, folder: Path, law: Law | None, touching: float | None
) -> Prediction:
    means = predict_means(case, folder)
    work = count_work(case, folder, law, means.end if means else None, touching)
    stages = {"start-up": found.start_up + found.start_cell * work.cells}
    stages |= time_stages(work, found, ranks, share_ghosts(case, ranks))
    return Prediction(
        ranks=ranks,
        work=work,
        stages=stages,
        factor=combine_factors(work, found, ranks, stages),
        memory=find_memory(case, folder, ranks, found),
        memory_factor=FACTOR,
        means=means,
        measured=found.measured,
    )


def time_stages(work: Work, found: Coefficients, ranks: int = 1, ghosts: float = 0.0) -> dict[str, float]:
    """Wall seconds of the stages dem, cfd and exchange, those that `work` has, on `ranks` ranks.

    ghosts: particles of other ranks that a rank looks at, over its own: it works on them as on its own.
    """
    part = {stage: (found.shared[stage] if ranks > 1 else 1.0) / ranks for stage in PHASES}
    stages = {}
    if work.dem_steps:
        each = _cost_alone(work, found) + found.contact[work.law] * work.contacts
        own = each * work.particles * part["dem"] * (1.0 + ghosts)
        stages["dem"] = work.dem_steps * (found.dem_step + own) + work.turnovers * found.turnover
    if work.cells:
        pressure = found.corrector * work.correctors * work.digits / USUAL_DIGITS
        subgrid = 0.0 if work.subgrid == "none" else found.subgrid[work.subgrid]
        own = work.cells * (found.cell + pressure + subgrid) * part["cfd"]
        stages["cfd"] = work.fluid_steps * (found.fluid_step + own)
    if work.is_coupled:
        own = work.particles * found.exchange_particle + work.cells * found.exchange_cell
        stages["exchange"] = work.fluid_steps * (found.exchange_step + own * part["exchange"])
    return stages


def _cost_alone(work: Work, found: Coefficients) -> float:
    """Seconds of a particle and DEM step without its contacts."""
    if not work.is_bed:
        return found.particle
    return found.particle + found.neighbour + found.rebuild * work.rebuilds / work.dem_steps


def combine_factors(work: Work, found: Coefficients, ranks: int, stages: dict[str, float]) -> float:
    """Factor of the wall time: what is unsure of each stage by its share, and of them all, added in squares of logs."""
    whole = sum(stages.values())
    share = {name: seconds / whole for name, seconds in stages.items()}
    fluid = share.get("cfd", 0.0) + share.get("exchange", 0.0)
    touching = 0.0
    if work.dem_steps:
        touch = found.contact[work.law] * work.contacts
        touching = share["dem"] * touch / (_cost_alone(work, found) + touch)
    unsure = [
        math.log(MODEL),
        math.log(found.spread),
        touching * math.log(CONTACTS),
        fluid * math.log(STEPS),
        0.0 if work.is_box else fluid * math.log(MESH),
        math.log(DOUBLING) * max(0.0, math.log2(ranks) - 1.0),
    ]
    return math.exp(math.hypot(*unsure))
