"""Drag laws by name. To add one: a scalar function under `@drag_law("name")`, and its anchor in the tests.

A law gives beta [kg/s] of one particle, F_D = beta (u - v), for model A: the gas keeps eps grad P and the particle
gets -V grad P besides. A fixed bed then loses n beta u / eps of pressure per length, n particles per volume and u the
gas velocity between them.

Equation numbers are those of Hamidouche et al. 2019, Fluids 4(1):51, unless a law says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numba import vectorize

Law = Callable[..., np.ndarray]
DRAG_LAWS: dict[str, Law] = {}


def drag_law(name: str) -> Callable[[Callable[..., float]], Law]:
    """Register a law under `name`, compiled into a NumPy ufunc.

    Its arguments are voidage [1], slip speed |u - v| [m/s], diameter [m], gas density [kg/m3], gas viscosity [Pa s].
    """

    def register(function: Callable[..., float]) -> Law:
        law = vectorize(["f8(f8,f8,f8,f8,f8)"], cache=True, fastmath=True)(function)
        DRAG_LAWS[name] = law
        return law

    return register


@drag_law("huilin-gidaspow")
def huilin_gidaspow(voidage, slip, diameter, density, viscosity):
    """Ergun and Wen-Yu joined by Huilin and Gidaspow's switch (eqs 20-25); 0.4 < voidage <= 1, Re_p of any size.

    beta = (pi/8) d mu C_D Re_p with Re_p = eps rho |u - v| d/mu. The products C_D Re_p are formed whole, so that
    slip = 0 gives the Stokes limit and no division by zero.
    """
    reynolds = voidage * density * slip * diameter / viscosity
    switch = math.atan(150.0 * 1.75 * (0.2 - (1.0 - voidage))) / math.pi + 0.5
    single = 24.0 * (1.0 + 0.15 * reynolds**0.687) if reynolds < 1000.0 else 0.44 * reynolds
    wen_yu = single * voidage**-2.7
    ergun = (200.0 * (1.0 - voidage) + 7.0 / 3.0 * reynolds) / voidage
    product = switch * wen_yu + (1.0 - switch) * ergun
    return math.pi / 8.0 * diameter * viscosity * product
