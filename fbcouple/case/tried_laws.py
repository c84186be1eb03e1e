"""Whether the own laws of a case are laws for what its particles can have: their diameters, gas and fastest slips."""

from __future__ import annotations

from typing import Any

import numpy as np

from fbcouple.case.bed.gas_heat import find_prandtl
from fbcouple.case.bed.particle_types import Kind
from fbcouple.case.bed.slips import find_reynolds, list_slips
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import DRAG_FILE, LAW_FILES, NUSSELT_FILE
from fbcouple.errors import CaseError
from fbcouple.physics.drag.registry import DragLaw
from fbcouple.physics.heat.nusselt import NusseltLaw

_VOIDAGES = np.linspace(0.36, 1.0, 9)
_PARTS = np.array([0.0, 1e-3, 1e-2, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0])[:, None]
"""Parts of the fastest slip of a case at which its own laws are tried."""


def require_sound_laws(case: Case, drag: DragLaw | None, nusselt: NusseltLaw | None) -> None:
    """Raise CaseError if an own law of `case` is negative or not finite for its diameters and gas, at slips that it can
    have; None: it has none of this kind."""
    gas = case.gas
    if gas is None or case.particles is None:
        return
    for slips in list_slips(case, drag):
        by_gas, by_fall = _PARTS * slips.by_gas / _VOIDAGES, _PARTS * slips.by_fall
        for voidage, slip in ((_VOIDAGES, by_gas), (1.0, by_fall)):
            size = slips.kind.grain_diameter
            if drag is not None:
                beta = drag(voidage, slip, size, gas.density, gas.viscosity)
                _require_sound(case, slips.kind, DRAG_FILE, "kg/s", beta, (voidage, slip))
            if nusselt is not None:
                assert case.heat is not None
                reynolds = find_reynolds(case, slips.kind, 1.0) * voidage * slip
                number = nusselt(voidage, reynolds, find_prandtl(case.heat, gas))
                _require_sound(case, slips.kind, NUSSELT_FILE, "", number, (voidage, slip))


def _require_sound(case: Case, kind: Kind, option: str, unit: str, found: np.ndarray, tried: tuple[Any, Any]) -> None:
    bad = ~(np.isfinite(found) & (found >= 0.0))
    if not bad.any():
        return
    voidage, slip = (float(np.broadcast_to(values, found.shape)[bad][0]) for values in tried)
    reynolds, function = find_reynolds(case, kind, voidage * slip), LAW_FILES[option][0]
    value = f"{found[bad][0]:.4g} {unit}".strip()
    where = f"voidage {voidage:.3g}, slip {slip:.4g} m/s, Re {reynolds:.4g} of {kind.diameter:.4g} m"
    text = f"{function} is {value} at {where}, which this case can have; at least 0 is allowed"
    raise CaseError([f"{option}: {text}: fix the file."])
