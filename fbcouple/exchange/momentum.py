"""The forces between gas and particles, so that what one gains the other loses, to rounding.

Every kernel walks the particles once. Writing to the cells and reading from them use the same weights and the same
symmetric filter: sum over particles of beta~ (u at p - v) equals sum over cells of V (K u - S).
"""

from __future__ import annotations

import numpy as np

from fbcouple.exchange.compiled import compiled
from fbcouple.exchange.weights import corner_weight


@compiled
def write_volume(base, upper, offsets, radii, field):
    """Add the particles' volumes [m3] to patch `field` (places, 1)."""
    for p in range(len(base)):
        volume = 4.0 / 3.0 * np.pi * radii[p] ** 3
        w = upper[p]
        for c in range(8):
            field[base[p] + offsets[c], 0] += corner_weight(c, w) * volume


@compiled
def read_slip(base, upper, offsets, velocities, gas, voidage_field, voidage, slip, gas_velocity):
    """Voidage (n,), gas velocity (n, 3) and slip speed |u - v| (n,) at the particles.

    `gas` (places, >= 3) starts with the filtered gas velocity, `voidage_field` (places, 1) is as the cells have it.
    """
    for p in range(len(base)):
        eps = 0.0
        ux = 0.0
        uy = 0.0
        uz = 0.0
        w = upper[p]
        for c in range(8):
            weight = corner_weight(c, w)
            place = base[p] + offsets[c]
            eps += weight * voidage_field[place, 0]
            ux += weight * gas[place, 0]
            uy += weight * gas[place, 1]
            uz += weight * gas[place, 2]
        voidage[p] = eps
        gas_velocity[p, 0] = ux
        gas_velocity[p, 1] = uy
        gas_velocity[p, 2] = uz
        rx = ux - velocities[p, 0]
        ry = uy - velocities[p, 1]
        rz = uz - velocities[p, 2]
        slip[p] = np.sqrt(rx * rx + ry * ry + rz * rz)


@compiled
def average_exactly(beta, masses, dt):
    """beta -> m (1 - exp(-dt beta/m))/dt: the drag impulse of a constant gas over dt, stable for any dt beta/m."""
    for p in range(len(beta)):
        beta[p] = -masses[p] / dt * np.expm1(-dt * beta[p] / masses[p])


@compiled
def average_implicitly(beta, masses, dt):
    """beta -> beta/(1 + dt beta/m): backward Euler over dt."""
    for p in range(len(beta)):
        beta[p] /= 1.0 + dt * beta[p] / masses[p]


@compiled
def write_drag(base, upper, offsets, beta, velocities, field):
    """Add beta [kg/s] and beta v [N] to patch `field` (places, 4)."""
    for p in range(len(base)):
        b = beta[p]
        bx = b * velocities[p, 0]
        by = b * velocities[p, 1]
        bz = b * velocities[p, 2]
        w = upper[p]
        for c in range(8):
            weight = corner_weight(c, w)
            place = base[p] + offsets[c]
            field[place, 0] += weight * b
            field[place, 1] += weight * bx
            field[place, 2] += weight * by
            field[place, 3] += weight * bz


@compiled
def write_drag_explicitly(base, upper, offsets, beta, velocities, gas_velocity, field):
    """Add -beta (u - v) [N] of the step's start to patch `field` (places, 4), nothing implicit (the paper's form)."""
    for p in range(len(base)):
        b = beta[p]
        fx = b * (velocities[p, 0] - gas_velocity[p, 0])
        fy = b * (velocities[p, 1] - gas_velocity[p, 1])
        fz = b * (velocities[p, 2] - gas_velocity[p, 2])
        w = upper[p]
        for c in range(8):
            weight = corner_weight(c, w)
            place = base[p] + offsets[c]
            field[place, 1] += weight * fx
            field[place, 2] += weight * fy
            field[place, 3] += weight * fz


@compiled
def react(base, upper, offsets, field, beta, velocities, wind, explicit, radii, push, lift, factor, held, current):
    """Put each particle under `factor` times the force of the gas [N]: beta~ (u - v) - V (push grad P) + V lift.

    `field` (places, 6) holds filtered gas velocity and pressure gradient; `push` is 1 with the pressure-gradient force
    and 0 without; `lift` [N/m3] is the weight of the displaced gas. The force goes into `held` (n, 3), what the
    sub-steps hold, and its change into `current` (n, 3), the force of the last sub-step, which the next half kick
    starts from. Returns the summed drag magnitude [N] without the factor.
    """
    total = 0.0
    for p in range(len(base)):
        ux = 0.0
        uy = 0.0
        uz = 0.0
        gx = 0.0
        gy = 0.0
        gz = 0.0
        w = upper[p]
        for c in range(8):
            weight = corner_weight(c, w)
            place = base[p] + offsets[c]
            ux += weight * field[place, 0]
            uy += weight * field[place, 1]
            uz += weight * field[place, 2]
            gx += weight * field[place, 3]
            gy += weight * field[place, 4]
            gz += weight * field[place, 5]
        if explicit:
            ux = wind[p, 0]
            uy = wind[p, 1]
            uz = wind[p, 2]
        volume = 4.0 / 3.0 * np.pi * radii[p] ** 3
        dx = beta[p] * (ux - velocities[p, 0])
        dy = beta[p] * (uy - velocities[p, 1])
        dz = beta[p] * (uz - velocities[p, 2])
        fx = factor * (dx - volume * push * gx)
        fy = factor * (dy - volume * push * gy)
        fz = factor * (dz - volume * push * gz + volume * lift)
        current[p, 0] += fx - held[p, 0]
        current[p, 1] += fy - held[p, 1]
        current[p, 2] += fz - held[p, 2]
        held[p, 0] = fx
        held[p, 1] = fy
        held[p, 2] = fz
        total += np.sqrt(dx * dx + dy * dy + dz * dz)
    return total


@compiled
def find_loss(velocity, pressure_gradient, voidage, coefficient, source, push, lift, loss):
    """Add to `loss` (3,) [N m-3] what the gas of each cell gave up: K u - S - push alpha grad P + alpha lift."""
    for n in range(len(voidage)):
        solids = 1.0 - voidage[n]
        for axis in range(3):
            loss[axis] += (
                coefficient[n] * velocity[n, axis] - source[n, axis] - push * solids * pressure_gradient[n, axis]
            )
        loss[2] += solids * lift


@compiled
def add_rows(rows, total):
    """Add the rows (n, 3) to `total` (3,)."""
    for n in range(len(rows)):
        for axis in range(3):
            total[axis] += rows[n, axis]
