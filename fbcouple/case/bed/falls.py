"""Where the particles of a case fall from, and how fast they are there: the bed, the start, the feeds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fbcouple.case.bed.feeds import find_inner_box, list_feed_kinds
from fbcouple.case.bed.lattice import lattice_height
from fbcouple.case.bed.particle_types import largest_diameter, list_kinds, particle_count
from fbcouple.case.bed.positions import find_start_file, start_positions
from fbcouple.case.bed.region import Region
from fbcouple.case.schema.particles import Start
from fbcouple.case.schema.sections import Case


@dataclass(frozen=True, eq=False)
class Fall:
    """Heights [m] that particles fall over and the speeds [m/s] that they have before, (n,) each; of which species they
    are, None: of any; and what they come from, in words."""

    heights: np.ndarray
    speeds: np.ndarray
    species: int | None = None
    origin: str = ""


def list_falls(case: Case, region: Region, bed: float, folder: Path) -> list[Fall]:
    """All falls of a case whose own files lie in `folder`: over the height `bed` [m] of the bed at rest, and from where
    particles start and are fed."""
    start = _find_start(case, region, bed, folder)
    return [Fall(np.array([bed]), np.zeros(1)), *([start] if start else []), *_list_feeds(case, region)]


def _find_start(case: Case, region: Region, bed: float, folder: Path) -> Fall | None:
    """From the places of a start file, or of a lattice in a part of the region, down to the lowest point; from a
    lattice that fills the region from below down to the `bed` [m] that its others make. None of an empty start, or of
    one that is not made yet.
    """
    assert case.particles is not None
    file = find_start_file(case, folder)
    if file is not None:
        heights = file.positions[:, 2] - region.bottom
        speeds = np.zeros(len(heights)) if file.velocities is None else np.linalg.norm(file.velocities, axis=1)
        return Fall(np.maximum(heights, 0.0), speeds, origin="the start")
    if case.start is None or case.start.is_made or not particle_count(case.particles):
        return None
    if case.start.region is not None:
        heights = start_positions(case, folder)[:, 2] - region.bottom
        return Fall(heights, np.zeros(len(heights)), origin="the start")
    largest = largest_diameter(case.particles)
    lowest = max(bed, largest) - largest / 2.0
    height = max(0.0, _find_top(case, case.start, region) - lowest)
    return Fall(np.array([height]), np.zeros(1), origin="the start lattice")


def _find_top(case: Case, start: Start, region: Region) -> float:
    """How high [m] above the lowest point the highest centres of the start lattice are; of one in a region that is no
    box about so, as to find its sites takes long."""
    assert case.particles is not None
    diameters = [kind.diameter for kind in list_kinds(case.particles)]
    shaken = 0.5 * start.jitter * (start.spacing - 1.0) * max(diameters)
    if case.domain.shape == "box":
        height = lattice_height(case)
    else:
        # Sites keep off the walls, of a section that is taken as a circle.
        margin = 0.5 * max(diameters) + math.sqrt(3.0) * shaken
        share = max(0.0, 1.0 - margin / math.sqrt(region.section / math.pi)) ** 2
        volume = particle_count(case.particles) * (start.spacing * max(diameters)) ** 3
        height = region.find_level(volume / share) if volume < share * region.volume else region.height
    return height - 0.5 * start.spacing * min(diameters) + shaken


def _list_feeds(case: Case, region: Region) -> list[Fall]:
    """From the top of each feed's box down to the lowest point."""
    assert case.particles is not None
    falls = []
    for number, feed in enumerate(case.particles.feeds, start=1):
        radius = 0.5 * min(kind.diameter for _, kind, _ in list_feed_kinds(case.particles, feed))
        height = find_inner_box(case, feed, radius)[1][2] - region.bottom
        speed = float(np.linalg.norm(feed.velocity))
        falls.append(Fall(np.array([height]), np.array([speed]), feed.species, f"feed {number}"))
    return falls
