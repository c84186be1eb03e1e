"""Whether numbers of a step can be gone on with: finite, and a voidage that a gas can be solved with.

A check names the first cell or particle that breaks it, and where it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from fbcouple.case.schema.output import Monitors
from fbcouple.coupling.coupling import Coupling
from fbcouple.coupling.kernels import scan_min_max
from fbcouple.coupling.negative import Negative
from fbcouple.errors import DivergedError
from fbcouple.simulation.ledger import Ledger
from fbcouple.solvers.liggghts import Liggghts
from fbcouple.solvers.openfoam.gas import Gas

VOIDAGE = (
    "the voidage is {min_voidage:.4g} in {where}, above {limit:g} is allowed; more exchange.filter_passes (in a box of "
    "hexahedra also exchange.diffusion_width or a gaussian kernel) spread particles over more cells, and so do larger "
    "cells"
)
LEDGER = (
    "particles that came and went do not add up to those that there are: off by {ledger_error:.3g}, allowed {limit:g}: "
    "whole numbers are particles, the rest is the part of their mass or momentum"
)
VOIDAGE_EXCESS = "the voidage is 1 + {voidage_excess:.3g} in {where}, 1 + {limit:g} is allowed"


def require_finite_gas(time: float, owned: np.ndarray, gas: Gas) -> None:
    """Raise DivergedError with the first cell of this rank whose velocity or pressure is not finite, after the step
    from `time` [s]; `owned`: numbers of the cells."""
    if not gas.is_finite:
        words = next(find_not_finite(owned, gas), "the gas is too fast for its numbers")
        raise DivergedError(f"after the step from t = {time:.6g} s {words}")


def require_sound_exchange(time: float, limits: Monitors, owned: np.ndarray, gas: Gas, coupling: Coupling) -> None:
    """Raise DivergedError if this rank's voidage or drag is nothing that a gas can be solved with, before it is."""
    voidage, drag = coupling.gas_input
    least, most, total = scan_min_max(voidage, drag)
    if not math.isfinite(total):
        least, most = voidage.min(initial=1.0), voidage.max(initial=0.0)
    words = ""
    if len(voidage) and not least > limits.voidage:
        where = name_cell(owned, gas, find_thinnest(voidage))
        words = VOIDAGE.format(min_voidage=least, limit=limits.voidage, where=where) + " (monitors.voidage)"
    elif len(voidage) and not most - 1.0 <= limits.voidage_excess:
        where = name_cell(owned, gas, find_thinnest(-voidage))
        words = VOIDAGE_EXCESS.format(voidage_excess=most - 1.0, limit=limits.voidage_excess, where=where)
        words += " (monitors.voidage_excess)"
    elif coupling.negative:
        words = name_negative(owned, gas, coupling.negative)
    elif not math.isfinite(total):
        bad = np.flatnonzero(~np.isfinite(drag).all(axis=1))
        words = f"the drag is not finite: first of {len(bad)} cells of a rank is {name_cell(owned, gas, int(bad[0]))}"
    if words:
        raise DivergedError(f"in the step from t = {time:.6g} s {words}")


def require_forward_heat(time: float, owned: np.ndarray, gas: Gas, coupling: Coupling) -> None:
    """Raise DivergedError if heat flows against its direction between gas and one of this rank's particles."""
    if coupling.negative_heat:
        raise DivergedError(f"in the step from t = {time:.6g} s {name_negative(owned, gas, coupling.negative_heat)}")


def require_closed_ledger(time: float, limits: Monitors, ledger: Ledger) -> None:
    """Raise DivergedError if particles, mass or momentum were lost as particles came and went in the step."""
    if not ledger.error <= limits.ledger:
        message = LEDGER.format(ledger_error=ledger.error, limit=limits.ledger)
        raise DivergedError(f"at t = {time:.6g} s {message} (monitors.ledger)")


def find_thinnest(voidage: np.ndarray) -> int:
    """Cell of the least of `voidage` (n,), or of the first that is not a number."""
    return int((-voidage).argmax())


def find_not_finite(
    owned: np.ndarray, gas: Gas | None, coupling: Coupling | None = None, liggghts: Liggghts | None = None
) -> Iterator[str]:
    """What is not finite on this rank, and where first."""

    def cell(row: int) -> str:
        assert gas is not None
        return name_cell(owned, gas, row)

    def particle(row: int) -> str:
        assert liggghts is not None
        return name_particle(liggghts, row)

    fields: list[tuple[str, np.ndarray, Callable[[int], str]]] = []
    if gas:
        fields.append(("gas velocity", gas.velocity, cell))
        fields.append(("pressure", gas.pressure[:, None], cell))
        fields.append(("pressure gradient", gas.pressure_gradient, cell))
    if coupling:
        fields.append(("voidage", coupling.voidage[:, None], cell))
    if liggghts:
        fields.append(("position", liggghts.positions, particle))
        fields.append(("velocity", liggghts.velocities, particle))
    for what, field, name in fields:
        if np.isfinite(field.sum()):  # a sum is not if one of its numbers is not
            continue
        bad = np.flatnonzero(~np.isfinite(field).all(axis=1))
        if len(bad):
            yield f"the {what} is not finite: first of {len(bad)} of a rank is {name(int(bad[0]))}"


def name_cell(owned: np.ndarray, gas: Gas, row: int) -> str:
    """Name this rank's cell of `row` by its number, three of them in a box, and its centre."""
    number = owned[row].tolist()
    return f"cell {tuple(number) if len(number) > 1 else number[0]} at {format_point(gas.centres[row])}"


def name_negative(owned: np.ndarray, gas: Gas, found: Negative) -> str:
    """Name a particle that a law does wrong by its position and the nearest cell of this rank, and how to mend it."""
    row = int(((gas.centres - found.position) ** 2).sum(axis=1).argmin())
    where = f"the particle at {format_point(found.position)} in {name_cell(owned, gas, row)}"
    return f"{found.describe()}: it acts on {where} against its direction; take another law"


def name_particle(liggghts: Liggghts, row: int) -> str:
    """Name this rank's particle of `row` by its number and its position."""
    return f"particle {liggghts.numbers[row]} at {format_point(liggghts.positions[row])}"


def format_point(point: Any) -> str:
    """A point [m] as `(x, y, z) m`."""
    return f"({', '.join(f'{x:.6g}' for x in point)}) m"
