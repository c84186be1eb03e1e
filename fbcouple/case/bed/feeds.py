"""Feeds and outlets of particles: which kinds a feed has, in what box they appear, and in what zones they leave."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fbcouple.case.bed.derived import wraps
from fbcouple.case.bed.particle_types import Kind, largest_diameter, list_kinds
from fbcouple.case.schema.feeds import Feed, Outlet
from fbcouple.case.schema.particles import Particles
from fbcouple.case.schema.sections import Case

TOP_DEPTH, FLOOR_DEPTH = 2.0, 8.0
"""How far an outlet by the top, or below the floor, reaches where the case does not say it, in largest diameters."""
TRAVEL = 0.5
"""Part of the thinnest outlet that the fastest fall may cross in a coupling step."""


@dataclass(frozen=True)
class Zone:
    """Where a particle is out that has its centre between `low` and `high` (3,) [m], from the time `start` [s] on;
    infinite where the zone reaches the end of the region."""

    low: np.ndarray
    high: np.ndarray
    start: float
    thickness: float
    """Its shortest edge [m]: no particle may cross it in one coupling step."""


def has_traffic(case: Case) -> bool:
    """Do particles come or go while the run goes on?"""
    return case.particles is not None and bool(case.particles.feeds or case.particles.outlets)


def find_opening(case: Case) -> Outlet | None:
    """The outlet through the floor, if there is one."""
    outlets = case.particles.outlets if case.particles else ()
    return next((outlet for outlet in outlets if outlet.face == "floor"), None)


def find_depth(case: Case, outlet: Outlet) -> float:
    """How far [m] an outlet by a face reaches."""
    assert case.particles is not None
    if outlet.depth is not None:
        return outlet.depth
    return (FLOOR_DEPTH if outlet.face == "floor" else TOP_DEPTH) * largest_diameter(case.particles)


def list_feed_kinds(particles: Particles, feed: Feed) -> list[tuple[int, Kind, float]]:
    """Kinds of a feed: number from 0 among all kinds, the kind, and its part of the number fed."""
    own = [(number, kind) for number, kind in enumerate(list_kinds(particles)) if kind.species == feed.species]
    total = sum(kind.share for _, kind in own)
    return [(number, kind, kind.share / total) for number, kind in own]


def find_mean_mass(particles: Particles, feed: Feed) -> float:
    """Mean mass [kg] of a particle that is fed."""
    return sum(share * kind.mass for _, kind, share in list_feed_kinds(particles, feed))


def count_fed(case: Case) -> float:
    """Particles that all feeds bring up to the end of the case, if none waits."""
    total = 0.0
    for feed in case.particles.feeds if case.particles else ():
        assert case.particles is not None
        rate = feed.rate or (feed.mass_flow or 0.0) / find_mean_mass(case.particles, feed)
        total += rate * max(0.0, min(feed.end or math.inf, case.end_time) - feed.start)
    return total


def find_inner_box(case: Case, feed: Feed, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest place (3,) [m] of the centre of a particle of `radius` [m] that lies within the box of
    `feed`; along a periodic axis that the box fills it is anywhere."""
    low, high = np.array(feed.low), np.array(feed.high)
    fills = np.array(wraps(case.domain)) & (high - low >= np.array(case.domain.size) * (1.0 - 1e-9))
    margin = np.where(fills, 0.0, radius)
    return low + margin, high - margin


def list_zones(case: Case, low: np.ndarray, high: np.ndarray) -> list[Zone]:
    """The zones of the outlets, in their order, in a region between `low` and `high` (3,) [m]."""
    assert case.particles is not None
    zones = []
    for outlet in case.particles.outlets:
        if outlet.face == "floor":
            depth, reach = find_depth(case, outlet), 0.5 * largest_diameter(case.particles)
            below = np.array([math.inf, math.inf, low[2] - reach])
            zones.append(Zone(np.full(3, -math.inf), below, outlet.start, depth - reach))
            continue
        if outlet.face == "top":
            depth = find_depth(case, outlet)
            corners = np.array([low[0], low[1], high[2] - depth]), high
        else:
            corners = np.array(outlet.low), np.array(outlet.high)
        thickness = float((corners[1] - corners[0]).min())
        bottom, top = (
            np.where(corners[0] <= low, -math.inf, corners[0]),
            np.where(corners[1] >= high, math.inf, corners[1]),
        )
        zones.append(Zone(bottom, top, outlet.start, thickness))
    return zones


def find_longest_step(case: Case) -> float:
    """Longest coupling step [s] in which no particle crosses an outlet that falls through the whole region, or comes
    as fast as one that is fed."""
    if case.particles is None or not case.particles.outlets:
        return math.inf
    low = np.zeros(3)
    thickness = min(zone.thickness for zone in list_zones(case, low, low + case.domain.size))
    fed = max((math.hypot(*feed.velocity) for feed in case.particles.feeds), default=0.0)
    speed = math.sqrt(fed**2 + 2.0 * case.gravity * case.domain.size[2])
    return TRAVEL * thickness / speed if speed else math.inf
