"""Numbers that follow from a case: particle mass and count, contact time, damping, DEM step, cell size.

Equation numbers are those of Hamidouche et al. 2019, Fluids 4(1):51.
"""

from __future__ import annotations

import math

import numpy as np

from fbcouple.case.schema import Case, Contact, Particles


def particle_volume(particles: Particles) -> float:
    """Volume of one sphere [m3]."""
    return math.pi / 6.0 * particles.diameter**3


def particle_mass(particles: Particles) -> float:
    """Mass of one sphere [kg]."""
    return particles.density * particle_volume(particles)


def particle_count(particles: Particles) -> int:
    """Number of particles: as given, or the bed's mass over the mass of one, rounded."""
    if particles.count is not None:
        return particles.count
    assert particles.mass is not None, "the schema's checks ask for count or mass"
    return round(particles.mass / particle_mass(particles))


def normal_damping(stiffness: float, mass: float, restitution: float) -> float:
    """Damping rate gamma_n [1/s] of a contact with effective mass `mass` [kg] and spring `stiffness` [N/m] (eq. 18)."""
    log_e = math.log(restitution)
    return -math.sqrt(stiffness / mass) * log_e / math.hypot(math.pi, log_e)


def contact_time(stiffness: float, mass: float, restitution: float) -> float:
    """Duration T_C [s] of a contact (eq. 19)."""
    return math.pi / math.sqrt(stiffness / mass - normal_damping(stiffness, mass, restitution) ** 2)


def pair_contact_time(contact: Contact, particles: Particles) -> float:
    """T_C [s] between two particles, the shortest contact of a monodisperse bed."""
    return contact_time(contact.stiffness, particle_mass(particles) / 2.0, contact.restitution)


def dem_step(contact: Contact, particles: Particles) -> float:
    """Constant DEM step [s]: T_C over `steps_per_contact` (eq. 42)."""
    return pair_contact_time(contact, particles) / contact.steps_per_contact


def cell_size(case: Case) -> np.ndarray:
    """Edge lengths of a cell [m], shape (3,)."""
    return np.array(case.domain.size) / np.array(case.domain.cells)


def open_velocity(case: Case) -> float:
    """Superficial velocity [m/s] through the open faces of the floor: U_f A/(A - A_closed)."""
    assert case.gas is not None
    nx, ny, _ = case.domain.cells
    closed = case.gas.closed_nozzle[0] * case.gas.closed_nozzle[1] if case.gas.closed_nozzle else 0
    return case.gas.inlet_velocity * nx * ny / (nx * ny - closed)
