"""Whether [heat] has what its phases and laws need, and nothing that they do not look at."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from fbcouple.case.alternatives import word_removal
from fbcouple.case.bed.derived import dem_step, effective
from fbcouple.case.bed.feeds import count_fed
from fbcouple.case.bed.gas_heat import has_hot_walls
from fbcouple.case.bed.particle_types import Kind, list_kinds, particle_count
from fbcouple.case.bed.streams import list_streams
from fbcouple.case.checks.contact import is_hertz
from fbcouple.case.checks.registry import BED, COEFFICIENTS, check, check_law_file, has_bed
from fbcouple.case.problems import Problem
from fbcouple.case.schema.heat import Heat, HeatWall
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import NUSSELT_FILE, OWN
from fbcouple.geometry.sides import SIDES
from fbcouple.physics.heat.contact_conduction import find_conductance, find_overlap_radius

_GAS_KEYS = {
    "gas_temperature": "the temperature in K at which it starts, and comes in where an inlet has none of its own",
    "gas_specific_heat": "the specific heat in J/(kg K), of air 1006",
}
_PARTICLE_KEYS = {
    "particle_temperature": "the temperature in K at which they start",
    "particle_specific_heat": "the specific heat in J/(kg K), of glass 840",
}
_WALLS, _CONTACT = "heat.walls", "heat.contact_conduction"
_CONTACTS, _DEEP = 12, 0.01
"""Contacts that a sphere can have, and their overlap over its diameter, in a step that has to be stable."""
_SIZES = ("particles.mixture", "particles.spread", "particles.sizes")
_OF_VOIDAGE = ("keqn", "dynamic-lagrangian")
"""Sub-grid models with equations of their own, in which the voidage stands for the gas."""
_KEYS = tuple(f"heat.{key}" for key in Heat.model_fields)
_CONDUCTIVITY = "the thermal conductivity in W/(m K), of glass 1.4"


@check(*_KEYS, "gas", "particles")
def check_phases_of_heat(case: Case, folder: Path) -> Iterator[Problem]:
    """Each phase has its temperature and its properties, and a phase that is not there has none."""
    heat = case.heat
    if heat is None:
        return
    for phase, there, keys in (("gas", case.gas, _GAS_KEYS), ("particles", case.particles, _PARTICLE_KEYS)):
        for key, meaning in keys.items():
            if there and getattr(heat, key) is None:
                yield Problem(f"heat.{key}", f"nothing is given and [{phase}] with [heat] needs it; give {meaning}.")
    of_gas = ("gas_conductivity", "prandtl", "wall_coefficient", "bed_conduction")
    yield from _find_idle(heat, "gas", case.gas is not None, (*_GAS_KEYS, *of_gas))
    of_particles = ("particle_conductivity", "contact_conduction", "bed_conduction")
    yield from _find_idle(heat, "particles", case.particles is not None, (*_PARTICLE_KEYS, *of_particles))


def _find_idle(heat: Heat, phase: str, is_there: bool, keys: tuple[str, ...]) -> Iterator[Problem]:
    """Options of a phase that the case does not have."""
    for key in () if is_there else keys:
        if getattr(heat, key) not in (None, "none"):
            yield Problem(f"heat.{key}", f"the case has no [{phase}]; remove it, or add [{phase}].")


@check("heat", "gas", "gas.inlets")
def check_inlet_temperatures(case: Case, folder: Path) -> Iterator[Problem]:
    """Somebody looks at the temperature of an inlet: the case has heat, and gas comes in by it."""
    for number, stream in enumerate(list_streams(case) if case.gas and case.gas.inlets else (), start=1):
        if stream.temperature is None:
            continue
        text = f"inlet {number}: temperature = {stream.temperature:g} K is given and"
        if case.heat is None:
            yield Problem("gas.inlets", f"{text} the case has no [heat]; remove it, or add [heat].")
        elif not stream.comes_in:
            mend = "remove it (the temperature of a wall is one of [[heat.walls]])"
            yield Problem("gas.inlets", f"{text} it lets no gas in; {mend}.")


@check("heat.gas_conductivity", "heat.prandtl", "gas")
def check_gas_conductivity(case: Case, folder: Path) -> Iterator[Problem]:
    """The gas conducts by its conductivity or by its Prandtl number."""
    if case.heat is None or case.gas is None:
        return
    given = [key for key in ("gas_conductivity", "prandtl") if getattr(case.heat, key) is not None]
    if len(given) != 1:
        words = "both are given" if given else "neither is given"
        text = f"{words} of gas_conductivity and prandtl, exactly one is allowed"
        mend = word_removal(case, [f"heat.{key}" for key in given]) if given else "give one"
        yield Problem("heat.gas_conductivity", f"{text}; {mend} (the conductivity in W/(m K), the number of air: 0.7).")


@check(*_KEYS, "gas", "exchange")
def check_ideal_gas(case: Case, folder: Path) -> Iterator[Problem]:
    """The density of an ideal gas goes with the temperature at a constant pressure, and drag alone looks at it."""
    if case.heat is None or not case.heat.has_ideal_gas:
        return
    key, say = "heat.gas_density", '"ideal" is given'
    if case.gas is None:
        yield Problem(key, f"{say} and the case has no [gas]; remove it, or add [gas].")
        return
    if case.gas.top == "closed":
        text = f'{say} with gas.top = "closed": the gas has nowhere to expand to'
        yield Problem(key, f"{text}; open the top, or remove one of them.")
    if case.gas.turbulence in _OF_VOIDAGE:
        text = f'{say} with gas.turbulence = "{case.gas.turbulence}", which carries its own fields at constant density'
        yield Problem(key, f'{text}; take "none", "smagorinsky" or "localized-dynamic".')
    if case.exchange is None:
        return
    others = [name for name in ("viscous_force", "lift_force", "virtual_mass") if getattr(case.exchange, name)]
    others += ["polydisperse"] if case.exchange.polydisperse != "none" else []
    for name in others:
        yield Problem(key, f"{say} with exchange.{name}, which knows a constant density only; remove one of them.")


@check("heat.nusselt", NUSSELT_FILE)
def check_nusselt(case: Case, folder: Path) -> Iterator[Problem]:
    """A law of heat transfer of the case's own has a file, and the file a law."""
    heat = case.heat
    if heat is not None and (heat.nusselt == OWN or heat.nusselt_file is not None):
        own = heat.nusselt_file
        yield from check_law_file(NUSSELT_FILE, heat.nusselt, own, case.find_folder(folder, own))


@check(*_KEYS, "gas", "particles")
def check_conduction(case: Case, folder: Path) -> Iterator[Problem]:
    """What conducts through particles has their conductivity, and what changes contacts has conduction there."""
    heat = case.heat
    if heat is None or case.particles is None:
        return
    for key in ("contact_conduction", "bed_conduction"):
        word = getattr(heat, key)
        if word != "none" and heat.particle_conductivity is None:
            text = f'nothing is given and {key} = "{word}" needs it'
            yield Problem("heat.particle_conductivity", f"{text}; give {_CONDUCTIVITY}.")
            break
    if heat.conduction_modulus is not None and heat.contact_conduction == "none":
        text = f'{heat.conduction_modulus:g} Pa is given and contact_conduction = "none" does not look at it'
        yield Problem("heat.conduction_modulus", f"{text}; remove it, or let contacts conduct.")


@check(*_KEYS, "gas", "particles", "domain")
def check_heat_walls(case: Case, folder: Path) -> Iterator[Problem]:
    """Somebody meets a wall's temperature, a coefficient goes with one, and a wall is one and named once."""
    heat = case.heat
    if heat is None:
        return
    is_hot = has_hot_walls(heat)
    if heat.wall_coefficient is not None and not is_hot:
        text = f"{heat.wall_coefficient:g} W/(m2 K) is given and no wall has a temperature"
        yield Problem("heat.wall_coefficient", f"{text}; give heat.wall_temperature in K, or remove it.")
    coefficients = heat.wall_coefficient, *(wall.coefficient for wall in heat.walls)
    if heat.wall_area != "whole" and not any(coefficients):
        text = f'"{heat.wall_area}" is given and no wall has a coefficient'
        yield Problem("heat.wall_area", f"{text}; give heat.wall_coefficient in W/(m2 K), or remove it.")
    if is_hot and case.gas is None and heat.contact_conduction == "none":
        text = 'a wall has one, but the case has no [gas] and contact_conduction = "none"'
        yield Problem("heat.wall_temperature", f"{text}: nothing meets it; let contacts conduct, or remove it.")
    for face, count in Counter(wall.face for wall in heat.walls).items():
        if count > 1:
            yield Problem(_WALLS, f"face {face} is named {count} times; name it once.")
    for number, wall in enumerate(heat.walls, start=1):
        for text in _examine_wall(case, wall):
            yield Problem(_WALLS, f"wall {number}: {text}")


def _examine_wall(case: Case, wall: HeatWall) -> Iterator[str]:
    axis = "xyz"[SIDES[wall.face][0]]
    if axis in case.domain.periodic:
        yield f"face {wall.face} is given, and the bed repeats itself there; give another face."
    if case.domain.shape != "box" and axis != "z":
        text = f'face {wall.face} is given and domain.shape = "{case.domain.shape}", where floor and top are faces'
        yield f"{text}; give heat.wall_temperature for the wall around it."
    if wall.coefficient is not None and wall.temperature is None:
        text = f"a coefficient of {wall.coefficient:g} W/(m2 K) is given and no temperature"
        yield f"{text}; give both, or neither for an adiabatic wall."
    if wall.coefficient is not None and case.gas is None:
        yield "a coefficient is given and the case has no [gas]; remove it, or add [gas]."


@check(*_KEYS, "particles", "exchange", "domain", "domain.shape")
def check_contact_conduction(case: Case, folder: Path) -> Iterator[Problem]:
    """LIGGGHTS has the heat capacity of a particle from its mass, and one temperature for a wall that is no plane."""
    heat = case.heat
    if heat is None or heat.contact_conduction == "none":
        return
    if case.exchange is not None and case.exchange.virtual_mass:
        text = f'"{heat.contact_conduction}" is given and exchange.virtual_mass, and the mass of particles in LIGGGHTS'
        yield Problem(_CONTACT, f"{text} then has gas in it that carries no heat; remove one of them.")
    if heat.walls and case.domain.shape != "box":
        text = (
            f'"{heat.contact_conduction}" is given, domain.shape = "{case.domain.shape}" and heat.walls: to particles'
        )
        yield Problem(_CONTACT, f"{text} its walls are one, with wall_temperature; remove heat.walls or this.")


@check(*_KEYS, *BED, "contact", "start", "gravity", "domain", *_SIZES)
def check_conduction_modulus(case: Case, folder: Path) -> Iterator[Problem]:
    """Under linear springs the modulus is brought in at the force of a bed at rest, which there has to be."""
    heat, contact, particles = case.heat, case.contact, case.particles
    if heat is None or heat.conduction_modulus is None or contact is None or particles is None:
        return
    missing = "gravity is 0" if case.gravity == 0.0 else ""
    if not missing and has_bed(case):
        count, fed = particle_count(particles), count_fed(case)
        if not count:
            missing = "there are no particles at the start"
        elif fed > count:
            missing = f"feeds bring {fed:.6g} particles, more than the {count} that it starts with"
    if contact.model == "hooke" and missing:
        text = f'{heat.conduction_modulus:g} Pa is given, contact.model = "hooke", whose contacts are corrected at the'
        yield Problem(
            "heat.conduction_modulus", f'{text} force of the bed at rest, and {missing}; give contact.model = "hertz".'
        )


@check(*_KEYS, *BED[:2], "contact.stiffness", "contact.steps_per_contact", "contact.model", *COEFFICIENTS, *_SIZES)
def check_conduction_step(case: Case, folder: Path) -> Iterator[Problem]:
    """LIGGGHTS conducts explicitly: in a DEM step a particle that is touched all around takes less than it has."""
    heat, contact, particles = case.heat, case.contact, case.particles
    if heat is None or heat.contact_conduction == "none" or contact is None or particles is None:
        return
    if heat.particle_conductivity is None or heat.particle_specific_heat is None:
        return
    if contact.model == "hertz" and not is_hertz(contact):
        return  # the spring is chosen later, or check_model tells what is missing
    kinds, conductivity = list_kinds(particles), heat.particle_conductivity
    rates = []
    for kind, other in itertools.product(kinds, kinds):
        count, radius = _touch_all_around(kind, other)
        conductance = find_conductance(heat.contact_conduction, conductivity, conductivity, radius)
        rates.append((count * conductance / kind.mass, kind, round(count)))
    rate, kind, count = max(rates, key=lambda one: one[0])
    share = rate * dem_step(contact, particles) / heat.particle_specific_heat
    if share > 1.0:
        text = f'"{heat.contact_conduction}" is given and {count} contacts of {_DEEP:g} d would change a particle of'
        text += f" {kind.diameter:g} m by {share:.3g} of the difference in a DEM step, 1 is stable"
        yield Problem(_CONTACT, f"{text}; take more contact.steps_per_contact, or none.")


def _touch_all_around(kind: Kind, other: Kind) -> tuple[float, float]:
    """Contacts that a sphere of `kind` can have with spheres of `other`, and the radius [m] of each.

    Each takes a cone of directions from it, of half the angle asin(r'/(r + r')), and they fill as much of all as
    `_CONTACTS` of its like do: larger ones touch in wider circles, of up to sqrt(2) the radius, but fewer of them.
    """
    sine = other.diameter / (kind.diameter + other.diameter)
    count = _CONTACTS * (1.0 - math.sqrt(0.75)) / (1.0 - math.sqrt(1.0 - sine**2))
    overlap = _DEEP * min(kind.diameter, other.diameter)
    return count, find_overlap_radius(effective(kind.diameter / 2.0, other.diameter / 2.0), overlap)
