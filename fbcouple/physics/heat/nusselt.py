"""Laws of the heat transfer between gas and particles. To add one: a loop under `@nusselt_law("name")`, its word in
fbcouple/case/schema/heat.py, and numbers by hand in tests/physics/test_heat_laws.py.

A law gives the Nusselt number Nu = h d/k of one particle: h [W/(m2 K)] its heat transfer coefficient, k [W/(m K)] the
conductivity of the gas. Re = eps rho |u - v| d/mu by the superficial slip, as in the drag laws, and Pr = mu cp/k.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from fbcouple.physics.elementary import exponential, logarithm
from fbcouple.physics.jit import NUSSELT, compile_as

Kernel = Callable[..., None]

_TINY = 1e-300


class NusseltLaw:
    """A law of the Nusselt number, called on numbers or arrays."""

    def __init__(self, loop: Kernel, cache: bool = True) -> None:
        """`loop` fills nusselt, as `nusselt_law` says; `cache` keeps what the compiler made of it on disk."""
        self._loop, self._cache = loop, cache
        self.__doc__ = loop.__doc__

    @cached_property
    def kernel(self) -> Kernel:
        """The loop, compiled when it is first asked for."""
        return compile_as(NUSSELT, self._cache)(self._loop)

    def __call__(self, voidage: ArrayLike, reynolds: ArrayLike, prandtl: float) -> np.ndarray:
        """Nu [1]; voidage [1], Re [1] by the superficial slip, Pr [1]."""
        arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (voidage, reynolds)))
        nusselt = np.empty(arrays[0].size)
        self.kernel(*(np.ascontiguousarray(array).ravel() for array in arrays), prandtl, nusselt)
        return nusselt.reshape(arrays[0].shape)


NUSSELT_LAWS: dict[str, NusseltLaw] = {}


def nusselt_law(name: str) -> Callable[[Kernel], NusseltLaw]:
    """Register a law under `name`: a loop that fills `nusselt` (n,) [1] from voidage (n,) [1], Re (n,) [1] and Pr
    [1]."""

    def register(loop: Kernel) -> NusseltLaw:
        NUSSELT_LAWS[name] = NusseltLaw(loop)
        return NUSSELT_LAWS[name]

    return register


@nusselt_law("gunn")
def gunn(voidage, reynolds, prandtl, nusselt):
    """Fixed and fluidized beds; voidage 0.35 to 1, Re up to 1e5.

    Nu = (7 - 10 eps + 5 eps^2)(1 + 0.7 Re^0.2 Pr^(1/3)) + (1.33 - 2.4 eps + 1.2 eps^2) Re^0.7 Pr^(1/3).

    Gunn 1978, Int. J. Heat Mass Transfer 21:467.
    """
    root = prandtl ** (1.0 / 3.0)
    for p in range(len(nusselt)):
        eps, log = voidage[p], logarithm(max(reynolds[p], _TINY))
        slow = (7.0 - 10.0 * eps + 5.0 * eps * eps) * (1.0 + 0.7 * exponential(0.2 * log) * root)
        nusselt[p] = slow + (1.33 - 2.4 * eps + 1.2 * eps * eps) * exponential(0.7 * log) * root


@nusselt_law("ranz-marshall")
def ranz_marshall(voidage, reynolds, prandtl, nusselt):
    """A lone sphere, whatever the voidage; measured on drops at Re up to 200, in use to 1e4.

    Nu = 2 + 0.6 Re^(1/2) Pr^(1/3).

    Ranz and Marshall 1952, Chem. Eng. Prog. 48:141 and 173.
    """
    root = prandtl ** (1.0 / 3.0)
    for p in range(len(nusselt)):
        nusselt[p] = 2.0 + 0.6 * np.sqrt(reynolds[p]) * root
