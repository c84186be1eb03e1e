"""Whether outlets of particles lie in the region or in its walls, and are told apart."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product
from pathlib import Path

import numpy as np

from fbcouple.case.bed.derived import wraps
from fbcouple.case.bed.outlets import find_open_faces, find_reach, find_thickness, is_opening
from fbcouple.case.bed.particle_types import largest_diameter
from fbcouple.case.bed.streams import find_opening
from fbcouple.case.checks.feeds import FEEDS, SIZES, find_corners, find_outside
from fbcouple.case.checks.registry import BED, check
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.feeds import Outlet
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.geometry.plate import overlap
from fbcouple.geometry.sides import SIDES, find_axes

_OUTLETS = "particles.outlets"
_ROUNDING = 1e-9
Box = tuple[tuple[float, ...], tuple[float, ...]]


@check(_OUTLETS, FEEDS, "gas", "domain.periodic", "domain.shape", "domain.mesh", *BED[:2], "domain.size", *SIZES)
def check_outlets(case: Case, folder: Path) -> Iterator[Problem]:
    """Each outlet is one place, in the region or in a wall of it, thick enough to be seen, in which no feed lies."""
    if case.particles is None:
        return
    outlets = list(enumerate(case.particles.outlets, start=1))
    problems = [
        Problem(_OUTLETS, f"outlet {number}: {text}")
        for number, outlet in outlets
        for text in _examine_outlet(case, folder, outlet)
    ]
    yield from problems
    if problems:
        return
    for (one, first), (other, second) in combinations(outlets, 2):
        if first.face and first.face == second.face and _share(first, second):
            text = f"outlets {one} and {other} overlap on the face {first.face}; move them apart, or make them one."
            yield Problem(_OUTLETS, text)
    for (number, outlet), (other, feed) in product(outlets, enumerate(case.particles.feeds, start=1)):
        if outlet.low and outlet.high and _meet((outlet.low, outlet.high), (feed.low, feed.high)):
            text = f"outlet {number} takes out what feed {other} brings, their boxes overlap; move one of them."
            yield Problem(_OUTLETS, text)


def _meet(one: Box, other: Box) -> bool:
    return bool(np.all(np.maximum(one[0], other[0]) < np.minimum(one[1], other[1])))


def _share(one: Outlet, other: Outlet) -> bool:
    shape, second = find_opening(one).shape, find_opening(other).shape
    return shape is None or second is None or overlap(shape, second)


def _examine_outlet(case: Case, folder: Path, outlet: Outlet) -> Iterator[str]:
    corners = outlet.low is not None, outlet.high is not None
    ways = [name for name, given in zip(_WAYS, (outlet.face, outlet.patches, any(corners)), strict=True) if given]
    shapes = [name for name in ("rectangle", "circle") if getattr(outlet, name)]
    if len(ways) != 1:
        found = " and ".join(ways) + (" are given" if ways else "none of them is given")
        yield f"{found}; give face, patches, or low and high of a box, one of them."
    elif shapes and (len(shapes) > 1 or outlet.face is None):
        lacking = "" if outlet.face else " and no face"
        yield f"{' and '.join(shapes)} is given{lacking}; give one of rectangle and circle, on a face."
    elif is_opening(outlet):
        yield from _examine_opening(case, folder, outlet)
    elif not all(corners):
        yield "low and high are not both given; give both corners in m."
    elif outlet.depth is not None:
        yield f"depth = {outlet.depth:g} m is given and no face; low and high say how thick it is, remove depth."
    else:
        assert outlet.low is not None and outlet.high is not None
        if text := find_outside(case, folder, outlet.low, outlet.high):
            yield text
            return
        yield from _examine_thickness(case, outlet)


_WAYS = ("face", "patches", "low or high")


def _examine_opening(case: Case, folder: Path, outlet: Outlet) -> Iterator[str]:
    domain = case.domain
    if outlet.patches and domain.shape != "file":
        yield f"patches is given and domain.shape is {show(domain.shape)}; give face, and rectangle or circle, instead."
        return
    if domain.shape == "cylinder" and outlet.face not in ("floor", "top"):
        yield f'face = "{outlet.face}" is given, a cylinder has them on its floor and its top; give one of these.'
        return
    if outlet.face and wraps(domain)[SIDES[outlet.face][0]]:
        yield f'face = "{outlet.face}" is given and the bed repeats itself there; give another face.'
        return
    yield from _examine_thickness(case, outlet)
    corners = find_corners(case, folder)
    if corners is None:
        return
    if outlet.face and (text := _find_off_face(corners, outlet)):
        yield text
        return
    if domain.shape != "box":
        try:
            find_open_faces(case, [outlet], folder)
        except CaseError as error:
            yield from error.problems


def _find_off_face(corners: tuple[np.ndarray, np.ndarray], outlet: Outlet) -> str | None:
    """What is wrong with the place of a shape on its face."""
    assert outlet.face is not None
    shape, axes = find_opening(outlet).shape, list(find_axes(outlet.face))
    if shape is None:
        return None
    given = show(outlet.rectangle or outlet.circle)
    if shape.area <= 0.0:
        return f"{given} has no area; give two opposite corners."
    low, high = (corner[axes] for corner in corners)
    room = _ROUNDING * float((high - low).max())
    if np.all(shape.bounds[0] >= low - room) and np.all(shape.bounds[1] <= high + room):
        return None
    ends = " and ".join(f"{'xyz'[axis]} from {corners[0][axis]:g} to {corners[1][axis]:g} m" for axis in axes)
    return f"{given} sticks out of the face {outlet.face}, which has {ends}; move it, or make it smaller."


def _examine_thickness(case: Case, outlet: Outlet) -> Iterator[str]:
    assert case.particles is not None
    least, thickness = largest_diameter(case.particles), find_thickness(case, outlet)
    if thickness < least * (1.0 - _ROUNDING):
        beyond = f" behind the radius of a particle that is out ({find_reach(case):g} m)" if find_reach(case) else ""
        text = f"it is {thickness:g} m thick{beyond if is_opening(outlet) else ''}, at least {least:g} m is allowed"
        yield f"{text} (a diameter); make it thicker."
