"""How the loops over particles and cells are compiled: cached on disk, SIMD allowed, no check of each division."""

from __future__ import annotations

from numba import f8, njit, types, u8

compiled = njit(cache=True, fastmath=True, error_model="numpy")
inlined = njit(inline="always", fastmath=True, error_model="numpy")

VECTOR = types.Array(f8, 1, "C")
ROWS = types.Array(f8, 2, "C")
PLACES = types.Array(u8, 1, "C")
LAW = types.void(VECTOR, VECTOR, VECTOR, f8, f8, VECTOR)
"""Drag law: voidage, slip, diameter (n,), gas density and viscosity, beta (n,) to fill."""
SCHEME = types.void(VECTOR, VECTOR, f8)
"""Drag over a step: beta (n,) to change, masses (n,), step."""


def compile_as(signature, cache: bool = True):
    """Compile for one signature, so that the function can be handed to another compiled one."""
    return njit(signature, cache=cache, fastmath=True, error_model="numpy")
