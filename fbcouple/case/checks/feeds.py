"""Whether feeds and outlets of particles lie in the region, and are told apart."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fbcouple.case.bed.feeds import find_depth, find_inner_box, list_feed_kinds, list_zones
from fbcouple.case.bed.particle_types import largest_diameter, list_kinds
from fbcouple.case.bed.region import read_mesh
from fbcouple.case.checks.bed import try_region
from fbcouple.case.checks.registry import BED, check
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.feeds import Feed, Outlet
from fbcouple.case.schema.sections import Case

_FEEDS, _OUTLETS = "particles.feeds", "particles.outlets"
_SIZES = ("particles.mixture", "particles.spread", "particles.sizes")
_ROUNDING = 1e-9

Corners = tuple[np.ndarray, np.ndarray]


@check(_FEEDS, "domain.periodic", "domain.shape", *BED[:2], "domain.size", *_SIZES)
def check_feeds(case: Case, folder: Path) -> Iterator[Problem]:
    """Each feed has one flow, a species that is there, and a box in the region that holds a particle of it."""
    if case.particles is None:
        return
    for number, feed in enumerate(case.particles.feeds, start=1):
        for text in _examine_feed(case, folder, feed):
            yield Problem(_FEEDS, f"feed {number}: {text}")


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
    if text := _find_outside(case, folder, feed.low, feed.high):
        yield text
        return
    largest = max(kind.diameter for _, kind, _ in list_feed_kinds(case.particles, feed))
    low, high = find_inner_box(case, feed, 0.5 * largest)
    if (high - low < -_ROUNDING * largest).any():
        size = show((np.array(feed.high) - np.array(feed.low)).tolist())
        yield f"its box is {size} m large and holds no particle of {largest:g} m; enlarge it."


@check(_OUTLETS, _FEEDS, "gas", "domain.periodic", "domain.shape", *BED[:2], "domain.size", *_SIZES)
def check_outlets(case: Case, folder: Path) -> Iterator[Problem]:
    """Each outlet is a zone in the region, thick enough to be seen, in which no feed lies."""
    if case.particles is None:
        return
    problems = [
        Problem(_OUTLETS, f"outlet {number}: {text}")
        for number, outlet in enumerate(case.particles.outlets, start=1)
        for text in _examine_outlet(case, folder, outlet)
    ]
    if sum(outlet.face == "floor" for outlet in case.particles.outlets) > 1:
        problems.append(Problem(_OUTLETS, "two have face = floor; one opening in the floor is allowed."))
    yield from problems
    corners = _find_corners(case, folder)
    if problems or corners is None:
        return
    for number, zone in enumerate(list_zones(case, *corners), start=1):
        for other, feed in enumerate(case.particles.feeds, start=1):
            if ((np.array(feed.high) > zone.low) & (np.array(feed.low) < zone.high)).all():
                text = f"outlet {number} takes out what feed {other} brings, their boxes overlap; move one of them."
                yield Problem(_OUTLETS, text)


def _examine_outlet(case: Case, folder: Path, outlet: Outlet) -> Iterator[str]:
    assert case.particles is not None
    if outlet.face == "top":
        yield from _examine_top(case, outlet)
    elif outlet.low is None or outlet.high is None:
        yield "low and high are not both given; give both corners in m, or face = top."
    elif text := _find_outside(case, folder, outlet.low, outlet.high, flat=outlet.face == "floor"):
        yield text
    elif outlet.face == "floor":
        yield from _examine_opening(case, outlet)
    else:
        if outlet.depth is not None:
            yield f"depth = {outlet.depth:g} m is given and no face; low and high say how thick it is, remove depth."
        thinnest = min(top - bottom for bottom, top in zip(outlet.low, outlet.high, strict=True))
        yield from _examine_thickness(case, thinnest)


def _examine_top(case: Case, outlet: Outlet) -> Iterator[str]:
    if outlet.low is not None or outlet.high is not None:
        yield "low or high is given and face = top, which is the whole top; remove them, or the face."
    if (depth := find_depth(case, outlet)) >= case.domain.size[2]:
        yield f"it is {depth:g} m deep and the region {case.domain.size[2]:g} m high; give a smaller depth."
    yield from _examine_thickness(case, depth)


def _examine_opening(case: Case, outlet: Outlet) -> Iterator[str]:
    assert case.particles is not None
    if case.gas is not None or case.domain.shape != "box":
        yield "face = floor is for a box without gas: gas has no cells below the floor; give low and high of a box."
    yield from _examine_thickness(case, find_depth(case, outlet) - 0.5 * largest_diameter(case.particles))


def _examine_thickness(case: Case, thickness: float) -> Iterator[str]:
    assert case.particles is not None
    least = largest_diameter(case.particles)
    if thickness < least * (1.0 - _ROUNDING):
        yield f"it is {thickness:g} m thick, at least {least:g} m is allowed (a diameter); make it thicker."


def _find_corners(case: Case, folder: Path) -> Corners | None:
    """Lowest and highest corner (3,) [m] of the region; None if its mesh cannot be read, which is told elsewhere."""
    if case.domain.shape == "box":
        return np.zeros(3), np.array(case.domain.size)
    if try_region(case, folder) is None:
        return None
    mesh = read_mesh(case, folder)
    return mesh.low, mesh.high


def _find_outside(
    case: Case, folder: Path, low: tuple[float, ...], high: tuple[float, ...], flat: bool = False
) -> str | None:
    """What is wrong with a box in the region, or with a `flat` opening in its floor."""
    corners = _find_corners(case, folder)
    if corners is None:
        return None
    if flat and (low[2] or high[2]):
        return f"low and high of an opening in the floor have z = 0, {low[2]:g} and {high[2]:g} m are given; fix them."
    axes = 2 if flat else 3
    if any(top <= bottom for bottom, top in list(zip(low, high, strict=True))[:axes]):
        return f"low is {show(low)} and high is {show(high)}; high has to be above low along each axis."
    slack = _ROUNDING * (corners[1] - corners[0])
    if (np.array(low) < corners[0] - slack).any() or (np.array(high) > corners[1] + slack).any():
        held = " to ".join(show([round(value, 9) for value in corner.tolist()]) for corner in corners)
        return f"its box, {show(low)} to {show(high)} m, is not in the region, {held} m; give corners in it, in m."
    return None
