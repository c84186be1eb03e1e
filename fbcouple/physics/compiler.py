"""Numba, with the place where it keeps what it compiles: whoever compiles takes it from here."""

from __future__ import annotations

import numba
from numba import njit

from fbcouple.machine.cache import prepare_compiled

__all__ = ["njit"]

numba.config.CACHE_DIR = str(prepare_compiled())  # type: ignore[attr-defined]
