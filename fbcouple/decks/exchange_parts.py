"""Parts of a case: what gas and particles exchange, and heat."""

from __future__ import annotations

from fbcouple.case.bed.acceleration import choose_acceleration
from fbcouple.case.bed.gas_heat import has_hot_walls, has_inlet_temperatures
from fbcouple.case.schema.sections import Case
from fbcouple.decks.parts import Decision, register

EXCHANGE: dict[str, Decision] = {}
_part = register(EXCHANGE)


@_part
def _satellite_points(case: Case) -> tuple[bool, str]:
    method = case.exchange.voidage if case.exchange else "none"
    return method == "divided", f"exchange.voidage = {method}"


@_part
def _gaussian_kernel(case: Case) -> tuple[bool, str]:
    method = case.exchange.voidage if case.exchange else "none"
    return method == "gaussian", f"exchange.voidage = {method}"


@_part
def _diffusion(case: Case) -> tuple[bool, str]:
    width = case.exchange.diffusion_width if case.exchange else None
    return width is not None, f"exchange.diffusion_width = {width:g} diameters" if width else "no diffusion_width"


@_part
def _filter(case: Case) -> tuple[bool, str]:
    passes = case.exchange.filter_passes if case.exchange else 0
    return passes > 0, f"exchange.filter_passes = {passes}"


@_part
def _polydisperse_drag(case: Case) -> tuple[bool, str]:
    wanted = case.exchange is not None and case.exchange.polydisperse != "none"
    return wanted, "exchange.polydisperse" if wanted else "not asked for"


@_part
def _pressure_gradient_force(case: Case) -> tuple[bool, str]:
    wanted = case.exchange is not None and case.exchange.pressure_gradient
    return wanted, "exchange.pressure_gradient" if wanted else "not asked for"


@_part
def _viscous_force(case: Case) -> tuple[bool, str]:
    wanted = case.exchange is not None and case.exchange.viscous_force
    return wanted, "exchange.viscous_force" if wanted else "not asked for"


@_part
def _lift_force(case: Case) -> tuple[bool, str]:
    wanted = case.exchange is not None and case.exchange.lift_force
    return wanted, "exchange.lift_force" if wanted else "not asked for"


@_part
def _virtual_mass(case: Case) -> tuple[bool, str]:
    wanted = case.exchange is not None and case.exchange.virtual_mass
    return wanted, "exchange.virtual_mass" if wanted else "not asked for"


@_part
def _accelerated_drag(case: Case) -> tuple[bool, str]:
    return choose_acceleration(case)


@_part
def _heat(case: Case) -> tuple[bool, str]:
    return case.heat is not None, "[heat] in the case" if case.heat else "no [heat]: nothing has a temperature"


@_part
def _particle_heat(case: Case) -> tuple[bool, str]:
    both = case.heat is not None and case.particles is not None
    return both, "[heat] and [particles]" if both else "no particle has a temperature"


@_part
def _contact_conduction(case: Case) -> tuple[bool, str]:
    law = case.heat.contact_conduction if case.heat and case.particles else "none"
    return law != "none", f"heat.contact_conduction = {law}"


@_part
def _gas_heat(case: Case) -> tuple[bool, str]:
    needed = case.heat is not None and case.gas is not None
    return needed, "[heat] and [gas]" if needed else "no [heat], or no [gas]"


@_part
def _inlet_temperatures(case: Case) -> tuple[bool, str]:
    own = has_inlet_temperatures(case)
    return own, "an inlet has a temperature" if own else "what comes in has one temperature, or there is no heat"


@_part
def _hot_gas_walls(case: Case) -> tuple[bool, str]:
    hot = case.heat is not None and case.gas is not None and has_hot_walls(case.heat)
    return hot, "a wall has a temperature" if hot else "walls are adiabatic to gas, or there is no heat"
