"""Parts of a case: its preset, its phases, its region and the gas."""

from __future__ import annotations

from fbcouple.case.bed.derived import has_ramp
from fbcouple.case.bed.region import has_own_mesh
from fbcouple.case.bed.streams import has_openings
from fbcouple.case.presets import NONE, describe_preset
from fbcouple.case.schema.sections import Case
from fbcouple.decks.parts import Decision, register

GAS: dict[str, Decision] = {}
_part = register(GAS)


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
    return closed, "gas.top = closed" if closed else "gas.top is open"


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
