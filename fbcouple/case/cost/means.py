"""How sure the time means of a bubbling bed will be, by the bubble periods that its averaging window holds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from fbcouple.case.bed.particle_types import solids_volume
from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.speeds import SETTLED
from fbcouple.case.schema.output import name_map
from fbcouple.case.schema.sections import Case

PERIODS = 0.38
"""Standard error of the map of vertical solids flux over the map, times the root of the bubble periods averaged."""
FACTOR = 1.5
"""Factor within which most beds are of it; one whose flow turns round once in many seconds misses by up to ten."""


@dataclass(frozen=True)
class Sureness:
    """Standard error of the mean map of solids flux over the map, root mean square, and when the run ends [s].

    window: that is averaged [s]; period: of bubbles [s]; wanted: `averages.until_error`.
    """

    error: float
    factor: float
    window: float
    period: float
    end: float
    wanted: float | None = None

    @property
    def periods(self) -> float:
        """Bubble periods in the window."""
        return self.window / self.period


def predict_means(case: Case, folder: Path = Path()) -> Sureness | None:
    """The error of the means of `case` at its end, or with `averages.until_error` when that is reached.

    None where there are no means, no bed under gravity and gas, or another map than the flux is asked for. The period
    is 2 pi sqrt(H/g) of the bed's height at rest H: that of a bed that sloshes, or of the bubbles that leave it.
    """
    averages, particles = case.averages, case.particles
    if averages is None or particles is None or case.gas is None or case.exchange is None or case.gravity == 0.0:
        return None
    solids = solids_volume(particles)
    if not solids or particles.feeds or (averages.until_error and name_map(averages, True) != "solids_flux"):
        return None
    height = find_region(case, folder).find_level(solids / SETTLED)
    period = 2.0 * math.pi * math.sqrt(height / case.gravity)
    end, wanted = case.end_time, averages.until_error
    if wanted:
        end = min(end, averages.start + period * (PERIODS / wanted) ** 2)
    window = end - averages.start
    return Sureness(PERIODS * math.sqrt(period / window), FACTOR, window, period, end, wanted)
