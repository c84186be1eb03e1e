"""Options of heat, [heat]: temperatures, properties, laws, and the tables of walls [[heat.walls]]."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator

from fbcouple.case.schema.option import Positive, Section, Temperature, as_tuple, option


class HeatWall(Section):
    face: Literal["floor", "top", "left", "right", "front", "back"] = option(
        "Face of the box around the region that is meant, all of it: left is x = 0, front is y = 0; of a cylinder or a "
        "mesh floor and top only. What gas flows through, an inlet that is open or an outlet, is no wall to gas."
    )
    temperature: float | None = option(
        "Temperature of the wall, in place of `wall_temperature`; absent: it is adiabatic.", "K", None, **Temperature
    )
    coefficient: float | None = option(
        "Coefficient from gas to this wall, in place of `wall_coefficient`; absent: the gas at the wall has the wall's "
        "temperature.",
        "W m-2 K-1",
        None,
        **Positive,
    )


HeatWalls = Annotated[tuple[HeatWall, ...], BeforeValidator(as_tuple)]


class Heat(Section):
    gas_temperature: float | None = option(
        "Temperature of the gas at the start, and of what comes in by inlets that have none of their own. Needed with "
        "[gas].",
        "K",
        None,
        **Temperature,
    )
    particle_temperature: float | None = option(
        "Temperature of the particles at the start, where the file of their start positions has no column "
        "`temperature`, and of those that feeds bring. Needed with [particles].",
        "K",
        None,
        **Temperature,
    )
    gas_specific_heat: float | None = option(
        "Specific heat of the gas at constant pressure. Needed with [gas].", "J kg-1 K-1", None, **Positive
    )
    gas_density: Literal["constant", "ideal"] = option(
        "Density of the gas: that of [gas] everywhere, or that of an ideal gas, which has it at `gas_temperature` and "
        "is lighter where it is warmer.",
        default="constant",
    )
    gas_conductivity: float | None = option(
        "Thermal conductivity of the gas. With [gas] give this or `prandtl`.", "W m-1 K-1", None, **Positive
    )
    prandtl: float | None = option(
        "Prandtl number of the gas, viscosity times specific heat over conductivity, in place of `gas_conductivity`.",
        default=None,
        **Positive,
    )
    particle_specific_heat: float | None = option(
        "Specific heat of the particles. Needed with [particles].", "J kg-1 K-1", None, **Positive
    )
    particle_conductivity: float | None = option(
        "Thermal conductivity of the particles' material. Needed by `contact_conduction` and `bed_conduction`.",
        "W m-1 K-1",
        None,
        **Positive,
    )
    nusselt: Literal["gunn", "ranz-marshall", "own"] = option(
        "Law of the heat transfer between gas and particles (Gunn 1978; Ranz and Marshall 1952), or the one in "
        "`nusselt_file`.",
        default="gunn",
    )
    nusselt_file: str | None = option(
        'Python file beside the case with the case\'s own law, for nusselt = "own"; it runs only with --trust.',
        default=None,
    )
    wall_temperature: float | None = option(
        "Temperature of the walls; absent: they are adiabatic, but for those that `walls` names.",
        "K",
        None,
        **Temperature,
    )
    wall_coefficient: float | None = option(
        "Heat transfer coefficient from the gas in the cells at walls to them; absent: the gas at the wall has the "
        "wall's temperature.",
        "W m-2 K-1",
        None,
        **Positive,
    )
    wall_area: Literal["whole", "gas"] = option(
        "Part of a wall that a coefficient counts on: the whole, as of one that was measured between a bed and its "
        "wall, or the share that the gas touches, which is the voidage in the cell there.",
        default="whole",
    )
    walls: HeatWalls = option(
        "Walls with a temperature of their own, or adiabatic beside others that are not: tables [[heat.walls]].",
        default=(),
    )
    contact_conduction: Literal["none", "batchelor-obrien", "liggghts"] = option(
        "Conduction through contacts of particles, and with walls that have a temperature: by 2 k a (Batchelor and "
        "O'Brien 1977, a the radius of the contact, k the harmonic mean 2 k_i k_j/(k_i + k_j)), or by LIGGGHTS' own "
        "law, which is the square root of pi times that.",
        default="none",
    )
    conduction_modulus: float | None = option(
        "Young's modulus of the material that the radius of contacts is corrected to where the springs of [contact] "
        "are softer; absent: contacts conduct by the radius that they have in the run.",
        "Pa",
        None,
        ge=1e3,
        le=1e13,
    )
    bed_conduction: Literal["none", "zehner-schlunder"] = option(
        "Conductivity of the gas where there are particles: that of the gas, or of the bed by Zehner and "
        "Schlunder 1970, which counts the particles in.",
        default="none",
    )

    @property
    def has_ideal_gas(self) -> bool:
        """Does the density of the gas follow its temperature?"""
        return self.gas_density == "ideal"

    def find_wall(self, face: str) -> tuple[float | None, float | None]:
        """Temperature [K], None where it is adiabatic, and coefficient [W/(m2 K)] or None, of the wall `face`."""
        for wall in self.walls:
            if wall.face == face:
                return wall.temperature, wall.coefficient
        return self.wall_temperature, self.wall_coefficient
