"""What a drag law is, and the registry of those that come with fbcouple."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from fbcouple.physics.jit import LAW, compile_as

Kernel = Callable[..., None]


class DragLaw:
    """A drag law, called on numbers or arrays: beta [kg/s] of each particle."""

    def __init__(self, loop: Kernel, cache: bool = True, most: float | None = None) -> None:
        """`loop` fills beta, as `drag_law` says; `cache` keeps what the compiler made of it on disk; `most`, too."""
        self._loop, self._cache = loop, cache
        self.most = most
        """Reynolds number of the superficial slip up to which its paper has it; None: it says none."""
        self.__doc__ = loop.__doc__

    @cached_property
    def kernel(self) -> Kernel:
        """The loop, compiled when it is first asked for."""
        return compile_as(LAW, self._cache)(self._loop)

    def __call__(
        self, voidage: ArrayLike, slip: ArrayLike, diameter: ArrayLike, density: float, viscosity: float
    ) -> np.ndarray:
        """beta [kg/s]; voidage [1], slip speed |u - v| [m/s], diameter [m], gas density [kg/m3], viscosity [Pa s]."""
        arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (voidage, slip, diameter)))
        beta = np.empty(arrays[0].size)
        self.kernel(*(np.ascontiguousarray(array).ravel() for array in arrays), density, viscosity, beta)
        return beta.reshape(arrays[0].shape)


DRAG_LAWS: dict[str, DragLaw] = {}


def drag_law(name: str, most: float | None = None) -> Callable[[Kernel], DragLaw]:
    """Register a law under `name`, made for Reynolds numbers up to `most`: a loop that fills `beta` (n,) [kg/s].

    Its arguments are voidage (n,) [1], slip speed |u - v| (n,) [m/s], diameter (n,) [m], gas density [kg/m3], gas
    viscosity [Pa s], and `beta`.
    """

    def register(loop: Kernel) -> DragLaw:
        DRAG_LAWS[name] = DragLaw(loop, most=most)
        return DRAG_LAWS[name]

    return register
