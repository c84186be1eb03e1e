"""Forces beside drag and pressure gradient, for cases that ask for them; nothing here runs otherwise.

A force is one function under `@force`: it adds what acts on each particle, from a vector field of the gas read at the
particle with the same weights as its velocity. What a particle gets the gas loses in the same step, through S.

The inertia of the gas around a sphere, m_a = C rho V with C = 1/2, is treated as a part of the particle (the solver of
the particles has it in their mass). What is left of the virtual mass force is m_a Du/Dt on the particle, its d/dt
implicit in the new gas velocity, and m_a (dv/dt - Du/Dt) on the gas, with the dv/dt of the particle's last move.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fbcouple.case.bed.particle_types import find_ratio, grains_per_parcel
from fbcouple.case.schema.sections import Case
from fbcouple.coupling.box.corners import Stencil, corner_weights
from fbcouple.coupling.box.mapping import Mapping
from fbcouple.coupling.discretisation import Space
from fbcouple.coupling.particles import Particles
from fbcouple.coupling.polyhedral.mapping import CellMapping
from fbcouple.physics.jit import compiled, inlined

ADDED_MASS = 0.5
"""C of a sphere: the gas that it carries along over the gas that it displaces."""

Kernel = Callable[[np.ndarray, np.ndarray, np.ndarray, float, float, np.ndarray], None]

Way = Mapping | CellMapping


@dataclass(frozen=True)
class Force:
    """A force by the name of its option in [exchange]: the gas field it needs and how it acts."""

    field: str
    """Derived field of the gas, three components."""
    kernel: Kernel


FORCES: dict[str, Force] = {}


def force(name: str, field: str) -> Callable[[Kernel], Kernel]:
    """Register a kernel: slip u - v, `field` at the particles (n, 3), radii (n,), density, viscosity, force (n, 3)
    [N] to add to."""

    def register(kernel: Kernel) -> Kernel:
        FORCES[name] = Force(field, kernel)
        return kernel

    return register


@inlined
def _volume(radius):
    return 4.0 / 3.0 * np.pi * radius**3


@force("viscous_force", field="viscous")
@compiled
def push_by_stress(slip, stress, radii, density, viscosity, total):
    """V div(tau): the viscous stress of the gas on the volume of the particle (Maxey and Riley 1983; Zhou et al. 2010,
    set I). `stress` is div(tau)/rho [m/s2]."""
    for p in range(len(radii)):
        mass = density * _volume(radii[p])
        for axis in range(3):
            total[p, axis] += mass * stress[p, axis]


@force("lift_force", field="curl")
@compiled
def lift_by_shear(slip, curl, radii, density, viscosity, total):
    """Shear lift 1.615 d^2 sqrt(rho mu/|w|) f (u - v) x w, w = curl u (Saffman 1965, with f of Mei 1992).

    f = (1 - a) exp(-Re/10) + a with a = 0.3314 sqrt(b), and 0.0524 sqrt(b Re) above Re = 40; Re = rho |u - v| d/mu,
    b = rho |w| d^2/(2 mu Re). Fitted for 0.1 <= Re <= 100 and 0.005 <= b <= 0.4, for a lone sphere that does not spin.
    """
    for p in range(len(radii)):
        sx, sy, sz = slip[p, 0], slip[p, 1], slip[p, 2]
        wx, wy, wz = curl[p, 0], curl[p, 1], curl[p, 2]
        speed, shear = np.sqrt(sx * sx + sy * sy + sz * sz), np.sqrt(wx * wx + wy * wy + wz * wz)
        if speed == 0.0 or shear == 0.0:
            continue
        diameter = 2.0 * radii[p]
        reynolds = density * speed * diameter / viscosity
        b = 0.5 * shear * diameter / speed
        a = 0.3314 * np.sqrt(b)
        f = (1.0 - a) * np.exp(-0.1 * reynolds) + a if reynolds <= 40.0 else 0.0524 * np.sqrt(b * reynolds)
        size = 1.615 * diameter**2 * np.sqrt(density * viscosity / shear) * f
        total[p, 0] += size * (sy * wz - sz * wy)
        total[p, 1] += size * (sz * wx - sx * wz)
        total[p, 2] += size * (sx * wy - sy * wx)


@force("virtual_mass", field="convection")
@compiled
def carry_along(slip, convection, radii, density, viscosity, total):
    """m_a u.grad(u), the explicit part of m_a Du/Dt (Auton, Hunt and Prud'homme 1988)."""
    for p in range(len(radii)):
        mass = ADDED_MASS * density * _volume(radii[p])
        for axis in range(3):
            total[p, axis] += mass * convection[p, axis]


def choose_forces(case: Case) -> tuple[str, ...]:
    """Names of the forces that the case asks for."""
    return tuple(name for name in FORCES if case.exchange and getattr(case.exchange, name))


class Forces:
    """The forces of `names` on this rank's particles, and what the gas loses by them."""

    def __init__(self, case: Case, names: tuple[str, ...], space: Space) -> None:
        assert case.gas is not None and case.exchange is not None
        self._chosen = [FORCES[name] for name in names]
        self.fields = tuple(chosen.field for chosen in self._chosen)
        """Derived fields of the gas that `read` wants."""
        self._density, self._viscosity = case.gas.density, case.gas.viscosity
        self._ratio, self._grains = 1.0, 1.0
        if case.particles:
            self._ratio, self._grains = find_ratio(case.particles), grains_per_parcel(case.particles)
        self._added = ADDED_MASS * self._density if "virtual_mass" in names else 0.0
        self.weight = self._added * case.gravity
        """Weight of the gas that a particle carries along over its volume [N/m3]: the particle must not feel it."""
        self._halo, self._smooth = space.halo, space.average
        self._field, self._scratch = (space.make_field(3 * len(names)) for _ in range(2))
        self._ready = self._field
        self.moved = np.zeros(3)
        """Force [N] of the gas on this rank's particles in their last move, by their own acceleration."""

    def read(self, values: np.ndarray) -> None:
        """Bring `fields` (cells, 3 fields) of the gas to the particles' local grid, filtered (collective)."""
        self._halo.forward(values, self._field, "forces")
        self._ready = self._smooth(self._field, self._scratch)

    def deposit(
        self, particles: Particles, mapping: Way, gas: np.ndarray, steps: tuple[float, float], rows: np.ndarray
    ) -> None:
        """Add K and S of the forces to `rows` (places, 4), beside those of the drag.

        gas (places, >= 3): filtered gas velocity; steps [s]: the one that the particles have taken, and the next.
        """
        count = len(particles.positions)
        self._velocity, fields = np.empty((count, 3)), np.empty((count, 3 * len(self._chosen)))
        _gather(mapping.stencil, gas, self._velocity)
        _gather(mapping.stencil, mapping.read(self._ready, fields.shape[1]), fields)
        self._force = np.zeros((count, 3))
        slip, radii = self._velocity - particles.velocities, particles.radii
        if self._ratio != 1.0:  # the force on one grain of a parcel, and then on all of them
            radii = radii / self._ratio
        for number, chosen in enumerate(self._chosen):
            field = np.ascontiguousarray(fields[:, 3 * number : 3 * number + 3])
            chosen.kernel(slip, field, radii, self._density, self._viscosity, self._force)
        if self._ratio != 1.0:
            self._force *= self._grains
        last_dt, dt = steps
        added = self._added * 4.0 / 3.0 * np.pi * particles.radii**3
        self._inertia = added / dt
        source = self._inertia[:, None] * self._velocity - self._force
        if particles.last_velocities is not None:
            moved = -(added / last_dt)[:, None] * (particles.velocities - particles.last_velocities)
            source -= moved
            self.moved = moved.sum(axis=0)
        _scatter(mapping.stencil, np.column_stack([self._inertia, source]), rows)

    def hand_over(self, mapping: Way, gas: np.ndarray, coupling_force: np.ndarray, total_force: np.ndarray) -> float:
        """Add the forces, with the new gas velocity in `gas`, to `coupling_force` and `total_force` (n, 3) [N].

        Returns the sum of their magnitudes.
        """
        velocity = np.empty_like(self._velocity)
        _gather(mapping.stencil, gas, velocity)
        force = self._inertia[:, None] * (velocity - self._velocity) + self._force
        coupling_force += force
        total_force += force
        return float(np.linalg.norm(force, axis=1).sum())


@compiled
def _gather(stencil: Stencil, field, rows):
    """Set `rows` (n, c) to the first columns of `field` (places, >= c) at the particles."""
    base, upper, offsets = stencil.base, stencil.upper, stencil.offsets
    for p in range(len(base)):
        weights = corner_weights(upper[p, 0], upper[p, 1], upper[p, 2])
        rows[p, :] = 0.0
        for c in range(8):
            for q in range(rows.shape[1]):
                rows[p, q] += weights[c] * field[base[p] + offsets[c], q]


@compiled
def _scatter(stencil: Stencil, rows, field):
    """Add `rows` (n, c) of the particles to `field` (places, c)."""
    base, upper, offsets = stencil.base, stencil.upper, stencil.offsets
    for p in range(len(base)):
        weights = corner_weights(upper[p, 0], upper[p, 1], upper[p, 2])
        for c in range(8):
            for q in range(rows.shape[1]):
                field[base[p] + offsets[c], q] += weights[c] * rows[p, q]
