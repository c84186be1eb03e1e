"""Velocities at which the drag of a case carries the weight of its particles, in a bed and alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache

import numpy as np

from fbcouple.case.bed.derived import has_ramp
from fbcouple.case.bed.number import Law
from fbcouple.case.bed.particle_types import Kind, list_kinds, mean_density, mean_kind, particle_count
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

EXPANDED = 0.40
"""Voidage of the interstitial velocity and of minimum fluidization."""


PACKED = (0.30, 0.60)
"""Voidages of packed beds, from the densest mixtures to loose ones."""
_SLOWEST = 1e-9
"""Slip [m/s] that a search for a balance begins at."""
_FAR = 1e7
"""Reynolds number from which on a search goes on only as long as the drag grows."""
_THIRDS = 80
_HALVINGS = 100


def minimum_fluidization(case: Case, voidage: float = EXPANDED, law: Law | None = None) -> float:
    """Superficial velocity [m/s] at which the case's drag carries the weight of a bed of `voidage`.

    n beta u/eps = (1 - eps)(rho_p - rho) g with u = U/eps and (1 - eps)/V_p particles per volume (model A).

    Raises: CaseError, as `find_balance`.
    """
    assert case.particles is not None
    return voidage * find_balance(case, voidage, law, mean_kind(case.particles))


def tabulate_onset(case: Case, law: Law | None = None) -> np.ndarray:
    """Rows (n, 2) of the voidage of a packed bed and `minimum_fluidization` there, to be held against what a ramp
    shows; none in a case without a ramp, or without a bed that gas can lift, nor at a voidage at which the drag law
    never carries the bed."""
    bed, gas = case.particles, case.gas
    if bed is None or gas is None or case.exchange is None or not has_ramp(gas) or not particle_count(bed):
        return np.empty((0, 2))
    if case.gravity == 0.0 or mean_density(bed) <= gas.density:
        return np.empty((0, 2))
    rows = []
    for voidage in np.linspace(*PACKED, 31).tolist():
        with suppress(CaseError):
            rows.append((voidage, minimum_fluidization(case, voidage, law)))
    return np.array(rows).reshape(-1, 2)


def terminal_velocity(case: Case, law: Law | None = None) -> float:
    """Speed [m/s] at which the case's drag carries the weight of a lone particle, the slowest of a mixture.

    Raises: CaseError, as `find_balance`.
    """
    assert case.particles is not None
    return min(find_balance(case, 1.0, law, kind) for kind in list_kinds(case.particles))


def find_balance(case: Case, voidage: float, law: Law | None, kind: Kind) -> float:
    """Slip [m/s] at which beta(u) u = eps V_p |rho_p - rho| g, by bisection.

    Raises: CaseError if the drag is smaller than that at any slip.
    """
    gas = case.gas
    assert gas is not None and case.exchange is not None
    weight = voidage * kind.volume * abs(kind.density - gas.density) * case.gravity
    factor = _count_times(case, voidage, kind)
    slip, most = _search(
        law or _name_law(case), voidage, kind.grain_diameter, gas.density, gas.viscosity, factor, weight
    )
    if most >= weight:
        return slip
    reynolds = voidage * gas.density * kind.grain_diameter / gas.viscosity * slip
    text = (
        f"`{case.exchange.drag}` never carries a particle of {kind.diameter:.4g} m and {kind.density:.4g} kg/m3: "
        f"at voidage {voidage:.3g} its drag is {most:.4g} N at most, at a slip of {slip:.4g} m/s (Re "
        f"{reynolds:.3g}), at least {weight:.4g} N is needed"
    )
    raise CaseError([f"exchange.drag: {text}; take another law, or smaller or lighter particles."])


@lru_cache(maxsize=1024)
def _search(
    law: Law, voidage: float, diameter: float, density: float, viscosity: float, factor: float, weight: float
) -> tuple[float, float]:
    """The slip [m/s] of a balance with `weight` [N], and the drag there; if there is none, of the largest drag.

    Kept for those who ask again: each number of a bed does, and each of the many cases of a plan.
    """

    def pull(slip: float) -> float:
        return factor * float(law(voidage, slip, diameter, density, viscosity)) * slip

    high = _find_enough(pull, weight, _FAR * viscosity / (voidage * density * diameter))
    low, most = 0.0, pull(high)
    if not most >= weight:
        return high, most
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        low, high = (middle, high) if pull(middle) < weight else (low, middle)
    return high, weight


def _find_enough(pull: Callable[[float], float], weight: float, far: float) -> float:
    """A slip [m/s] at which `pull` is at least `weight` [N], by doubling; if there is none, that of the largest pull.

    Beyond the slip `far` [m/s] the search ends where the pull no longer grows, and at any where it is not finite.
    """
    slip, best, most = _SLOWEST, 0.0, -math.inf
    while math.isfinite(slip):
        found = pull(slip)
        if found >= weight:
            return slip
        if not math.isfinite(found) or (slip > far and found <= most):
            break
        if found > most:
            best, most = slip, found
        slip *= 2.0
    low, high = 0.5 * best, 2.0 * best
    for _ in range(_THIRDS):
        third = (high - low) / 3.0
        low, high = (low + third, high) if pull(low + third) < pull(high - third) else (low, high - third)
    return low


def find_drag(case: Case, voidage: float, slip: float, law: Law | None, kind: Kind) -> float:
    """Drag coefficient beta [kg/s] of one particle among its like by `law`, or by the case's law of the registry; of a
    parcel that of all its grains."""
    assert case.gas is not None
    law = law or _name_law(case)
    beta = float(law(voidage, slip, kind.grain_diameter, case.gas.density, case.gas.viscosity))
    return _count_times(case, voidage, kind) * beta


def _name_law(case: Case) -> Law:
    from fbcouple.case.user_laws import DRAG_LAWS  # noqa: PLC0415  (loads numba)

    assert case.exchange is not None
    return DRAG_LAWS[case.exchange.drag]


def _count_times(case: Case, voidage: float, kind: Kind) -> float:
    """How often a particle of `kind` has the drag of its law: once for each grain, times what other sizes do."""
    from fbcouple.physics.drag.polydisperse import size_factor  # noqa: PLC0415  (loads numba)

    assert case.exchange is not None
    return kind.grains * (size_factor.py_func(voidage, 1.0) if case.exchange.polydisperse != "none" else 1.0)
