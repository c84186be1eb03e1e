"""Whether the drag of a step knows the other forces on a particle: only where the drag is fast enough to need it."""

from __future__ import annotations

from fbcouple.case.bed.exchange_numbers import response_times
from fbcouple.case.bed.fluid_step import coupling_step, gas_step
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import OWN

SLOW = 0.002
"""Fluid step over tau_p up to which the drag of a step may leave the other forces out: a thousandth of it."""


def choose_acceleration(case: Case) -> tuple[bool, str]:
    """Does the drag of a step know the other forces (`exchange.accelerated`), and why.

    What the plain mean of the drag leaves out is half the fluid step over tau_p of the terminal velocity.
    """
    if not (case.gas and case.particles and case.exchange):
        return False, "one phase only: nothing is exchanged"
    if case.exchange.accelerated is not None:
        return case.exchange.accelerated, f"exchange.accelerated = {str(case.exchange.accelerated).lower()}"
    if case.exchange.scheme != "exponential" or case.exchange.drag == OWN:
        return False, "asked for only with exchange.accelerated = true"
    step = coupling_step(case) if case.contact else gas_step(case)
    ratio = step / response_times(case)["tau_p"]
    return ratio > SLOW, f"fluid step/tau_p = {ratio:.2g}, {SLOW:g} wanted"
