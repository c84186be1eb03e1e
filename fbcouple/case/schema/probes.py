"""Tables of a case file that say which fields are followed in time, and where."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from fbcouple.case.schema.option import NonNegative, Point, Positive, Section, as_tuple, option

Quantity = Literal[
    "pressure",
    "voidage",
    "gas_velocity",
    "gas_flux",
    "solids_fraction",
    "solids_velocity",
    "solids_flux",
    "granular_temperature",
    "gas_temperature",
    "solids_temperature",
]
Quantities = Annotated[tuple[Quantity, ...], BeforeValidator(as_tuple), Field(min_length=1)]
Points = Annotated[tuple[Point, ...], BeforeValidator(as_tuple), Field(min_length=1)]
Ends = Annotated[tuple[Point, Point], BeforeValidator(as_tuple)]


class Probe(Section):
    name: str = option(
        "Name of the set in results.nc, as tap in probe_tap_pressure: small letters, digits and underscores.",
        min_length=1,
        max_length=40,
    )
    quantities: Quantities = option(
        "What is followed, instantaneous: pressure (linear within the cell, by its gradient there), and means over the "
        "cell that holds the point of the others, those of solids over the particles whose centres are in it; the "
        "temperatures of a case with [heat]."
    )
    every: float = option("Time between samples.", "s", **Positive)
    start: float = option("Time from which samples are taken.", "s", 0.0, **NonNegative)
    points: Points | None = option("Points, rows of x, y and z. Give this, `line` or `height`.", "m", None)
    line: Ends | None = option(
        "First and last of `count` points at equal distances on a straight line. Give this, `points` or `height`.",
        "m",
        None,
    )
    count: int | None = option("Points of `line`.", default=None, ge=2, le=10_000)
    height: float | None = option(
        "Height of a horizontal section through a box or cylinder, with a point in the middle of each cell across that "
        "`domain.cells` has; of a cylinder those a quarter of a cell or more from its wall. Bubbles are found in it. "
        "Give this, `points` or `line`.",
        "m",
        None,
    )


Probes = Annotated[tuple[Probe, ...], BeforeValidator(as_tuple)]
