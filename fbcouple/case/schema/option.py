"""What sections of a case file are made of: the kinds of values, and how an option is declared."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

Positive: dict[str, Any] = {"gt": 0.0, "allow_inf_nan": False}
NonNegative: dict[str, Any] = {"ge": 0.0, "allow_inf_nan": False}
Temperature: dict[str, Any] = {"gt": 0.0, "le": 1e5, "allow_inf_nan": False}


def as_tuple(value: Any) -> Any:
    """Take a TOML array, or one of arrays, where the schema holds tuples; the rest is for the schema to judge."""
    return tuple(as_tuple(entry) for entry in value) if isinstance(value, list) else value


Length = Annotated[float, Field(gt=0.0, le=1e4, allow_inf_nan=False)]
CellCount = Annotated[int, Field(ge=1, le=1_000_000)]
Sizes = Annotated[tuple[Length, Length, Length], BeforeValidator(as_tuple)]
Cells = Annotated[tuple[CellCount, CellCount, CellCount], BeforeValidator(as_tuple)]
Place = Annotated[float, Field(ge=-1e4, le=1e4, allow_inf_nan=False)]
Stretch = Annotated[tuple[Place, Place], BeforeValidator(as_tuple)]
Region = Annotated[tuple[Stretch, Stretch, Stretch], BeforeValidator(as_tuple)]
Moment = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Velocity = Annotated[float, Field(ge=-1e4, le=1e4, allow_inf_nan=False)]
Ramp = Annotated[tuple[tuple[Moment, Velocity], ...], BeforeValidator(as_tuple), Field(min_length=1)]
Sides = Annotated[tuple[Literal["x", "y"], ...], BeforeValidator(as_tuple)]
Amount = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Part = Annotated[float, Field(gt=0.0, lt=1.0)]
Species = Annotated[int, Field(ge=1, le=1000)]
Restitution = Annotated[float, Field(gt=0.0, le=1.0)]
Friction = Annotated[float, Field(ge=0.0, le=10.0)]
Mixture = Annotated[tuple[tuple[Amount, Amount, Part], ...], BeforeValidator(as_tuple)]
SizesOfParticles = Annotated[tuple[tuple[Amount, Amount, Annotated[int, Field(ge=1)]], ...], BeforeValidator(as_tuple)]
Pairs = Annotated[tuple[tuple[Species, Species, Restitution, Friction], ...], BeforeValidator(as_tuple)]
Walls = Annotated[tuple[tuple[Species, Restitution, Friction], ...], BeforeValidator(as_tuple)]
Faces = Annotated[tuple[CellCount, CellCount], BeforeValidator(as_tuple)]
Coordinate = Annotated[float, Field(ge=-1e4, le=1e4, allow_inf_nan=False)]
Point = Annotated[tuple[Coordinate, Coordinate, Coordinate], BeforeValidator(as_tuple)]
Vector = Annotated[tuple[Velocity, Velocity, Velocity], BeforeValidator(as_tuple)]
Corner = Annotated[tuple[Coordinate, Coordinate], BeforeValidator(as_tuple)]
Corners = Annotated[tuple[Corner, Corner], BeforeValidator(as_tuple)]
Disc = Annotated[tuple[Coordinate, Coordinate, Length], BeforeValidator(as_tuple)]
Lengths = Annotated[tuple[Length, Length], BeforeValidator(as_tuple)]
Numbers = Annotated[tuple[Annotated[int, Field(ge=1)], ...], BeforeValidator(as_tuple)]
Amounts = Annotated[tuple[Amount, ...], BeforeValidator(as_tuple)]
Texts = Annotated[tuple[str, ...], BeforeValidator(as_tuple)]


def option(text: str, unit: str = "1", default: Any = ..., **limits: Any) -> Any:
    """Declare one option: its sentence, SI unit, default (none: the case must give it) and limits."""
    return Field(default, description=text, json_schema_extra={"unit": unit}, **limits)


class Section(BaseModel):
    """A table of the case file; unknown keys and wrong types are mistakes, nothing is converted in silence."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)
