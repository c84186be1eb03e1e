"""What fluxes and velocities are put in proportion to in figures and tables, and how that is written."""

from __future__ import annotations

from collections.abc import Sequence

from fbcouple.results.inlet_speed import is_constant
from fbcouple.results.reader import Results


def flux_scale(results: Results) -> tuple[float, str, str]:
    """What solids fluxes are divided by [kg m-2 s-1], with the text to append to their symbol and their unit.

    rho U_f as in Hamidouche et al. 2019, section 4; one, and SI units, where no gas flows in. Never below zero: the
    sign of a flux is its direction.
    """
    scale = results.gas_flux
    return (1.0, "", "kg m$^{-2}$ s$^{-1}$") if scale is None else (scale, r" / (\rho\, U_f)", "–")


def velocity_scale(results: Results) -> tuple[float, str, str]:
    """What velocities are divided by [m s-1], with the text to append to their symbol and their unit.

    U_f as in Hamidouche et al. 2019, section 4; one, and SI units, where no gas flows in.
    """
    speed = results.inlet_speed
    return (1.0, "", "m s$^{-1}$") if speed is None else (speed, " / U_f", "–")


def format_scale(runs: Sequence[Results]) -> str:
    """What U_f is in a note, if the inflow of some run changes with time: "; U_f: ..." or nothing."""
    ramps = [run for run in runs if run.inlet_speed is not None and not is_constant(run.case["gas"])]
    if not ramps:
        return ""
    value = f" = {ramps[0].inlet_speed:.3g} m/s" if len(runs) == 1 else ""
    return f"; $U_f${value}: fastest inflow then"
