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
from numpy.typing import ArrayLike

from fbcouple.exchange.compiled import LAW, compile_as
from fbcouple.exchange.elementary import arctangent, power

Kernel = Callable[..., None]


class DragLaw:
    """A drag law, called on numbers or arrays: beta [kg/s] of each particle."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = compile_as(LAW)(kernel)
        self.__doc__ = kernel.__doc__

    def __call__(
        self, voidage: ArrayLike, slip: ArrayLike, diameter: ArrayLike, density: float, viscosity: float
    ) -> np.ndarray:
        """beta [kg/s]; voidage [1], slip speed |u - v| [m/s], diameter [m], gas density [kg/m3], viscosity [Pa s]."""
        arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (voidage, slip, diameter)))
        beta = np.empty(arrays[0].size)
        self.kernel(*(np.ascontiguousarray(array).ravel() for array in arrays), density, viscosity, beta)
        return beta.reshape(arrays[0].shape)


DRAG_LAWS: dict[str, DragLaw] = {}


def drag_law(name: str) -> Callable[[Kernel], DragLaw]:
    """Register a law under `name`: a loop that fills `beta` (n,) [kg/s].

    Its arguments are voidage (n,) [1], slip speed |u - v| (n,) [m/s], diameter (n,) [m], gas density [kg/m3], gas
    viscosity [Pa s], and `beta`.
    """

    def register(kernel: Kernel) -> DragLaw:
        DRAG_LAWS[name] = DragLaw(kernel)
        return DRAG_LAWS[name]

    return register


@drag_law("huilin-gidaspow")
def huilin_gidaspow(voidage, slip, diameter, density, viscosity, beta):
    """Ergun and Wen-Yu joined by Huilin and Gidaspow's switch (eqs 20-25); 0.4 < voidage <= 1, Re_p of any size.

    beta = (pi/8) d mu C_D Re_p with Re_p = eps rho |u - v| d/mu. The products C_D Re_p are formed whole, so that
    slip = 0 gives the Stokes limit and no division by zero.
    """
    for p in range(len(beta)):
        eps = voidage[p]
        reynolds = eps * density * slip[p] * diameter[p] / viscosity
        switch = arctangent(150.0 * 1.75 * (0.2 - (1.0 - eps))) / math.pi + 0.5
        single = 24.0 * (1.0 + 0.15 * power(reynolds, 0.687)) if reynolds < 1000.0 else 0.44 * reynolds
        wen_yu = single * power(eps, -2.7)
        ergun = (200.0 * (1.0 - eps) + 7.0 / 3.0 * reynolds) / eps
        beta[p] = math.pi / 8.0 * diameter[p] * viscosity * (switch * wen_yu + (1.0 - switch) * ergun)
