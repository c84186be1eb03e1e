"""Tables of a case file that say where gas comes in, and where it leaves."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator

from fbcouple.case.schema.option import (
    Corners,
    Disc,
    NonNegative,
    Ramp,
    Section,
    Temperature,
    Texts,
    as_tuple,
    option,
)


class Inlet(Section):
    rectangle: Corners | None = option(
        "Two opposite corners on the face, [[0.1, 0.0], [0.14, 0.04]]: x and y on the floor, y and z on left and "
        "right, x and z on front and back. It may cut cells. Give this, `circle` or `patches`.",
        "m",
        None,
    )
    circle: Disc | None = option(
        "Centre, in the two coordinates of the face, and diameter. It may cut cells. Give this, `rectangle` or "
        "`patches`.",
        "m",
        None,
    )
    face: Literal["floor", "left", "right", "front", "back"] = option(
        "Face that `rectangle` or `circle` is on: left is x = 0, front is y = 0; of a cylinder the floor.",
        default="floor",
    )
    patches: Texts = option(
        'Patches of the mesh, or physical surfaces, by name or shell pattern, as ["jet", "nozzle*"].', default=()
    )
    velocity: float | None = option(
        "Superficial velocity over this inlet, along the inward normal of each face; 0: closed. Give this, `ramp` or "
        "`ramp_file`; with `profile_file` none of them means the velocities of the file, of which it is the mean.",
        "m s-1",
        None,
        **NonNegative,
    )
    ramp: Ramp | None = option(
        "Times [s] and superficial velocities over this inlet, any number of rows, as `gas.inlet_ramp`; filled in from "
        "`ramp_file`.",
        "m s-1",
        None,
    )
    ramp_file: str | None = option(
        "CSV file of times and velocities (time,velocity; s and m/s) beside the case, in place of `ramp`.", default=None
    )
    profile: Literal["flat", "parabolic"] = option(
        "Velocity over the inlet: the same everywhere, or a parabola with the same flow: 2 in the middle of a circle, "
        "9/4 in that of a rectangle (no other inlet may lie on it).",
        default="flat",
    )
    profile_file: str | None = option(
        "CSV file beside the case with the velocity over the inlet (m and m/s), in place of `profile`: of a circle "
        "radius,velocity, of a rectangle its two coordinates on the face or one of them, and velocity. Linear between "
        "its points; `velocity` or a ramp scales it to that mean.",
        default=None,
    )
    peak: float | None = option(
        "Largest velocity of `profile_file` over its mean; filled in.", default=None, ge=1.0 - 1e-9, allow_inf_nan=False
    )
    temperature: float | None = option(
        "Temperature of the gas that comes in by it, in a case with [heat]; absent: heat.gas_temperature. The velocity "
        "is that of the gas as warm as this.",
        "K",
        None,
        **Temperature,
    )
    area: float | None = option(
        "Area that it lets gas through by, without what later inlets cover; filled in.", "m2", None, **NonNegative
    )


class Outlet(Section):
    rectangle: Corners | None = option(
        "Two opposite corners on the face, as of an inlet; its faces are those whose centre it holds. Give this, "
        "`circle` or `patches`.",
        "m",
        None,
    )
    circle: Disc | None = option(
        "Centre, in the two coordinates of the face, and diameter. Give this, `rectangle` or `patches`.", "m", None
    )
    face: Literal["top", "floor", "left", "right", "front", "back"] = option(
        "Face that `rectangle` or `circle` is on, as of an inlet.", default="top"
    )
    patches: Texts = option("Patches of the mesh, or physical surfaces, by name or shell pattern.", default=())


Inlets = Annotated[tuple[Inlet, ...], BeforeValidator(as_tuple)]
Outlets = Annotated[tuple[Outlet, ...], BeforeValidator(as_tuple)]
