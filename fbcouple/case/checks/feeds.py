"""Whether feeds of particles lie in the region, and bring what is there."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fbcouple.case.bed.feeds import find_inner_box, has_traffic, list_feed_kinds
from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.bed.region import read_mesh
from fbcouple.case.checks.bed import try_region
from fbcouple.case.checks.registry import BED, check
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.feeds import Feed
from fbcouple.case.schema.sections import Case

FEEDS = "particles.feeds"
SIZES = ("particles.mixture", "particles.spread", "particles.sizes")
_ROUNDING = 1e-9

Corners = tuple[np.ndarray, np.ndarray]


@check(FEEDS, "domain.periodic", "domain.shape", *BED[:2], "domain.size", *SIZES)
def check_feeds(case: Case, folder: Path) -> Iterator[Problem]:
    """Each feed has one flow, a species that is there, and a box in the region that holds a particle of it."""
    if case.particles is None:
        return
    for number, feed in enumerate(case.particles.feeds, start=1):
        for text in _examine_feed(case, folder, feed):
            yield Problem(FEEDS, f"feed {number}: {text}")
        if feed.temperature is not None and case.heat is None:
            text = f"{feed.temperature:g} K is given and the case has no [heat]; remove it, or add [heat]."
            yield Problem(FEEDS, f"feed {number}: temperature = {text}")


@check("gas.top", "gas.outlets", FEEDS, "particles.outlets")
def check_room(case: Case, folder: Path) -> Iterator[Problem]:
    """Gas can make room for particles that come in, and fill that of those that leave."""
    if has_traffic(case) and case.gas is not None and case.gas.top == "closed":
        text = "closed is given and particles come or go, so that gas has to make room for them and fill theirs"
        yield Problem("gas.top", f'{text}; give top = "open", or gas.outlets elsewhere.')


def _examine_feed(case: Case, folder: Path, feed: Feed) -> Iterator[str]:
    assert case.particles is not None
    if (feed.rate is None) == (feed.mass_flow is None):
        given = "neither rate nor mass_flow is given" if feed.rate is None else "rate and mass_flow are both given"
        yield f"{given}; give one of them (rate in 1/s, mass_flow in kg/s)."
    if feed.end is not None and feed.end <= feed.start:
        yield f"it ends at {feed.end:g} s and starts at {feed.start:g} s; end it later."
    species = sorted({kind.species for kind in list_kinds(case.particles)})
    if feed.species not in species:
        yield f"species {feed.species} is given, {' and '.join(map(str, species))} are there; number them from 1."
        return
    if text := find_outside(case, folder, feed.low, feed.high):
        yield text
        return
    largest = max(kind.diameter for _, kind, _ in list_feed_kinds(case.particles, feed))
    low, high = find_inner_box(case, feed, 0.5 * largest)
    if (high - low < -_ROUNDING * largest).any():
        size = show((np.array(feed.high) - np.array(feed.low)).tolist())
        yield f"its box is {size} m large and holds no particle of {largest:g} m; enlarge it."


def find_corners(case: Case, folder: Path) -> Corners | None:
    """Lowest and highest corner (3,) [m] of the region; None if its mesh cannot be read, which is told elsewhere."""
    if case.domain.shape == "box":
        return np.zeros(3), np.array(case.domain.size)
    if try_region(case, folder) is None:
        return None
    mesh = read_mesh(case, folder)
    return mesh.low, mesh.high


def find_outside(case: Case, folder: Path, low: tuple[float, ...], high: tuple[float, ...]) -> str | None:
    """What is wrong with the place of a box in the region."""
    corners = find_corners(case, folder)
    if corners is None:
        return None
    if any(top <= bottom for bottom, top in zip(low, high, strict=True)):
        return f"low is {show(low)} and high is {show(high)}; high has to be above low along each axis."
    slack = _ROUNDING * (corners[1] - corners[0])
    if (np.array(low) < corners[0] - slack).any() or (np.array(high) > corners[1] + slack).any():
        held = " to ".join(show([round(value, 9) for value in corner.tolist()]) for corner in corners)
        return f"its box, {show(low)} to {show(high)} m, is not in the region, {held} m; give corners in it, in m."
    return None
