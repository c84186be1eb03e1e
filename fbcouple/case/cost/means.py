"""How sure the time means of a bubbling bed will be, by the bubble periods that its averaging window holds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from fbcouple.case.bed.particle_types import solids_volume
from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.speeds import SETTLED
from fbcouple.case.schema.output import AUTO, find_first_sample, name_map
from fbcouple.case.schema.sections import Case

PERIODS = 0.7
"""Standard error of the map of vertical solids flux over the map, times the root of the bubble periods averaged."""
MIRRORED = 0.8
"""What it is times where samples are averaged with their mirror images in x: 0.59 to 0.93 in six of Patil's beds."""
FACTOR = 2.5
"""Factor within which eight of twelve beds are of it; one whose flow turns round once in many seconds misses by up to
six."""
START_UP = 4.0
"""Bubble periods that a start-up is taken to last where the run finds its end itself: mueller/0.9 in a box half as wide
took one, patil/c1 about sixteen."""


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
    is 2 pi sqrt(H/g) of the bed's height at rest H: that of a bed that sloshes, or of the bubbles that leave it. Where
    the run finds its start-up itself, that is taken to last `START_UP` of them, and a third of the run at most.
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
    is_found = averages.start == AUTO
    begin = START_UP * period if is_found else find_first_sample(averages)
    scatter = PERIODS * (MIRRORED if "x" in averages.mirror else 1.0)
    if wanted:
        window = period * (scatter / wanted) ** 2
        sure_at = begin + (max(window, 2.0 * begin) if is_found else window)  # a third is left out at most
        end = min(end, max(sure_at, averages.earliest_end or 0.0))
    window = end - (min(begin, end / 3.0) if is_found else begin)
    return Sureness(scatter * math.sqrt(period / window), FACTOR, window, period, end, wanted)
