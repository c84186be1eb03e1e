"""Beds that are held in a flow: the pressure they cost, and the slip that carries them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.case.user_laws import DRAG_LAWS
from fbcouple.verify.harness import GAS, GLASS
from fbcouple.verify.lattice import VOIDAGES, HeldBed
from fbcouple.verify.published import PUBLISHED, Bed
from fbcouple.verify.registry import Number, check

_GRAVITY = 9.81
_INLET = 0.5
_SPEEDS = (0.1, 0.5, 2.0)
_FAST = ("huilin-gidaspow", "tenneti", "beetstra")

# Superficial velocity [m/s] that carries 1 mm glass in nitrogen at each of VOIDAGES, drag of Hamidouche et al. 2019,
# eqs 20-27: rows of shared/data/homogeneous_U_eps_paper_drag.csv, solved apart from this code.
_CARRIED = {0.4: 0.53996, 0.5: 0.91174, 0.6: 1.34454, 0.7: 1.82607, 0.8: 2.71933, 0.9: 4.89478}
_ROUNDS = 14


def fixed_bed(folder: Path, comm: MPI.Comm, law: str) -> Iterator[Number]:
    """Pressure per length of a held lattice at voidage 0.4-0.9 and superficial slip 0.1-2 m/s against what the
    paper of the drag law prints, within 1 %."""
    bed = HeldBed(folder, comm, law, _INLET)
    off = np.abs(bed.found_voidages - np.array(VOIDAGES)[:, None]).max()
    yield Number("voidage, cell farthest off", float(off), 0.0, 1e-12)
    for speed in _SPEEDS:
        bed.flow(np.full(len(VOIDAGES), speed))
        for eps, loss in zip(VOIDAGES, bed.pressure_losses, strict=True):
            asked = Bed(eps, speed, GLASS["diameter"], GAS["density"], GAS["viscosity"])
            name = f"dP/L at voidage {eps}, {speed} m/s"
            yield Number(name, float(loss), PUBLISHED[law](asked), 0.01, "Pa m-1", relative=True)


for _law in DRAG_LAWS:
    check(f"fixed-bed-{_law}", fast=_law in _FAST)(partial(fixed_bed, law=_law))


@check("held-lattice")
def held_lattice(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Superficial slip at which the gas carries a held lattice of 1 mm glass, voidage 0.4-0.9, within 1 %."""
    bed = HeldBed(folder, comm, "huilin-gidaspow", _INLET)
    weight = np.pi / 6 * GLASS["diameter"] ** 3 * GLASS["density"] * _GRAVITY
    low, high = np.full(len(VOIDAGES), 0.1), np.full(len(VOIDAGES), 8.0)
    for _ in range(_ROUNDS):
        middle = np.sqrt(low * high)
        bed.flow(middle)
        lifted = bed.gas_forces > weight
        low, high = np.where(lifted, low, middle), np.where(lifted, middle, high)
    for eps, speed in zip(VOIDAGES, np.sqrt(low * high), strict=True):
        yield Number(f"carrying velocity at voidage {eps}", float(speed), _CARRIED[eps], 0.01, "m s-1", relative=True)
