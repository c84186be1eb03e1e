"""Numbers that tell before a run whether a case can work: steps against response times, cells, bed and gas."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.checks import machine_memory, needed_memory
from fbcouple.case.contact_numbers import tell_creep, time_contacts
from fbcouple.case.derived import (
    cell_size,
    dem_step,
    fastest_inlet,
    hertz_modulus,
    hertz_overlap,
    inlet_range,
    open_velocity,
)
from fbcouple.case.drag_file import OWN
from fbcouple.case.mixture import (
    Kind,
    largest_diameter,
    list_kinds,
    mean_density,
    mean_kind,
    mean_volume,
    particle_count,
    solids_volume,
)
from fbcouple.case.numbers import Number, Verdict
from fbcouple.case.pairs import find_pair
from fbcouple.case.region import find_region, list_inner_surfaces
from fbcouple.case.schema import Case, Contact
from fbcouple.case.start_numbers import describe_start
from fbcouple.collision import normal_damping
from fbcouple.errors import CaseError

Law = Callable[..., Any]
"""A drag law: beta [kg/s] of voidage, slip, diameter, gas density and viscosity."""

PACKED = 0.42
"""Voidage of a packed bed, where the gas responds fastest."""
EXPANDED = 0.40
"""Voidage of the interstitial velocity and of minimum fluidization."""
SETTLED = 0.60
"""Solids fraction of the bed at rest."""
STABLE_EXPLICIT = 2.0
"""Step over response time above which an explicit source grows."""

COARSE, ABSURD = 100.0, 1000.0
"""Cell sizes over the diameter: above the first a cell tells little of a bed, above the second a length is no meter."""

TURBULENT = 2300.0
"""Bulk Reynolds number below which gas in a duct is laminar."""


def estimate(case: Case, law: Law | None = None, folder: Path = Path()) -> list[Number]:
    """Return the pre-flight numbers of a case that passed its checks; a scene gets only those that apply to it.

    law: the case's own drag law; without it a case that has one gets no numbers of its drag. folder: where the case's
    own files lie.

    Raises: CaseError if a value is so large or small that they cannot be calculated.
    """
    region = find_region(case, folder)
    parts: list[Callable[[Case], Iterator[Number]]] = [partial(_size_up, folder=folder)]
    if case.particles:
        parts.append(partial(_tell_start, folder=folder))
    if case.particles and case.contact:
        parts += [time_contacts, _measure_overlap]
    if case.particles and case.gravity > 0.0:
        parts.append(partial(_weigh_bed, floor=region.floor, cell=float(region.spacing[2])))
        if case.contact:
            parts.append(partial(_watch_rest, law=law))
    if case.gas:
        parts.append(_time_gas)
    if case.gas and case.particles and case.exchange:
        parts.append(partial(_measure_cells, cell=region.spacing))
        if law or case.exchange.drag != OWN:
            parts += [partial(_time_exchange, law=law), partial(_fluidize, law=law)]
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            return [number for part in parts for number in part(case)]
    except ArithmeticError:
        text = "the values are too large or too small to calculate with; give every one in SI units."
        raise CaseError([f"case: {text}"]) from None


def require_fit(case: Case, law: Law | None = None, folder: Path = Path()) -> None:
    """Raise CaseError, one text a number, if a pre-flight number says that the case cannot work."""
    mend = "mend the case, or set it up all the same with --force."
    problems = [
        f"{number.name}: {number.value:.4g} {number.unit} is expected, {number.limit} is fit; {mend} {number.meaning}"
        for number in estimate(case, law, folder)
        if number.verdict == "unfit"
    ]
    if problems:
        raise CaseError(problems)


def gas_step(case: Case) -> float:
    """Fluid step [s] that the Courant limit at U_f/0.40, the Fourier limit and `gas.max_step` allow."""
    assert case.gas is not None
    cell = cell_size(case)
    fourier = case.gas.max_fourier * case.gas.density / case.gas.viscosity / float((1.0 / cell**2).sum())
    speed = fastest_inlet(case.gas) / (EXPANDED if case.particles else 1.0)
    courant = case.gas.max_courant * float(cell[2]) / speed if speed > 0.0 else math.inf
    return min(fourier, courant, case.gas.max_step or math.inf)


def coupling_step(case: Case) -> float:
    """Step [s] of a scene of both phases: the fluid step, and no less than the one DEM step that it has to hold."""
    assert case.particles is not None and case.contact is not None
    return max(gas_step(case), dem_step(case.contact, case.particles))


def minimum_fluidization(case: Case, voidage: float = EXPANDED, law: Law | None = None) -> float:
    """Superficial velocity [m/s] at which the case's drag carries the weight of a bed of `voidage`.

    n beta u/eps = (1 - eps)(rho_p - rho) g with u = U/eps and (1 - eps)/V_p particles per volume (model A).
    """
    assert case.particles is not None
    return voidage * _balance(case, voidage, law, mean_kind(case.particles))


def terminal_velocity(case: Case, law: Law | None = None) -> float:
    """Speed [m/s] at which the case's drag carries the weight of a lone particle, the slowest of a mixture."""
    assert case.particles is not None
    return min(_balance(case, 1.0, law, kind) for kind in list_kinds(case.particles))


def _balance(case: Case, voidage: float, law: Law | None, kind: Kind) -> float:
    """Slip [m/s] at which beta(u) u = eps V_p (rho_p - rho) g, by bisection."""
    assert case.gas is not None
    weight = voidage * kind.volume * (kind.density - case.gas.density) * case.gravity
    low, high = 0.0, 1e-9
    while _drag(case, voidage, high, law, kind) * high < weight:
        high *= 2.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _drag(case, voidage, middle, law, kind) * middle < weight else (low, middle)
    return high


def _drag(case: Case, voidage: float, slip: float, law: Law | None, kind: Kind) -> float:
    """Drag coefficient beta [kg/s] of one particle by `law`, or by the case's law of the registry."""
    from fbcouple.exchange.drag import DRAG_LAWS  # noqa: PLC0415  (loads numba)

    assert case.gas is not None and case.exchange is not None
    law = law or DRAG_LAWS[case.exchange.drag]
    return float(law(voidage, slip, kind.diameter, case.gas.density, case.gas.viscosity))


def _largest_overlap(contact: Contact, kind: Kind, speed: float) -> float:
    """Overlap over diameter of a head-on contact of two of a kind at relative speed `speed` [m/s] (eqs 43-45; elastic
    for hertz)."""
    mass = kind.mass / 2.0
    if contact.model == "hertz":
        return hertz_overlap(hertz_modulus(contact), mass, kind.diameter / 4.0, speed) / kind.diameter
    damping = normal_damping(contact.stiffness, mass, find_pair(contact, kind, kind).restitution)
    swing = math.sqrt(contact.stiffness / mass - damping**2)
    reach = speed / math.sqrt(contact.stiffness / mass) * math.exp(-damping / swing * math.atan2(swing, damping))
    return reach / kind.diameter


def _judge(fits: bool, otherwise: Verdict = "warn") -> Verdict:
    return "fit" if fits else otherwise


def _size_up(case: Case, folder: Path) -> Iterator[Number]:
    if case.particles:
        yield Number("particles", particle_count(case.particles), "1", None, None, "Particles in the bed.")
    if case.gas:
        yield Number("cells", find_region(case, folder).cells, "1", None, None, "Cells of the gas mesh.")
    for name, faces in list_inner_surfaces(case, folder).items():
        meaning = f"Faces of the surface {name} between two cells: no wall; gas and particles pass through it."
        yield Number("inner faces", faces, "1", "none", "warn", meaning)
    held, needed = machine_memory() / 1e9, needed_memory(case, folder) / 1e9
    meaning = "1 kB a particle and 2 kB a cell, over all ranks."
    yield Number("memory", needed, "GB", f"below {held:.3g} (this machine)", _judge(needed < held, "unfit"), meaning)


def _tell_start(case: Case, folder: Path) -> Iterator[Number]:
    for name, value, unit, limit, fits, meaning in describe_start(case, folder):
        yield Number(name, value, unit, limit, _judge(fits), meaning)


def _measure_overlap(case: Case) -> Iterator[Number]:
    assert case.particles is not None and case.contact is not None
    contact, particles = case.contact, case.particles
    if case.gas and (fastest := fastest_inlet(case.gas)) > 0.0:
        overlap = max(_largest_overlap(contact, kind, fastest) for kind in list_kinds(particles))
        meaning = "Overlap over diameter of a head-on contact at the inlet velocity; a stiffer spring lowers it."
        verdict = _judge(overlap <= 0.05, "warn" if overlap <= 0.2 else "unfit")
        yield Number("overlap", overlap, "d", "at most 0.05", verdict, meaning)


def _weigh_bed(case: Case, floor: float, cell: float) -> Iterator[Number]:
    assert case.particles is not None
    solids = solids_volume(case.particles)
    height, box = solids / (SETTLED * floor), case.domain.size[2]
    verdict = _judge(height < box, "unfit")
    yield Number("settled height", height, "m", f"below {box:g}", verdict, "Bed at rest, solids fraction 0.60.")
    if case.gas:
        meaning = (
            "Settled height over the cell's: the surface is smeared over a cell, one more a filter pass, and beds "
        )
        meaning += "5-14 cells high cost 6-12 % less pressure than the drag law at their mean voidage."
        yield Number("bed height in cells", height / cell, "cells", None, None, meaning)
        drop = solids * (mean_density(case.particles) - case.gas.density) * case.gravity / floor
        yield Number("pressure drop", drop, "Pa", None, None, "Weight less buoyancy over floor: the fluidized bed.")


def _watch_rest(case: Case, law: Law | None) -> Iterator[Number]:
    """Does friction have to hold the bed at rest: no gas, or at some time less than fluidizes it?"""
    assert case.particles is not None
    slowest, onset = 0.0, math.inf
    if case.gas:
        slowest = max(inlet_range(case.gas, 0.0, case.end_time)[0], 0.0)
        known = case.exchange and (law or case.exchange.drag != OWN)
        heavier = mean_density(case.particles) > case.gas.density
        onset = (minimum_fluidization(case, law=law) if heavier else 0.0) if known else 0.0
    yield from tell_creep(case, rests=slowest == 0.0 or slowest < onset)


def _time_gas(case: Case) -> Iterator[Number]:
    assert case.gas is not None
    meaning = "What the Courant limit at U_f/0.40, the Fourier limit and max_step allow; a lively bed takes less."
    yield Number("fluid step", gas_step(case), "s", None, None, meaning)
    meaning = "Superficial velocity through the open faces of the floor."
    yield Number("open inlet velocity", open_velocity(case), "m s-1", None, None, meaning)
    if case.gas.turbulence != "none":
        reynolds = fastest_inlet(case.gas) * case.domain.size[0] * case.gas.density / case.gas.viscosity
        meaning = "Of the superficial velocity and the bed's width; a sub-grid model adds nothing to laminar gas."
        limit = f"above {TURBULENT:g} (gas.turbulence)"
        yield Number("bulk Reynolds number", reynolds, "1", limit, _judge(reynolds > TURBULENT), meaning)


def response_times(case: Case, law: Law | None = None, voidage: float = PACKED) -> dict[str, float]:
    """Response times [s] of the gas, tau_g = eps rho/(n beta), and of the particles, tau_p = m/beta, the shortest of a
    mixture, in a bed of `voidage` that the fastest inlet flows through."""
    assert case.gas is not None and case.particles is not None
    slip = fastest_inlet(case.gas) / voidage
    kinds = list_kinds(case.particles)
    drags = [_drag(case, voidage, slip, law, kind) for kind in kinds]
    per_particle = sum(kind.share * beta for kind, beta in zip(kinds, drags, strict=True))
    return {
        "tau_g": voidage * case.gas.density * mean_volume(case.particles) / ((1.0 - voidage) * per_particle),
        "tau_p": min(kind.mass / beta for kind, beta in zip(kinds, drags, strict=True)),
    }


def _time_exchange(case: Case, law: Law | None) -> Iterator[Number]:
    assert case.gas is not None and case.particles is not None and case.exchange is not None
    step = coupling_step(case) if case.contact else gas_step(case)
    for name, time in response_times(case, law).items():
        limit = f"below {STABLE_EXPLICIT:g} (explicit drag)" if case.exchange.scheme == "explicit" else None
        verdict = _judge(step / time < STABLE_EXPLICIT, "unfit") if limit else None
        whose = "gas" if name == "tau_g" else "particles"
        meaning = f"Fluid step over the response time of the {whose} in a packed bed, {time:.3g} s."
        yield Number(f"fluid step/{name}", step / time, "1", limit, verdict, meaning)
    if case.contact:
        meaning = "DEM steps in a fluid step; below 1 the step is a DEM step, longer than the gas wants it."
        held = gas_step(case) / dem_step(case.contact, case.particles)
        yield Number("DEM steps per fluid step", held, "1", "at least 1", _judge(held >= 1.0), meaning)


def _measure_cells(case: Case, cell: np.ndarray) -> Iterator[Number]:
    assert case.particles is not None and case.exchange is not None
    wanted = 1.0 if case.exchange.filter_passes else 3.0
    limit = f"{wanted:g} to {COARSE:g} ({'with' if case.exchange.filter_passes else 'without'} filter)"
    full = (math.pi / 6.0) ** (1.0 / 3.0)
    if width := case.exchange.kernel_width or case.exchange.diffusion_width:
        yield from _measure_spread(case, width)
        return
    for axis, size in zip("xyz", cell / largest_diameter(case.particles), strict=True):
        verdict = _judge(wanted <= size <= COARSE, "warn" if full < size <= ABSURD else "unfit")
        meaning = (
            f"Cell size over diameter along {axis}; a cube of {full:.2f} is filled by one particle. Thousands: a "
            "length is not in m (domain.scale for a mesh)."
        )
        yield Number(f"cell size {axis}", float(size), "d", limit, verdict, meaning)


def _measure_spread(case: Case, width: float) -> Iterator[Number]:
    """The kernel, not the cell, says over what a particle is spread: cells may be small, and should be."""
    assert case.particles is not None
    for axis, size in zip("xyz", cell_size(case) / case.particles.diameter, strict=True):
        meaning = (
            f"The bandwidth over the cell size along {axis}; below 1 the cells spread a particle more than it does."
        )
        verdict = _judge(width >= size, "warn" if size <= ABSURD else "unfit")
        yield Number(f"width {axis}", width / float(size), "cells", "at least 1", verdict, meaning)


def _fluidize(case: Case, law: Law | None) -> Iterator[Number]:
    assert case.gas is not None and case.particles is not None
    if case.gravity == 0.0 or mean_density(case.particles) <= case.gas.density:
        return
    inlet = fastest_inlet(case.gas)
    onset, terminal = minimum_fluidization(case, law=law), terminal_velocity(case, law)
    meaning = "U_mf of the case's drag law at voidage 0.40; below it the bed stays packed."
    yield Number("minimum fluidization", onset, "m s-1", f"below U_f = {inlet:g}", _judge(onset < inlet), meaning)
    meaning = "Fall speed of a lone particle; with more gas than that the particles leave with it."
    yield Number("terminal velocity", terminal, "m s-1", f"above U_f = {inlet:g}", _judge(terminal > inlet), meaning)
