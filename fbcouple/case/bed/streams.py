"""The gas that a case lets in, stream by stream: where each comes in, and how fast at which time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from fbcouple.case.bed.derived import has_ramp, inlet_ramp, inlet_rows, open_share
from fbcouple.case.schema.feeds import Outlet as ParticleOutlet
from fbcouple.case.schema.gas import Domain
from fbcouple.case.schema.inlets import Inlet, Outlet
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.cylinder import make_floor
from fbcouple.geometry.plane_cover import Circle, Rectangle, Shape, measure_cover
from fbcouple.geometry.sides import find_axes
from fbcouple.geometry.velocity_profile import Profile

FLOOR, TOP = "floor", "top"
INLET, OUTLET = "inlet", "outlet"
_CLOSED = ((0.0, 0.0),)
Rows = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Opening:
    """Where gas passes: a `shape` on a `face`, all of the face, or, of a mesh from a file, the patches that `patches`
    name, which the option `key` gives."""

    face: str = FLOOR
    shape: Shape | None = None
    patches: tuple[str, ...] = ()
    key: str = "patches"


@dataclass(frozen=True)
class Stream:
    """The gas of one inlet: superficial velocities [m/s] at times [s] over its own area; later streams lie on top."""

    opening: Opening
    rows: Rows
    profile: Literal["flat", "parabolic"] | Profile = "flat"
    """Over the opening; what a file says is read where its folder is known (`find_openings`)."""
    temperature: float | None = None
    """Of its gas [K]; None: that of the gas at the start."""

    @property
    def is_flat(self) -> bool:
        """Is the velocity the same all over the opening?"""
        return self.profile == "flat"

    @property
    def is_closed(self) -> bool:
        """Does no gas ever pass?"""
        return not any(velocity for _, velocity in self.rows)

    @property
    def comes_in(self) -> bool:
        """Does gas ever come in, not only leave?"""
        return any(velocity > 0.0 for _, velocity in self.rows)


def has_openings(case: Case) -> bool:
    """Does the case say where gas comes in, or leaves, other than by the whole floor, whole faces of it and the top?"""
    gas = case.gas
    return gas is not None and bool(gas.inlets or gas.outlets or gas.closed_nozzle_size)


def has_side_openings(case: Case) -> bool:
    """Does gas come in elsewhere than by the floor, or leave elsewhere than at the top, so that its flux changes on the
    way?"""
    if case.gas is None or not has_openings(case) or case.domain.shape == "file":
        return False
    sides = any(inlet.face != FLOOR for inlet in case.gas.inlets)
    return sides or any(outlet.face != TOP for outlet in case.gas.outlets)


def list_streams(case: Case) -> tuple[Stream, ...]:
    """The streams of a case; of one without `inlets` that of the whole inlet, and of the closed nozzle."""
    assert case.gas is not None
    if case.gas.inlets:
        return tuple(
            Stream(find_opening(inlet), inlet_rows(inlet), inlet.profile, inlet.temperature)
            for inlet in case.gas.inlets
        )
    if case.domain.shape == "file":
        return (Stream(Opening(patches=(case.domain.inlet or INLET,)), inlet_ramp(case.gas)),)
    if case.gas.closed_nozzle_size is None:
        return (Stream(Opening(), inlet_ramp(case.gas)),)
    nozzle = find_nozzle(case.domain, case.gas.closed_nozzle_size)
    floor = case.domain.size[0] * case.domain.size[1]
    share = floor / (floor - nozzle.area)
    rows = tuple((time, velocity * share) for time, velocity in inlet_ramp(case.gas))
    return Stream(Opening(), rows), Stream(Opening(shape=nozzle), _CLOSED)


def has_own_condition(case: Case) -> bool:
    """Is the velocity at the inlet of the gas a table of times, of fbcouple's own boundary condition?"""
    return case.gas is not None and (has_openings(case) or case.domain.shape == "file" or has_ramp(case.gas))


def list_tables(case: Case) -> list[Rows]:
    """Rows of each table of the boundary condition at the inlet: of the streams that ever let gas in or, without
    openings, of the one velocity through the open faces."""
    assert case.gas is not None
    if has_openings(case):
        streams = list_streams(case)
        return [stream.rows for stream in streams if not stream.is_closed] or [streams[0].rows]
    share = open_share(case)
    return [tuple((time, velocity * share) for time, velocity in inlet_ramp(case.gas))]


def list_outlets(case: Case) -> tuple[Opening, ...]:
    """Where the gas of a case with openings leaves."""
    assert case.gas is not None
    if case.gas.outlets:
        return tuple(find_opening(outlet) for outlet in case.gas.outlets)
    if case.gas.top == "closed":
        return ()
    if case.domain.shape == "file":
        return (Opening(patches=(case.domain.outlet or OUTLET,), key="domain.outlet (or patches of [[gas.outlets]])"),)
    return (Opening(face=TOP),)


def find_nozzle(domain: Domain, size: tuple[float, float]) -> Rectangle:
    """A rectangle of that width and depth [m] in the middle of the floor."""
    (width, depth, _), (along, across) = domain.size, size
    middle = 0.5 * width, 0.5 * depth
    return Rectangle(
        (middle[0] - 0.5 * along, middle[1] - 0.5 * across), (middle[0] + 0.5 * along, middle[1] + 0.5 * across)
    )


@lru_cache(maxsize=1000)
def find_opening(given: Inlet | Outlet | ParticleOutlet) -> Opening:
    """The opening that a table of a case file describes."""
    shape: Shape | None = None
    if given.rectangle:
        (x, y), (other_x, other_y) = given.rectangle
        shape = Rectangle((min(x, other_x), min(y, other_y)), (max(x, other_x), max(y, other_y)))
    elif given.circle:
        shape = Circle(given.circle[:2], 0.5 * given.circle[2])
    return Opening(given.face or FLOOR, shape, given.patches)


def find_outline(domain: Domain, face: str) -> np.ndarray:
    """Corners (n, 2) [m] of a face of a box, or of the floor of a cylinder, anticlockwise, in its two coordinates."""
    if domain.shape == "cylinder":
        return make_floor(domain.size[0], domain.cells[0])
    one, other = (domain.size[axis] for axis in find_axes(face))
    return np.array([[0.0, 0.0], [one, 0.0], [one, other], [0.0, other]])


def list_above(streams: tuple[Stream, ...], number: int) -> list[Shape]:
    """Shapes that lie on top of those of stream `number`."""
    face = streams[number].opening.face
    return [s.opening.shape for s in streams[number + 1 :] if s.opening.shape is not None and s.opening.face == face]


def find_area(domain: Domain, streams: tuple[Stream, ...], number: int) -> float:
    """Area [m2] of a box or a cylinder that stream `number` has, without what later ones cover."""
    outline = find_outline(domain, streams[number].opening.face)
    shape = streams[number].opening.shape or Rectangle((-1e9, -1e9), (1e9, 1e9))
    return measure_cover(outline, shape, list_above(streams, number))
