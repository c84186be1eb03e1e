"""Tables of a case file that say where particles come in, and where they are taken out."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator

from fbcouple.case.schema.option import NonNegative, Point, Positive, Section, Vector, as_tuple, option


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
    start: float = option("Time from which it feeds.", "s", 0.0, **NonNegative)
    end: float | None = option("Time until which it feeds; absent: to the end.", "s", None, **Positive)
    seed: int = option("Seed of the random places.", default=1, ge=0, le=2**63 - 1)


class Outlet(Section):
    face: Literal["top", "floor"] | None = option(
        "top: particles leave over the whole top, which is no lid for them. floor: they fall through the opening "
        "between `low` and `high` in the floor (box without gas only). Absent: those in the box between the two.",
        default=None,
    )
    low: Point | None = option("Lower corner of the box, or of the opening (z = 0 there).", "m", None)
    high: Point | None = option("Upper corner of the box, or of the opening (z = 0 there).", "m", None)
    depth: float | None = option(
        "Of a face: how far below the top a particle counts as out, or how far the space below the floor reaches; "
        "more than a particle travels in a coupling step. Absent: two and eight times the largest diameter.",
        "m",
        None,
        **Positive,
    )
    start: float = option(
        "Time from which particles leave; an opening in the floor is shut until then.", "s", 0.0, **NonNegative
    )


Feeds = Annotated[tuple[Feed, ...], BeforeValidator(as_tuple)]
ParticleOutlets = Annotated[tuple[Outlet, ...], BeforeValidator(as_tuple)]
