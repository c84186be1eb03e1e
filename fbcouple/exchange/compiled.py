"""How the loops over particles and cells are compiled: cached on disk, SIMD allowed, no check of each division."""

from __future__ import annotations

from numba import njit

compiled = njit(cache=True, fastmath=True, error_model="numpy")
inlined = njit(inline="always", fastmath=True, error_model="numpy")
