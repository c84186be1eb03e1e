"""Tables of a case file that say where particles come in, and where they are taken out."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator

from fbcouple.case.schema.option import (
    Corners,
    Disc,
    NonNegative,
    Point,
    Positive,
    Section,
    Temperature,
    Texts,
    Vector,
    as_tuple,
    option,
)


class Feed(Section):
    low: Point = option(
        "Lower corner of the box in which particles appear, each at a random place and whole within it; across a "
        "periodic axis it may be as long as the bed.",
        "m",
    )
    high: Point = option("Upper corner of that box.", "m")
    rate: float | None = option(
        "Particles a second. Give this or `mass_flow`. One that finds no free place waits: it is owed.",
        "s-1",
        None,
        **Positive,
    )
    mass_flow: float | None = option("Mass a second. Give this or `rate`.", "kg s-1", None, **Positive)
    species: int = option(
        "Species that it feeds: 1 as `diameter`, `density` and `spread` say, from 2 on the rows of `mixture`.",
        default=1,
        ge=1,
        le=1000,
    )
    velocity: Vector = option("Velocity with which they appear.", "m s-1", (0.0, 0.0, 0.0))
    temperature: float | None = option(
        "Temperature with which they appear, in a case with [heat]; absent: heat.particle_temperature.",
        "K",
        None,
        **Temperature,
    )
    start: float = option("Time from which it feeds.", "s", 0.0, **NonNegative)
    end: float | None = option(
        "Time until which its rate counts; absent: to the end. What is owed then comes later.", "s", None, **Positive
    )
    seed: int = option("Seed of the random places.", default=1, ge=0, le=2**63 - 1)


class Outlet(Section):
    face: Literal["floor", "top", "left", "right", "front", "back"] | None = option(
        "Face of the box around the region that particles leave by, where they meet no wall: all of it, or `rectangle` "
        "or `circle` of it. left is x = 0, front is y = 0; of a cylinder floor and top. Give this, `patches`, or `low` "
        "and `high`.",
        default=None,
    )
    rectangle: Corners | None = option(
        "Two opposite corners on the face, [[0.1, 0.0], [0.14, 0.04]]: x and y on floor and top, y and z on left and "
        "right, x and z on front and back. In a region that is no box its faces are those whose centre it holds.",
        "m",
        None,
    )
    circle: Disc | None = option("Centre, in the two coordinates of the face, and diameter.", "m", None)
    patches: Texts = option(
        "Patches of the mesh, or physical surfaces, by name or shell pattern, that particles leave by.", default=()
    )
    low: Point | None = option("Lower corner of a box in the region: particles in it leave.", "m", None)
    high: Point | None = option("Upper corner of that box.", "m", None)
    depth: float | None = option(
        "Of a face or patches: how far behind it there is room for particles, more than one travels in a coupling "
        "step. Absent: eight times the largest diameter.",
        "m",
        None,
        **Positive,
    )
    start: float = option(
        "Time from which particles leave; until then a face, or patches, are wall to them.", "s", 0.0, **NonNegative
    )


Feeds = Annotated[tuple[Feed, ...], BeforeValidator(as_tuple)]
ParticleOutlets = Annotated[tuple[Outlet, ...], BeforeValidator(as_tuple)]
