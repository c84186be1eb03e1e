"""Feeds of particles: which kinds a feed has, how many it brings, and in what box they appear."""

from __future__ import annotations

import math

import numpy as np

from fbcouple.case.bed.derived import wraps
from fbcouple.case.bed.particle_types import Kind, grains_per_parcel, list_kinds
from fbcouple.case.schema.feeds import Feed
from fbcouple.case.schema.particles import Particles
from fbcouple.case.schema.sections import Case


def has_traffic(case: Case) -> bool:
    """Do particles come or go while the run goes on?"""
    return case.particles is not None and bool(case.particles.feeds or case.particles.outlets)


def list_feed_kinds(particles: Particles, feed: Feed) -> list[tuple[int, Kind, float]]:
    """Kinds of a feed: number from 0 among all kinds, the kind, and its part of the number fed."""
    own = [(number, kind) for number, kind in enumerate(list_kinds(particles)) if kind.species == feed.species]
    total = sum(kind.share for _, kind in own)
    return [(number, kind, kind.share / total) for number, kind in own]


def find_mean_mass(particles: Particles, feed: Feed) -> float:
    """Mean mass [kg] of a particle that is fed."""
    return sum(share * kind.mass for _, kind, share in list_feed_kinds(particles, feed))


def find_rate(particles: Particles, feed: Feed) -> float:
    """Particles a second that a feed brings; of a coarse-grained bed parcels."""
    if feed.rate is not None:
        return feed.rate / grains_per_parcel(particles)
    return (feed.mass_flow or 0.0) / find_mean_mass(particles, feed)


def count_fed(case: Case) -> float:
    """Particles that all feeds bring up to the end of the case, if none waits; of a coarse-grained bed parcels."""
    total = 0.0
    for feed in case.particles.feeds if case.particles else ():
        assert case.particles is not None
        rate = find_rate(case.particles, feed)
        total += rate * max(0.0, min(feed.end or math.inf, case.end_time) - feed.start)
    return total


def find_clearing_time(case: Case) -> float:
    """Time [s] in which what a feed brings falls, or flies, out of its own place: its diameter.

    So often at least a feed has to be asked, or its box holds back more than its particles do. Infinite without feeds,
    or where nothing moves what they bring.
    """
    times = [math.inf]
    for feed in case.particles.feeds if case.particles else ():
        assert case.particles is not None
        smallest = min(kind.diameter for _, kind, _ in list_feed_kinds(case.particles, feed))
        speed = math.hypot(*feed.velocity)
        leap = math.sqrt(speed**2 + 2.0 * case.gravity * smallest) + speed
        times.append(2.0 * smallest / leap if leap else math.inf)
    return min(times)


def find_inner_box(case: Case, feed: Feed, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest place (3,) [m] of the centre of a particle of `radius` [m] that lies within the box of
    `feed`; along a periodic axis that the box fills it is anywhere."""
    low, high = np.array(feed.low), np.array(feed.high)
    fills = np.array(wraps(case.domain)) & (high - low >= np.array(case.domain.size) * (1.0 - 1e-9))
    margin = np.where(fills, 0.0, radius)
    return low + margin, high - margin
