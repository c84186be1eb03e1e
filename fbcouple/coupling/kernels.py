"""The forces between gas and particles, so that what one gains the other loses, to rounding.

Every kernel walks the particles once. Writing to the cells and reading from them use the same weights and the same
symmetric filter: sum over particles of beta~ (u at p - v) equals sum over cells of V (K u - S).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fbcouple.coupling.box.corners import Stencil, add_four, corner_weights, read_four
from fbcouple.coupling.negative import NONE, find_lowest
from fbcouple.physics.drag.polydisperse import size_factor
from fbcouple.physics.elementary import decay
from fbcouple.physics.jit import SCHEME, call_law, call_scheme, compile_as, compiled, inlined

_BLOCK = 256
LONE = 1e-9
"""Solids fraction below which a particle is alone, and the mean diameter is its own."""
BLENDING = 0.5
"""Weight of the last step in what `predict` knows of the other forces. The pressure gradient answers to what the gas
gets: the change of one step comes back as -alpha/eps (1 - y/x) of it, which would grow where alpha > eps; so it grows
above alpha/eps = 3 only, which no bed reaches."""


class Drag(NamedTuple):
    """How the drag of a case is found: addresses of a law and of a scheme (`physics.jit`), and the gas."""

    law: int
    scheme: int
    is_explicit: bool
    is_polydisperse: bool
    """By the mean diameter of a cell and a factor of the particle's own."""
    is_expanded: bool
    """Of an ideal gas, whose density goes with its temperature."""
    density: float
    """Of the gas [kg/m3]."""
    viscosity: float
    """Dynamic, of the gas [Pa s]."""
    ratio: float = 1.0
    """Diameter of a parcel over that of its grains, whose drag it has; 1 where particles are no parcels."""
    grains: float = 1.0
    """Grains of a parcel."""


class Bed(NamedTuple):
    """This rank's particles."""

    velocities: np.ndarray
    """(n, 3) [m/s]."""
    radii: np.ndarray
    """(n,) [m]."""
    masses: np.ndarray
    """(n,) [kg]."""


class Prediction(NamedTuple):
    """What the drag of a step knows of other forces."""

    drag_only: np.ndarray
    """(n, 3) [m/s]: the velocity that drag alone would have made in the last step; (0, 3) where nobody asks."""
    ratio: float
    """The step to come over the last."""
    effective: np.ndarray
    """(n, 3) [m/s]: the velocity that the drag acts on; that of the particles where nobody asks."""


class GasForce(NamedTuple):
    """The force of the gas on the particles, in place."""

    gradient_factor: float
    """1 with the pressure-gradient force, 0 without."""
    buoyancy: float
    """Weight of the displaced gas [N/m3]."""
    coupling: np.ndarray
    """(n, 3) [N]: what the DEM steps hold."""
    gravity: float
    """Downwards [m/s2]: the weight that `coupling` holds beside the force of the gas."""
    total: np.ndarray
    """(n, 3) [N]: the force of the last DEM step, which the next half kick starts from."""


@inlined
def _share(stencil, p, amount, field):
    """Add what particle `p` has to its corners of local `field` (places, 1)."""
    weights = corner_weights(stencil.upper[p, 0], stencil.upper[p, 1], stencil.upper[p, 2])
    for c in range(8):
        field[stencil.base[p] + stencil.offsets[c], 0] += weights[c] * amount


@compiled
def write_volume(stencil: Stencil, radii, field):
    """Add the particles' volumes [m3] to local `field` (places, 1)."""
    for p in range(len(stencil.base)):
        _share(stencil, p, 4.0 / 3.0 * np.pi * radii[p] ** 3, field)


@compiled
def write_area(stencil: Stencil, radii, field):
    """Add volume over diameter [m2] of the particles to local `field` (places, 1)."""
    for p in range(len(stencil.base)):
        _share(stencil, p, 2.0 / 3.0 * np.pi * radii[p] ** 2, field)


DRAG_SCHEMES: dict[str, Callable[..., None]] = {}


def drag_scheme(name: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Register how beta of the step's start becomes the beta~ of the whole step."""

    def register(function: Callable[..., None]) -> Callable[..., None]:
        DRAG_SCHEMES[name] = compile_as(SCHEME)(function)
        return DRAG_SCHEMES[name]

    return register


@drag_scheme("exponential")
def average_exactly(beta, masses, dt):
    """beta~ = m (1 - exp(-dt beta/m))/dt: the drag impulse of a constant gas over dt, stable for any dt beta/m."""
    for p in range(len(beta)):
        beta[p] = masses[p] / dt * decay(dt * beta[p] / masses[p])


@drag_scheme("semi-implicit")
def average_implicitly(beta, masses, dt):
    """beta~ = beta/(1 + dt beta/m): backward Euler over dt."""
    for p in range(len(beta)):
        beta[p] /= 1.0 + dt * beta[p] / masses[p]


@drag_scheme("explicit")
def keep_beta(beta, masses, dt):
    """beta~ = beta: the value at the start of the step, for gas and particles alike (the paper's form)."""


@inlined
def predict(velocities, drag_only, ratio, dt_over_tau, effective):
    """Set `effective` (n, 3) to v + c d, so that beta~ (u - effective) is the mean drag over a step on a particle that
    other forces give the velocity d in it: BLENDING times what v is beyond `drag_only` (n, 3), which drag alone would
    have made of it, times `ratio`, the step to come over the one in which they gave it.

    m dv/dt = beta (u - v) + m d/dt with x = dt beta/m, `dt_over_tau` (n,), has the mean drag beta~ (u - v) - (m/dt) d
    (1 - y/x), where y = 1 - exp(-x) = dt beta~/m: c = 1/y - 1/x, 1/2 for slow drag and 1 for fast.
    """
    for p in range(len(dt_over_tau)):
        x = dt_over_tau[p]
        c = 0.5 + x * (1.0 / 12.0 - x * x * (1.0 / 720.0 - x * x / 30240.0))
        if abs(x) > 0.1:
            c = 1.0 / decay(x) - 1.0 / x
        for axis in range(3):
            effective[p, axis] = velocities[p, axis] + c * BLENDING * ratio * (velocities[p, axis] - drag_only[p, axis])
    return effective


@inlined
def find_beta(drag, eps, slip, size, beta):
    """Set `beta` (n,) [kg/s] to what the law says of particles of diameters `size` (n,) [m]; of parcels the law goes by
    the diameter of their grains, which `size` becomes, and beta is that of all of them."""
    if drag.ratio != 1.0:
        for q in range(len(size)):
            size[q] /= drag.ratio
    call_law(drag.law, eps, slip, size, drag.density, drag.viscosity, beta)
    if drag.ratio != 1.0:
        for q in range(len(size)):
            beta[q] *= drag.grains


@compiled
def deposit_drag(drag: Drag, stencil: Stencil, bed: Bed, gas, dt, beta, prediction: Prediction, field):
    """Add beta~ [kg/s] and beta~ w [N] of every particle to local `field` (places, 4); beta~ stays in `beta` (n,).

    w is the velocity that the drag acts on: v, or, where `prediction.drag_only` is given, what makes beta~ exact for
    other forces too (see `predict`), which goes into `prediction.effective`. `gas` (places, >= 4) starts with the
    filtered gas velocity and the voidage as the cells have it; in its column 7 polydisperse drag finds the solids
    fraction over the mean diameter [1/m], and that of an ideal gas its density over the one of the case, r: beta at the
    slip w is that of the density of the case at r w, by dimensions. `dt` [s] is the step to come. The explicit scheme
    has no implicit part: it adds 0 and beta (v - u).
    Particles go through in blocks that fit the cache. Returns the lowest beta [kg/s] below 0, its particle, -1 if there
    is none, and the voidage, slip [m/s] and diameter [m] that the law was given.
    """
    base, upper, offsets = stencil.base, stencil.upper, stencil.offsets
    eps, slip, size = np.empty(_BLOCK), np.empty(_BLOCK), np.empty(_BLOCK)
    ux, uy, uz, ratio = np.empty(_BLOCK), np.empty(_BLOCK), np.empty(_BLOCK), np.empty(_BLOCK)
    left = 1.0 if drag.is_explicit else 0.0
    lowest = NONE
    for first in range(0, len(base), _BLOCK):
        n = min(_BLOCK, len(base) - first)
        at, up, v = base[first : first + n], upper[first : first + n], bed.velocities[first : first + n]
        for q in range(n):
            weights = corner_weights(up[q, 0], up[q, 1], up[q, 2])
            ux[q], uy[q], uz[q], eps[q] = read_four(gas, np.uint64(0), at[q], offsets, weights)
        for q in range(n):
            rx, ry, rz = ux[q] - v[q, 0], uy[q] - v[q, 1], uz[q] - v[q, 2]
            slip[q] = np.sqrt(rx * rx + ry * ry + rz * rz)
            size[q] = 2.0 * bed.radii[first + q]
        b, masses = beta[first : first + n], bed.masses[first : first + n]
        if drag.is_polydisperse:
            for q in range(n):
                weights = corner_weights(up[q, 0], up[q, 1], up[q, 2])
                _, _, _, area = read_four(gas, np.uint64(4), at[q], offsets, weights)
                phi = 1.0 - eps[q]
                ratio[q] = size[q] * area / phi if phi > LONE else 1.0
                size[q] /= ratio[q]
        if drag.is_expanded:
            for q in range(n):
                weights = corner_weights(up[q, 0], up[q, 1], up[q, 2])
                _, _, _, density = read_four(gas, np.uint64(4), at[q], offsets, weights)
                slip[q] *= density
        find_beta(drag, eps[:n], slip[:n], size[:n], b)
        lowest = find_lowest(first, eps[:n], slip[:n], size[:n], b, lowest)
        if drag.is_polydisperse:
            for q in range(n):
                b[q] *= ratio[q] * size_factor(eps[q], ratio[q])
        if len(prediction.drag_only):
            for q in range(n):
                size[q] = dt * b[q] / masses[q]
            drag_only, effective = prediction.drag_only[first : first + n], prediction.effective[first : first + n]
            v = predict(v, drag_only, prediction.ratio, size[:n], effective)
        call_scheme(drag.scheme, b, masses, dt)
        for q in range(n):
            weights = corner_weights(up[q, 0], up[q, 1], up[q, 2])
            values = (
                b[q] * (1.0 - left),
                b[q] * (v[q, 0] - left * ux[q]),
                b[q] * (v[q, 1] - left * uy[q]),
                b[q] * (v[q, 2] - left * uz[q]),
            )
            add_four(field, np.uint64(0), at[q], offsets, weights, values)
    return lowest


@compiled
def apply_gas_force(stencil: Stencil, bed: Bed, gas, beta, force: GasForce, dt, prediction: Prediction):
    """Put each particle under the force of the gas [N]: beta~ (u - w) - V (gradient_factor grad P) + V buoyancy.

    The weight m `gravity` goes with it.

    `prediction.effective` is w [m/s]. `gas` (places, 8) holds filtered gas velocity, voidage, pressure gradient and a
    number that is not asked for. The force goes into `force.coupling`, and its change into `force.total`. Returns the
    summed drag magnitude [N]. `prediction.drag_only`, where it is given, becomes what drag alone makes of the
    velocities in the step of `dt` [s] that comes, less the part of the last one's other forces that `predict` is to
    keep.
    """
    upper, offsets, drag_only, effective = stencil.upper, stencil.offsets, prediction.drag_only, prediction.effective
    velocities, coupling, total_force = bed.velocities, force.coupling, force.total
    total = 0.0
    for p in range(len(stencil.base)):
        weights = corner_weights(upper[p, 0], upper[p, 1], upper[p, 2])
        ux, uy, uz, _ = read_four(gas, np.uint64(0), stencil.base[p], offsets, weights)
        gx, gy, gz, _ = read_four(gas, np.uint64(4), stencil.base[p], offsets, weights)
        volume = 4.0 / 3.0 * np.pi * bed.radii[p] ** 3
        dx = beta[p] * (ux - effective[p, 0])
        dy = beta[p] * (uy - effective[p, 1])
        dz = beta[p] * (uz - effective[p, 2])
        fx = dx - volume * force.gradient_factor * gx
        fy = dy - volume * force.gradient_factor * gy
        fz = dz - volume * force.gradient_factor * gz + volume * force.buoyancy - bed.masses[p] * force.gravity
        total_force[p, 0] += fx - coupling[p, 0]
        total_force[p, 1] += fy - coupling[p, 1]
        total_force[p, 2] += fz - coupling[p, 2]
        coupling[p, 0] = fx
        coupling[p, 1] = fy
        coupling[p, 2] = fz
        total += np.sqrt(dx * dx + dy * dy + dz * dz)
        if len(drag_only):
            share, kept = dt / bed.masses[p], (1.0 - BLENDING) * prediction.ratio
            drag_only[p, 0] = velocities[p, 0] + share * dx - kept * (velocities[p, 0] - drag_only[p, 0])
            drag_only[p, 1] = velocities[p, 1] + share * dy - kept * (velocities[p, 1] - drag_only[p, 1])
            drag_only[p, 2] = velocities[p, 2] + share * dz - kept * (velocities[p, 2] - drag_only[p, 2])
    return total


@compiled
def pack_gas(state, rows):
    """Put velocity and pressure gradient of `state` (places, 6) to the columns 0-2 and 4-6 of `rows` (places, 8)."""
    for p in range(len(state)):
        for axis in range(3):
            rows[p, axis] = state[p, axis]
            rows[p, axis + 4] = state[p, axis + 3]


@compiled
def scan_min_max(voidage, drag):
    """Lowest and highest `voidage` (cells,), and a sum over it and `drag` (cells, 4), which is finite if they are."""
    least, most, total = 1.0, 0.0, 0.0
    for n in range(len(voidage)):
        least, most = min(least, voidage[n]), max(most, voidage[n])
        total += voidage[n] + drag[n, 0] + drag[n, 1] + drag[n, 2] + drag[n, 3]
    return least, most, total


@compiled
def sum_up(forces):
    """The sums of `forces` (n, 3) along x, y and z."""
    x, y, z = 0.0, 0.0, 0.0
    for n in range(len(forces)):
        x += forces[n, 0]
        y += forces[n, 1]
        z += forces[n, 2]
    return x, y, z
