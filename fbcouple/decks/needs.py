"""What a case needs, and why the rest is left out: the one place that decides what appears in the decks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fbcouple.case.bed.acceleration import choose_acceleration
from fbcouple.case.bed.contact_coefficients import list_coefficients
from fbcouple.case.bed.derived import has_ramp, tangential_law
from fbcouple.case.bed.feeds import has_traffic
from fbcouple.case.bed.gas_heat import has_hot_walls
from fbcouple.case.bed.outlets import list_openings
from fbcouple.case.bed.particle_types import count_kinds, grains_per_parcel, list_kinds, particle_count
from fbcouple.case.bed.region import has_own_mesh
from fbcouple.case.bed.streams import has_openings
from fbcouple.case.presets import NONE, describe_preset
from fbcouple.case.schema.sections import Case


@dataclass(frozen=True)
class Part:
    """A part of a case: is it in, and why."""

    name: str
    is_in: bool
    why: str


Decision = Callable[[Case], tuple[bool, str]]
_DECISIONS: dict[str, Decision] = {}


def _part(decide: Decision) -> Decision:
    _DECISIONS[decide.__name__.strip("_")] = decide
    return decide


@_part
def _preset(case: Case) -> tuple[bool, str]:
    return case.accuracy != NONE, describe_preset(case)


@_part
def _gas(case: Case) -> tuple[bool, str]:
    return case.gas is not None, "[gas] in the case" if case.gas else "no [gas]: OpenFOAM never starts"


@_part
def _particles(case: Case) -> tuple[bool, str]:
    there = case.particles is not None
    return there, "[particles] in the case" if there else "no [particles]: LIGGGHTS never starts"


@_part
def _coupling(case: Case) -> tuple[bool, str]:
    both = case.gas is not None and case.particles is not None
    return both, "gas and particles" if both else "one phase only: nothing is exchanged"


@_part
def _block_mesh(case: Case) -> tuple[bool, str]:
    needed = case.gas is not None and not has_own_mesh(case)
    words = "faces are parted for gas.inlets and gas.outlets" if has_openings(case) else ""
    return needed, (words or f"domain.shape = {case.domain.shape}") if case.gas else "no [gas]: no mesh"


@_part
def _mesh_of_polyhedra(case: Case) -> tuple[bool, str]:
    words = f"domain.shape = {case.domain.shape}" + (f" of {case.domain.elements}" if case.domain.elements else "")
    return not case.domain.is_plain_box, words


@_part
def _surface_walls(case: Case) -> tuple[bool, str]:
    needed = case.particles is not None and case.domain.shape != "box"
    return needed, f"domain.shape = {case.domain.shape}" if case.particles else "no [particles]: nothing meets walls"


@_part
def _closed_nozzle(case: Case) -> tuple[bool, str]:
    closed = case.gas is not None and case.gas.closed_nozzle is not None
    return closed, "gas.closed_nozzle is given" if closed else "the whole floor is open"


@_part
def _openings(case: Case) -> tuple[bool, str]:
    words = "gas.inlets, gas.outlets or gas.closed_nozzle_size"
    there = has_openings(case)
    return there, words if there else "gas comes in by the floor and leaves at the top"


@_part
def _lid(case: Case) -> tuple[bool, str]:
    closed = case.gas is not None and case.gas.top == "closed"
    return closed, "gas.top = closed" if closed else "gas leaves at the top"


@_part
def _periodic(case: Case) -> tuple[bool, str]:
    axes = " and ".join(case.domain.periodic)
    return bool(axes), f"domain.periodic = {axes}" if axes else "walls on all sides"


@_part
def _inlet_ramp(case: Case) -> tuple[bool, str]:
    ramp = case.gas is not None and has_ramp(case.gas)
    return ramp, "gas.inlet_ramp, or a ramp of gas.inlets" if ramp else "the inlet has one velocity"


@_part
def _superficial_inlet(case: Case) -> tuple[bool, str]:
    if case.gas is None:
        return False, "no [gas]: nothing comes in"
    if has_openings(case):
        return True, "faces have parts of several velocities"
    if case.domain.shape == "file":
        return True, "each face of the mesh's inlet has its own normal"
    ramp = case.gas.inlet_ramp is not None
    return ramp, "gas.inlet_ramp is given" if ramp else "one velocity by a level floor: OpenFOAM's own condition"


@_part
def _turbulence(case: Case) -> tuple[bool, str]:
    model = case.gas.turbulence if case.gas else "none"
    return model != "none", f"gas.turbulence = {model}"


@_part
def _subgrid_energy(case: Case) -> tuple[bool, str]:
    model = case.gas.turbulence if case.gas else "none"
    return model == "keqn", f"gas.turbulence = {model}"


@_part
def _lagrangian_averages(case: Case) -> tuple[bool, str]:
    model = case.gas.turbulence if case.gas else "none"
    return model == "dynamic-lagrangian", f"gas.turbulence = {model}"


@_part
def _pair_friction(case: Case) -> tuple[bool, str]:
    friction = max(pair.friction for pair in list_coefficients(case.contact)[0]) if case.contact else 0.0
    return friction > 0, f"contact.friction = {friction}"


@_part
def _wall_friction(case: Case) -> tuple[bool, str]:
    friction = max(wall.friction for wall in list_coefficients(case.contact)[1]) if case.contact else 0.0
    return friction > 0, f"contact.wall_friction = {friction}"


@_part
def _tangential_history(case: Case) -> tuple[bool, str]:
    tangential = tangential_law(case.contact) if case.contact else "no-history"
    return tangential == "history", f"contact.tangential = {tangential}"


@_part
def _rolling_friction(case: Case) -> tuple[bool, str]:
    friction = case.contact.rolling_friction if case.contact else 0.0
    return friction > 0, f"contact.rolling_friction = {friction}"


@_part
def _hertz(case: Case) -> tuple[bool, str]:
    model = case.contact.model if case.contact else "hooke"
    return model == "hertz", f"contact.model = {model}"


@_part
def _damping(case: Case) -> tuple[bool, str]:
    if case.contact is None:
        return False, "no contacts"
    pairs, walls = list_coefficients(case.contact)
    damped = min(contact.restitution for contact in pairs + walls) < 1.0
    return damped, "a restitution below 1" if damped else "both restitutions are 1: LIGGGHTS gets zero damping"


@_part
def _rotation(case: Case) -> tuple[bool, str]:
    rotates = case.particles is not None and case.particles.rotation
    return rotates, "particles.rotation" if rotates else "positions and velocities only (fix nve)"


@_part
def _mixture(case: Case) -> tuple[bool, str]:
    kinds = list_kinds(case.particles) if case.particles else []
    if len(kinds) < 2:
        return False, "all particles are alike"
    assert case.particles is not None
    counted = zip(count_kinds(case.particles), kinds, strict=True)
    return True, "; ".join(f"{count} of {kind.diameter:.4g} m, {kind.density:g} kg m-3" for count, kind in counted)


@_part
def _coarse_graining(case: Case) -> tuple[bool, str]:
    if case.particles is None or case.particles.coarse_graining is None:
        return False, "each particle is one of LIGGGHTS"
    grains, count = grains_per_parcel(case.particles), particle_count(case.particles)
    return True, f"{count} parcels of {grains:.6g} particles each, {case.particles.coarse_graining:.6g} times as wide"


@_part
def _feeds_and_outlets(case: Case) -> tuple[bool, str]:
    if not has_traffic(case):
        return False, "no particles come or go"
    assert case.particles is not None
    return True, f"{len(case.particles.feeds)} feeds, {len(case.particles.outlets)} outlets of particles"


@_part
def _empty_start(case: Case) -> tuple[bool, str]:
    empty = case.particles is not None and case.particles.count == 0
    return empty, "particles.count = 0" if empty else "particles at the start, or none at all"


@_part
def _open_walls(case: Case) -> tuple[bool, str]:
    openings = list_openings(case)
    where = " and ".join(sorted({one.face or "patches of the mesh" for one in openings}))
    return bool(openings), f"particles leave by {where}" if openings else "particles leave by no wall"


@_part
def _gravity(case: Case) -> tuple[bool, str]:
    return case.gravity > 0, f"gravity = {case.gravity}"


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
def _hot_gas_walls(case: Case) -> tuple[bool, str]:
    hot = case.heat is not None and case.gas is not None and has_hot_walls(case.heat)
    return hot, "a wall has a temperature" if hot else "walls are adiabatic to gas, or there is no heat"


@_part
def _averages(case: Case) -> tuple[bool, str]:
    return case.averages is not None, "[averages] in the case" if case.averages else "no [averages]"


@_part
def _voidage_snapshots(case: Case) -> tuple[bool, str]:
    every = case.output.snapshots_every
    return every is not None, "no output.snapshots_every" if every is None else f"output.snapshots_every = {every}"


@_part
def _frames(case: Case) -> tuple[bool, str]:
    every = case.output.particles_every
    return every is not None, "no output.particles_every" if every is None else f"output.particles_every = {every}"


@_part
def _tracked_particles(case: Case) -> tuple[bool, str]:
    count = len(case.output.tracked)
    return count > 0, f"output.tracked has {count}" if count else "no output.tracked"


@_part
def _probes(case: Case) -> tuple[bool, str]:
    sets = case.output.probes
    return len(sets) > 0, f"output.probes has {len(sets)}" if sets else "no output.probes"


def explain(case: Case) -> list[Part]:
    """Every part a case can have, whether this one has it, and why."""
    return [Part(name, *decide(case)) for name, decide in _DECISIONS.items()]


def tell_parts(case: Case) -> dict[str, dict[str, str]]:
    """What a manifest says of it: the parts that are in and those that are left out, each with why."""
    parts = explain(case)
    return {
        "in": {part.name: part.why for part in parts if part.is_in},
        "left_out": {part.name: part.why for part in parts if not part.is_in},
    }


def find_needs(case: Case) -> dict[str, bool]:
    """Part name -> is it in, for the templates and the time loop."""
    return {part.name: part.is_in for part in explain(case)}
