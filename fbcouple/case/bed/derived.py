"""Numbers that follow from a case: particle mass and count, contact time, damping, DEM step, cell size.

Equation numbers are those of Hamidouche et al. 2019, Fluids 4(1):51.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import combinations_with_replacement
from typing import Literal

import numpy as np

from fbcouple.case.bed.contact_coefficients import Coefficients, find_pair, find_wall, list_coefficients
from fbcouple.case.bed.contact_steps import FREE, Contacts, Oscillator, count_steps
from fbcouple.case.bed.particle_types import Kind, list_kinds
from fbcouple.case.schema.gas import Domain, Gas
from fbcouple.case.schema.inlets import Inlet
from fbcouple.case.schema.particles import Contact, Particles
from fbcouple.case.schema.sections import Case
from fbcouple.physics.contact import contact_time, normal_damping
from fbcouple.results.inlet_speed import add_speeds, find_busiest, sum_rows

# 2 times the integral of dx/sqrt(1 - x^(5/2)) from 0 to 1.
_HERTZ_DURATION = 4.0 * math.sqrt(math.pi) * math.gamma(0.4) / (5.0 * math.gamma(0.9))
FEWEST_STEPS = 6
"""DEM steps in T_C, the paper's, below which a contact loses its restitution."""
STICK_PER_STEP = 0.5
"""Part of the slip that the viscous limit of Coulomb friction takes away in one DEM step."""
ROLLING_FACTOR = 3.5
"""How much faster slip dies away where a sphere may roll: 1 + m r^2/I."""
SKIN, SKIN_WITH_HISTORY = 0.3, 0.4
"""Skin of the neighbour lists over diameter: 0.3 is the fastest in a bed that bubbles and within 3 % in one that hardly
moves, where 0.5 costs 28 % (patil/c2, `bench skin`); history is copied at each new list."""
LOADED = 0.1
"""Force at rest over that of an impact at `impact_speed`, up to which a Hertz bed comes to rest: its stiffness then is
0.46 of the largest, and hardly depends on the load."""


def particle_volume(particles: Particles) -> float:
    """Volume of one sphere of `diameter` [m3]."""
    return math.pi / 6.0 * particles.diameter**3


def particle_mass(particles: Particles) -> float:
    """Mass of one sphere of `diameter` and `density` [kg]."""
    return particles.density * particle_volume(particles)


def hertz_modulus(contact: Contact) -> float:
    """Effective modulus E* [Pa] of two bodies of the same material: 1/E* = 2 (1 - nu^2)/E (Johnson 1985, eq. 4.20)."""
    assert contact.youngs_modulus is not None and contact.poisson_ratio is not None
    return contact.youngs_modulus / (2.0 * (1.0 - contact.poisson_ratio**2))


def hertz_overlap(modulus: float, mass: float, radius: float, speed: float) -> float:
    """Largest overlap [m] of an elastic Hertz impact: (15 m v^2/(16 R^(1/2) E*))^(2/5) (Johnson 1985, eq. 11.23).

    modulus: E* [Pa]; mass [kg] and radius [m] are the effective ones of the two bodies; speed [m/s].
    """
    return (15.0 * mass * speed**2 / (16.0 * math.sqrt(radius) * modulus)) ** 0.4


def hertz_contact_time(modulus: float, mass: float, radius: float, speed: float) -> float:
    """Duration T_C [s] of an elastic Hertz impact: 2.9432 delta_max/v (Johnson 1985, eq. 11.24)."""
    return _HERTZ_DURATION * hertz_overlap(modulus, mass, radius, speed) / speed


def pair_contact_time(contact: Contact, particles: Particles) -> float:
    """T_C [s] between two particles, the shortest contact of all kinds (hertz: at `impact_speed`)."""
    kinds = list_kinds(particles)
    return min(_kinds_contact_time(contact, one, other) for one, other in combinations_with_replacement(kinds, 2))


def find_spring(contact: Contact, kind: Kind) -> float:
    """Normal spring k_n [N/m] of `kind`: of parcels l times that of the case, so that overlap over diameter is that of
    the grains at the same speed, and under the same bed."""
    return contact.stiffness * kind.ratio


def _kinds_contact_time(contact: Contact, one: Kind, other: Kind) -> float:
    mass = effective(one.mass, other.mass)
    if contact.model == "hertz":
        assert contact.impact_speed is not None
        radius = effective(one.diameter / 2.0, other.diameter / 2.0)
        return hertz_contact_time(hertz_modulus(contact), mass, radius, contact.impact_speed)
    return contact_time(find_spring(contact, one), mass, find_pair(contact, one, other).restitution)


def effective(one: float, other: float) -> float:
    """Effective mass, or radius, of two bodies: one other/(one + other), to the last bit the same either way round."""
    less, more = sorted((one, other))
    return less / (1.0 + less / more)


def tangential_law(contact: Contact) -> Literal["no-history", "history"]:
    """Friction law of the contacts: as the case says, otherwise with history where there is friction at all."""
    if contact.tangential is not None:
        return contact.tangential
    pairs, walls = list_coefficients(contact)
    return "history" if any(one.friction > 0.0 for one in pairs + walls) else "no-history"


def neighbour_skin(contact: Contact, particles: Particles) -> float:
    """Skin of the neighbour lists [m]: they are made anew when a particle has gone half of it."""
    skin = contact.skin or (SKIN_WITH_HISTORY if tangential_law(contact) == "history" else SKIN)
    return skin * min(kind.diameter for kind in list_kinds(particles))


def tangential_stiffness(contact: Contact) -> float:
    """k_t/k_n of the tangential spring; 2/7 makes both directions of a rolling sphere equally fast."""
    return 2.0 / 7.0 if contact.tangential_stiffness is None else contact.tangential_stiffness


def tangential_damping(contact: Contact) -> float:
    """Tangential over normal damping rate, 1/2 where the case does not say."""
    return 0.5 if contact.tangential_damping is None else contact.tangential_damping


def steps_per_contact(contact: Contact, particles: Particles) -> int:
    """DEM steps in T_C: as the case says, otherwise as few as let a packed bed come to rest, at least 6."""
    return contact.steps_per_contact or max(FEWEST_STEPS, math.ceil(least_steps(contact, particles)))


def least_steps(contact: Contact, particles: Particles) -> float:
    """Number of DEM steps in T_C below which a packed bed of these particles cannot come to rest."""
    kinds, time = list_kinds(particles), pair_contact_time(contact, particles)
    pairs = []
    for one, other in combinations_with_replacement(kinds, 2):
        mass, diameter = effective(one.mass, other.mass), effective(one.diameter, other.diameter)
        spring = find_spring(contact, one)
        pairs.append(_oscillate(contact, spring, find_pair(contact, one, other), mass, diameter, time))
    walls = [
        _oscillate(contact, find_spring(contact, kind), find_wall(contact, kind), kind.mass, kind.diameter, time)
        for kind in kinds
    ]
    return count_steps(pairs, walls, particles.rotation)


def _oscillate(
    contact: Contact, spring: float, coefficients: Coefficients, mass: float, diameter: float, time: float
) -> Contacts:
    """A resting contact of a linear `spring` [N/m], or Hertz's, of effective `mass` [kg] and `diameter` [m], as
    oscillators in units of `time` [s].

    A Hertz contact is as stiff as under `LOADED` of the largest force of an impact at `impact_speed`, and damped as
    LIGGGHTS does it: sqrt(5/6) of a linear spring as stiff.
    """
    loss = 1.0
    across, loss_across = tangential_stiffness(contact), tangential_damping(contact)
    if contact.model == "hertz":
        assert contact.impact_speed is not None and contact.poisson_ratio is not None
        modulus = hertz_modulus(contact)
        overlap = hertz_overlap(modulus, mass, diameter / 2.0, contact.impact_speed) * LOADED ** (2.0 / 3.0)
        spring, loss = 2.0 * modulus * math.sqrt(diameter / 2.0 * overlap), math.sqrt(5.0 / 6.0)
        across = 2.0 * (1.0 - contact.poisson_ratio) / (2.0 - contact.poisson_ratio)
        loss_across = math.sqrt(across)
    rate = 2.0 * normal_damping(spring, mass, coefficients.restitution) * loss
    normal = Oscillator(spring / mass * time**2, rate * time)
    slides = coefficients.friction > 0.0 and tangential_law(contact) == "history"
    return Contacts(normal, Oscillator(across * normal.spring, loss_across * normal.damping) if slides else FREE)


def viscous_limit(contact: Contact, particles: Particles) -> float:
    """Rate [1/s] that gives Coulomb friction without history its slope at no slip: `STICK_PER_STEP` of the slip of two
    particles is gone in a DEM step."""
    return STICK_PER_STEP / dem_step(contact, particles) / (ROLLING_FACTOR if particles.rotation else 1.0)


def dem_step(contact: Contact, particles: Particles) -> float:
    """Constant DEM step [s]: T_C over the steps of a contact (eq. 42)."""
    return pair_contact_time(contact, particles) / steps_per_contact(contact, particles)


def cell_size(case: Case) -> np.ndarray:
    """Edge lengths of a cell [m], shape (3,); where cells are no boxes, those of the grid of the averages."""
    return np.array(case.domain.size) / np.array(case.domain.cells)


def wraps(domain: Domain) -> tuple[bool, bool, bool]:
    """Does the bed repeat itself along x, y and z?"""
    return "x" in domain.periodic, "y" in domain.periodic, False


def inlet_rows(inlet: Inlet) -> tuple[tuple[float, float], ...]:
    """Times [s] and superficial velocities [m/s] over one of the `inlets`."""
    return inlet.ramp or ((0.0, inlet.velocity or 0.0),)


def inlet_ramp(gas: Gas) -> tuple[tuple[float, float], ...]:
    """Times [s] and superficial velocities [m/s] over the whole floor, of `inlets` that of all of them together; a
    constant inlet is a ramp of one row."""
    if gas.inlets:
        return _sum_inlets(gas)
    if gas.inlet_ramp is not None:
        return gas.inlet_ramp
    assert gas.inlet_velocity is not None, "the checks ask for one of the two"
    return ((0.0, gas.inlet_velocity),)


@lru_cache(maxsize=8)
def _sum_inlets(gas: Gas) -> tuple[tuple[float, float], ...]:
    return tuple(sum_rows(_list_parts(gas)))


def _list_parts(gas: Gas) -> list[tuple[float, tuple[tuple[float, float], ...]]]:
    """Of each inlet its part of the whole inlet's area, and its rows."""
    if not gas.inlets:
        return [(1.0, inlet_ramp(gas))]
    assert gas.inlet_section is not None, "adopt_inlets fills it in"
    return [((inlet.area or 0.0) / gas.inlet_section, inlet_rows(inlet)) for inlet in gas.inlets]


def has_ramp(gas: Gas) -> bool:
    """Does the inflow change in time?"""
    return gas.inlet_ramp is not None or any(inlet.ramp for inlet in gas.inlets)


def inlet_range(gas: Gas, start: float, end: float) -> tuple[float, float]:
    """Least and largest superficial velocity [m/s] at the inlet from `start` to `end` [s], both sides of a jump."""
    ramp = inlet_ramp(gas)
    times, velocities = zip(*ramp, strict=True)
    known = [velocity for time, velocity in ramp if start <= time <= end]
    known += [float(velocity) for velocity in np.interp((start, end), times, velocities)]
    return min(known), max(known)


@lru_cache(maxsize=8)
def fastest_inlet(gas: Gas) -> float:
    """Largest superficial speed [m/s] of what passes the inlet in the whole run, in or out: of `inlets` the sum of all,
    where what goes out by one does not make up for what comes in by another."""
    return find_busiest(_list_parts(gas))


def inlet_speed(gas: Gas, time: float) -> float:
    """Superficial speed [m/s] of what passes the inlet at `time` [s], as `fastest_inlet` counts it."""
    return add_speeds(_list_parts(gas), time)


def fastest_inflow(gas: Gas) -> float:
    """Largest superficial speed [m/s] of all that comes in, less what goes out, in the whole run, up or down."""
    return max(abs(velocity) for _, velocity in inlet_ramp(gas))


def open_share(case: Case) -> float:
    """Area of the whole floor over that of its open faces: A/(A - A_closed)."""
    assert case.gas is not None
    if case.domain.shape != "box":
        return 1.0
    if case.gas.closed_nozzle_size:
        (width, depth, _), (along, across) = case.domain.size, case.gas.closed_nozzle_size
        return width * depth / (width * depth - along * across)
    nx, ny, _ = case.domain.cells
    closed = case.gas.closed_nozzle[0] * case.gas.closed_nozzle[1] if case.gas.closed_nozzle else 0
    return nx * ny / (nx * ny - closed)


def open_range(case: Case) -> tuple[float, float]:
    """Least and largest superficial velocity [m/s] through open faces in the whole run: U_f A/(A - A_closed), of
    `inlets` that of the fastest, in the middle of its profile."""
    assert case.gas is not None
    if not case.gas.inlets:
        velocities = [velocity for _, velocity in inlet_ramp(case.gas)]
        return open_share(case) * min(velocities), open_share(case) * max(velocities)
    found = [_find_peak(inlet) * velocity for inlet in case.gas.inlets for _, velocity in inlet_rows(inlet)]
    return min(found), max(found)


def _find_peak(inlet: Inlet) -> float:
    """Velocity in the middle of an inlet over its mean."""
    if inlet.profile_file is not None:
        return inlet.peak or 1.0
    if inlet.profile == "flat":
        return 1.0
    return 2.0 if inlet.circle else 2.25


def open_velocity(case: Case) -> float:
    """Largest superficial speed [m/s] through the open faces of the inlet, in or out."""
    return max(map(abs, open_range(case)))
