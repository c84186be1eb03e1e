"""Whether a bed is its own mirror image in the planes in which its means are mirrored."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fbcouple.case.checks.registry import check
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.inlets import Inlet
from fbcouple.case.schema.sections import Case

_ROUNDING = 1e-9
_FACES = {"x": ("left", "right"), "y": ("front", "back")}
_ACROSS = {"x": {"floor": 0, "front": 0, "back": 0}, "y": {"floor": 1, "left": 0, "right": 0}}
"""Axis -> faces that the plane cuts, and which of their two coordinates lies along the axis."""


@check("averages.mirror", "domain", "gas", "particles")
def check_mirror(case: Case, folder: Path) -> Iterator[Problem]:
    """Nothing in the case tells one side of a mirror from the other: a box, with a uniform inlet or inlets that are
    each other's images."""
    axes = case.averages.mirror if case.averages else ()
    if len(set(axes)) < len(axes):
        yield Problem("averages.mirror", f"{show(axes)} is given; name each axis once.")
    for axis in dict.fromkeys(axes):
        for found in find_one_sided(case, axis):
            text = f'"{axis}" is given and {found}, so the bed is not its own mirror image'
            yield Problem("averages.mirror", f"{text}; leave it out.")


def find_one_sided(case: Case, axis: str) -> Iterator[str]:
    """What tells the sides of the middle plane across `axis` from each other, a text each."""
    if case.domain.shape != "box":
        yield f'domain.shape is "{case.domain.shape}" ("box" is allowed)'
        return
    sided = {
        "gas.outlets": case.gas and case.gas.outlets,
        "particles.feeds": case.particles and case.particles.feeds,
        "particles.outlets": case.particles and case.particles.outlets,
    }
    yield from (f"{key} are places of their own" for key, tables in sided.items() if tables)
    yield from _find_sided_walls(case, axis)
    yield from _find_sided_inlets(case, axis)


def _find_sided_walls(case: Case, axis: str) -> Iterator[str]:
    """Walls across from each other that are not alike to heat."""
    one, other = _FACES[axis]
    if case.heat and case.heat.find_wall(one) != case.heat.find_wall(other):
        yield f'the walls "{one}" and "{other}" of heat.walls are not alike'


def _find_sided_inlets(case: Case, axis: str) -> Iterator[str]:
    """Inlets without an image, and those that lie upon each other in another order than their images do."""
    inlets = case.gas.inlets if case.gas else ()
    length = case.domain.size["xy".index(axis)]
    images: list[int] = []
    for number, inlet in enumerate(inlets, start=1):
        if inlet.profile_file is not None and inlet.circle is None:
            yield f"what lies in profile_file of inlet {number} of gas.inlets is not compared with its image"
            return
        image = _mirror(inlet, axis, length)
        images.append(next((n for n, other in enumerate(inlets) if _is_same(image, _describe(other))), -1))
        if images[-1] < 0:
            yield f"inlet {number} of gas.inlets has no image on the other side"
            return
    for above, below in ((n, m) for n in range(len(inlets)) for m in range(n)):
        if images[above] < images[below] and _may_meet(inlets[above], inlets[below]):
            yield f"inlet {above + 1} of gas.inlets lies upon inlet {below + 1}, and their images the other way round"


def _may_meet(one: Inlet, other: Inlet) -> bool:
    """Whether two inlets of a face have a place in common, by the rectangles around them."""
    if one.face != other.face:
        return False
    boxes = [_find_bounds(inlet) for inlet in (one, other)]
    if any(box is None for box in boxes):
        return True
    return all(min(a[1], b[1]) > max(a[0], b[0]) for a, b in zip(*filter(None, boxes), strict=True))


def _find_bounds(inlet: Inlet) -> list[tuple[float, float]] | None:
    """Extents of an inlet along both axes of its face [m]; None: all of it."""
    if inlet.rectangle is not None:
        return [(min(pair), max(pair)) for pair in zip(*inlet.rectangle, strict=True)]
    if inlet.circle is not None:
        *middle, radius = inlet.circle
        return [(place - radius, place + radius) for place in middle]
    return None


def _describe(inlet: Inlet) -> dict[str, Any]:
    """What an inlet is and does."""
    given = inlet.model_dump(exclude={"area", "peak"})
    if inlet.rectangle is not None:
        given["rectangle"] = tuple(sorted(pair) for pair in zip(*inlet.rectangle, strict=True))
    return given


def _mirror(inlet: Inlet, axis: str, length: float) -> dict[str, Any]:
    """The same of its image; a ramp is the same, whatever file it lies in, and so is a profile over a radius."""
    given = _describe(inlet)
    if inlet.face in _FACES[axis]:
        given["face"] = next(face for face in _FACES[axis] if face != inlet.face)
    elif (across := _ACROSS[axis].get(inlet.face)) is not None:
        if inlet.rectangle is not None:
            sides = list(given["rectangle"])
            sides[across] = [length - end for end in reversed(sides[across])]
            given["rectangle"] = tuple(sides)
        if inlet.circle is not None:
            circle = list(inlet.circle)
            circle[across] = length - circle[across]
            given["circle"] = tuple(circle)
    return given


def _is_same(one: Any, other: Any) -> bool:
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_is_same(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(_is_same, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) <= _ROUNDING * max(1.0, abs(one))
    return bool(one == other)
