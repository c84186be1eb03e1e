"""Velocities at which the drag of a case carries the weight of its particles, in a bed and alone."""

from __future__ import annotations

import numpy as np

from fbcouple.case.bed.derived import has_ramp
from fbcouple.case.bed.number import Law
from fbcouple.case.bed.particle_types import Kind, list_kinds, mean_density, mean_kind, particle_count
from fbcouple.case.schema.sections import Case

EXPANDED = 0.40
"""Voidage of the interstitial velocity and of minimum fluidization."""


PACKED = (0.30, 0.60)
"""Voidages of packed beds, from the densest mixtures to loose ones."""


def minimum_fluidization(case: Case, voidage: float = EXPANDED, law: Law | None = None) -> float:
    """Superficial velocity [m/s] at which the case's drag carries the weight of a bed of `voidage`.

    n beta u/eps = (1 - eps)(rho_p - rho) g with u = U/eps and (1 - eps)/V_p particles per volume (model A).
    """
    assert case.particles is not None
    return voidage * find_balance(case, voidage, law, mean_kind(case.particles))


def tabulate_onset(case: Case, law: Law | None = None) -> np.ndarray:
    """Rows (n, 2) of the voidage of a packed bed and `minimum_fluidization` there, to be held against what a ramp
    shows; none in a case without a ramp, or without a bed that gas can lift."""
    bed, gas = case.particles, case.gas
    if bed is None or gas is None or case.exchange is None or not has_ramp(gas) or not particle_count(bed):
        return np.empty((0, 2))
    if case.gravity == 0.0 or mean_density(bed) <= gas.density:
        return np.empty((0, 2))
    voidages = np.linspace(*PACKED, 31)
    return np.array([(voidage, minimum_fluidization(case, voidage, law)) for voidage in voidages.tolist()])


def terminal_velocity(case: Case, law: Law | None = None) -> float:
    """Speed [m/s] at which the case's drag carries the weight of a lone particle, the slowest of a mixture."""
    assert case.particles is not None
    return min(find_balance(case, 1.0, law, kind) for kind in list_kinds(case.particles))


def find_balance(case: Case, voidage: float, law: Law | None, kind: Kind) -> float:
    """Slip [m/s] at which beta(u) u = eps V_p |rho_p - rho| g, by bisection."""
    assert case.gas is not None
    weight = voidage * kind.volume * abs(kind.density - case.gas.density) * case.gravity
    low, high = 0.0, 1e-9
    while find_drag(case, voidage, high, law, kind) * high < weight:
        high *= 2.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if find_drag(case, voidage, middle, law, kind) * middle < weight else (low, middle)
    return high


def find_drag(case: Case, voidage: float, slip: float, law: Law | None, kind: Kind) -> float:
    """Drag coefficient beta [kg/s] of one particle among its like by `law`, or by the case's law of the registry; of a
    parcel that of all its grains."""
    from fbcouple.case.user_laws import DRAG_LAWS  # noqa: PLC0415  (loads numba)
    from fbcouple.physics.drag.polydisperse import size_factor  # noqa: PLC0415  (loads numba)

    assert case.gas is not None and case.exchange is not None
    law = law or DRAG_LAWS[case.exchange.drag]
    beta = kind.grains * float(law(voidage, slip, kind.grain_diameter, case.gas.density, case.gas.viscosity))
    return beta * size_factor.py_func(voidage, 1.0) if case.exchange.polydisperse != "none" else beta
