"""The step of the gas as a case has it before it runs."""

from __future__ import annotations

import math

from fbcouple.case.bed.derived import cell_size, dem_step, fastest_inlet
from fbcouple.case.bed.drag_balance import EXPANDED
from fbcouple.case.bed.gas_heat import speed_up_gas
from fbcouple.case.bed.step_limits import Limits, measure_limits
from fbcouple.case.bed.streams import has_side_openings
from fbcouple.case.schema.sections import Case


def gas_step(case: Case, share: float = 1.0, limits: Limits | None = None, longer: float = 1.0) -> float:
    """Fluid step [s] that the Courant limit at U_f/0.40, the Fourier limit and `gas.max_step` allow.

    share: speed of the inlet over the fastest that it has in the whole run; limits: those by the mesh, absent: as they
    are known without the files of the case; longer: step by the Courant number that the run takes over that at
    U_f/0.40. The other two limits know of no speed.
    """
    assert case.gas is not None
    limits = limits or measure_limits(case, None)
    speed, edge = _find_fast_gas(case, limits.jet), float(cell_size(case)[2])
    if case.gas.inlets and speed == limits.jet and has_side_openings(case):
        edge = float(cell_size(case).min())
    edge = edge if limits.thinnest is None else limits.thinnest
    courant = longer * case.gas.max_courant * edge / (speed * share) if speed * share > 0.0 else math.inf
    return min(fourier_step(case, limits), courant, case.gas.max_step or math.inf)


def fourier_step(case: Case, limits: Limits | None = None) -> float:
    """Fluid step [s] that the Fourier limit allows; limits: as `gas_step` has them."""
    assert case.gas is not None
    limits = limits or measure_limits(case, None)
    return case.gas.max_fourier * case.gas.density / case.gas.viscosity / limits.rate


def _find_fast_gas(case: Case, jet: float) -> float:
    """Speed [m/s] of the gas in a bed at U_f/0.40, an ideal one as warm as the bed makes it, or of the fastest `jet`
    [m/s], which keeps its velocity."""
    gas = speed_up_gas(case).gas
    assert case.gas is not None and gas is not None
    speed = fastest_inlet(gas) / (EXPANDED if case.particles else 1.0)
    return max(speed, jet) if case.gas.inlets else speed


def coupling_step(case: Case, limits: Limits | None = None) -> float:
    """Step [s] of a case of both phases: the fluid step as `gas_step` has it, and no less than the one DEM step that it
    has to hold."""
    assert case.particles is not None and case.contact is not None
    return max(gas_step(case, limits=limits), dem_step(case.contact, case.particles))
