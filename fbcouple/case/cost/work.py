"""How much a run has to do: DEM steps, fluid steps, particles, contacts, cells, and the share of a rank."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from fbcouple.case.bed.derived import (
    dem_step,
    fastest_inflow,
    fastest_inlet,
    inlet_ramp,
    inlet_speed,
    neighbour_skin,
    tangential_law,
)
from fbcouple.case.bed.drag_balance import EXPANDED, minimum_fluidization
from fbcouple.case.bed.feeds import find_rate
from fbcouple.case.bed.fluid_step import gas_step
from fbcouple.case.bed.number import Law
from fbcouple.case.bed.particle_types import largest_diameter, mean_density, particle_count, solids_volume
from fbcouple.case.bed.region import Region, find_region
from fbcouple.case.bed.speeds import SETTLED
from fbcouple.case.bed.step_limits import Limits, measure_limits
from fbcouple.case.preflight import JET
from fbcouple.case.schema.feeds import Feed
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import OWN
from fbcouple.geometry.partition import find_rank_grid

LIVELY = 0.65
"""Fluid steps that moving beds take, over those that the Courant limit allows at U_f/0.40: the gas between bubbles and
above the bed is faster."""
RESTING, SPOUTED, BUBBLING, DILUTE = 2.4, 1.9, 0.5, 0.0
"""Contacts a particle, pairs that touch over the particles: of a bed at rest, of one that a jet passes, of one that
bubbles as a whole, whose particles hit and part, and of particles that the gas carries."""
FASTEST, CREEP = 1.2, 0.02
"""Speed of the fastest particle of a bed that moves over sqrt(g H), H the height at rest; of one at rest [m/s]."""
LOOSE = 0.1
"""Mean solids fraction of the whole region below which particles that gas carries away hardly touch."""
_PIECES = 200
_SKIN = 1.3
"""Reach of the neighbour lists over the diameter."""


@dataclass(frozen=True)
class Work:
    """What a run does from its start to its end; zeros for a phase that it has not.

    particles: mean number over the run, of a coarse-grained bed that of parcels; contacts: a particle, on the mean;
    is_bed: particles have others around them; law: of the contacts, as `Coefficients.contact` names it; rebuilds: new
    lists of neighbours; turnovers: fluid steps in which feeds put particles in; digits: decades that a pressure solve
    takes its residual down; subgrid: model of the gas, or "none".
    """

    seconds: float
    particles: float
    contacts: float
    is_bed: bool
    law: str
    dem_steps: int
    rebuilds: float
    turnovers: float
    cells: int
    fluid_steps: float
    correctors: int
    digits: float
    subgrid: str
    is_box: bool

    @property
    def is_coupled(self) -> bool:
        """Are there both phases?"""
        return self.particles > 0.0 and self.cells > 0


def count_work(
    case: Case,
    folder: Path = Path(),
    law: Law | None = None,
    end: float | None = None,
    touching: float | None = None,
) -> Work:
    """What a run of `case` up to `end` [s], by default its end_time, has to do.

    folder: where the case's own files lie; law: the case's own drag law, if it brings one that is trusted; touching:
    contacts a particle, where they are known; by default by the state that the bed will be in.
    """
    seconds, region = end or case.end_time, find_region(case, folder)
    particles, steps, contacts, name, rebuilds = 0.0, 0, 0.0, "", 0.0
    if case.particles and case.contact:
        particles = _average_particles(case, seconds)
        steps = count_dem_steps(case, seconds)
        contacts = _guess_contacts(case, region, law) if touching is None else touching
        name = name_law(case)
        rebuilds = min(steps, seconds * _guess_speed(case, region, contacts) / (0.5 * _find_skin(case)))
    gas = case.gas
    fluid_steps, carried = 0.0, case.gravity > 0.0 and bool(case.particles) and contacts == DILUTE
    if gas:
        fluid_steps = count_fluid_steps(case, seconds, measure_limits(case, folder), carried)
    return Work(
        seconds=seconds,
        particles=particles,
        contacts=contacts,
        is_bed=contacts > DILUTE,
        law=name,
        dem_steps=steps,
        rebuilds=rebuilds,
        turnovers=_count_turnovers(case, seconds, fluid_steps),
        cells=region.cells if gas else 0,
        fluid_steps=fluid_steps,
        correctors=gas.correctors if gas else 0,
        digits=count_digits(gas.pressure_tolerance, gas.max_courant) if gas else 0.0,
        subgrid=gas.turbulence if gas else "none",
        is_box=case.domain.is_plain_box,
    )


def count_dem_steps(case: Case, seconds: float) -> int:
    """DEM steps of a run of `seconds` [s]: exact, for its last fluid step is cut to end with it."""
    assert case.particles is not None and case.contact is not None
    return math.ceil(seconds / dem_step(case.contact, case.particles) - 1e-6)


def count_fluid_steps(case: Case, seconds: float, limits: Limits | None = None, carried: bool = False) -> float:
    """Fluid steps of a run of `seconds` [s]: those of the case's limits at the inlet's speed of each time, by the
    Courant number `LIVELY` as long, in whole DEM steps, and one a DEM step at least.

    limits: those by the mesh, as `gas_step` has them; carried: there is no bed, the gas carries the particles, and is
    hardly faster than where it comes in.
    """
    assert case.gas is not None
    pieces = _PIECES if len(inlet_ramp(case.gas)) > 1 else 1
    limits = limits or measure_limits(case, None)
    fastest, width = fastest_inlet(case.gas), seconds / pieces
    held = dem_step(case.contact, case.particles) if case.particles and case.contact else 0.0
    share, longer = (EXPANDED, 1.0) if carried else (1.0, LIVELY)
    steps = 0.0
    for number in range(pieces):
        speed = inlet_speed(case.gas, (number + 0.5) * width)
        step = gas_step(case, share * speed / fastest if fastest else 0.0, limits, longer)
        if held:
            step = held * max(1.0, step / held - 0.5)  # rounded down: half a DEM step is lost on the mean
        steps += width / step
    return steps


def count_digits(tolerance: float, courant: float) -> float:
    """Decades that a pressure solve takes its residual down: it starts at about 0.2 of the Courant number."""
    return max(1.0, math.log10(0.2 * min(courant, 5.0) / tolerance))


def name_law(case: Case) -> str:
    """The law of the contacts as `Coefficients.contact` names it: the model, and whether friction remembers."""
    assert case.contact is not None
    history = tangential_law(case.contact) == "history" or case.contact.model == "hertz"
    return f"{case.contact.model} history" if history else "hooke"


def _average_particles(case: Case, seconds: float) -> float:
    """Mean number of particles over the run; those that outlets take away are counted as if they stayed."""
    assert case.particles is not None
    return particle_count(case.particles) + sum(_fed(case, feed, seconds) for feed in case.particles.feeds)


def _count_turnovers(case: Case, seconds: float, fluid_steps: float) -> float:
    """Fluid steps in which a particle comes in, of the feed that brings some in most of them."""
    counts = [0.0]
    for feed in case.particles.feeds if case.particles else ():
        length = max(0.0, min(feed.end or math.inf, seconds) - feed.start)
        assert case.particles is not None
        counts.append(min(fluid_steps * length / seconds, find_rate(case.particles, feed) * length))
    return max(counts)


def _fed(case: Case, feed: Feed, seconds: float) -> float:
    assert case.particles is not None
    rate = find_rate(case.particles, feed)
    end = min(feed.end or math.inf, seconds)
    length = max(0.0, end - feed.start)
    return rate * length * (1.0 - (feed.start + 0.5 * length) / seconds) if length else 0.0


def _guess_contacts(case: Case, region: Region, law: Law | None) -> float:
    """By the state that the bed will be in: at rest, bubbling, passed by a jet, or carried by the gas."""
    assert case.particles is not None
    if case.gravity == 0.0:
        return DILUTE
    if not (case.gas and case.exchange) or mean_density(case.particles) <= case.gas.density:
        return RESTING
    if any(outlet.face == "top" for outlet in case.particles.outlets) and solids_volume(case.particles) < (
        LOOSE * region.volume
    ):
        return DILUTE
    if case.exchange.drag == OWN and law is None:
        return BUBBLING
    passes = sum(inlet.area or 0.0 for inlet in case.gas.inlets) or region.inlet
    if passes < JET * region.section:
        return SPOUTED
    fastest = fastest_inflow(case.gas) * region.inlet / region.section
    return RESTING if fastest < minimum_fluidization(case, law=law) else BUBBLING


def _guess_speed(case: Case, region: Region, contacts: float) -> float:
    """Speed [m/s] of the fastest particle: of a bed that rests hardly any, where particles leave one that of a fall by
    the region's height, else that of a fall by the bed's."""
    assert case.particles is not None
    height = region.find_level(solids_volume(case.particles) / SETTLED)
    if contacts == RESTING:
        if not case.particles.outlets:
            return CREEP
        height = region.height
    return FASTEST * math.sqrt(max(height, largest_diameter(case.particles)) * case.gravity)


def _find_skin(case: Case) -> float:
    assert case.particles is not None and case.contact is not None
    return neighbour_skin(case.contact, case.particles)


def share_ghosts(case: Case, ranks: int) -> float:
    """Particles of other ranks that a rank in the middle looks at, over its own."""
    if ranks == 1 or case.particles is None:
        return 0.0
    reach = _SKIN * largest_diameter(case.particles)
    ratio = 1.0
    for size, count in zip(case.domain.size[:2], find_rank_grid(case.domain.size, ranks), strict=True):
        sides = min(count - 1, 2)
        ratio *= (size / count + sides * reach) / (size / count)
    return ratio - 1.0
