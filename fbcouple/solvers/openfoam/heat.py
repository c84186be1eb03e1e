"""The enthalpy of the gas of this rank: one more equation of the adapter, for cases with heat."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

import numpy as np

from fbcouple.errors import SolverError
from fbcouple.solvers.c_library import Signature, load_library
from fbcouple.solvers.openfoam.build import adapter_path
from fbcouple.solvers.openfoam.gas import point_to

_double = ctypes.POINTER(ctypes.c_double)
_FUNCTIONS: dict[str, Signature] = {
    "gas_error": (ctypes.c_char_p, []),
    "gas_heat_open": (ctypes.c_int, [ctypes.c_double, ctypes.c_double, ctypes.c_double, _double, ctypes.c_int]),
    "gas_heat_step": (ctypes.c_int, [_double, _double, _double]),
    "gas_temperatures": (ctypes.c_int, [_double]),
}
SIDES = 7
"""Rows of what walls are like: those on no side of the box around the mesh, then low and high x, y and z."""


@dataclass(frozen=True)
class HeatAmounts:
    """What a step did to the heat of the gas in this rank's cells [J], counted from the reference temperature."""

    before: float
    after: float
    by_walls: float
    """Came in by walls, below 0 where it went out."""
    by_inlets: float
    by_outlets: float
    by_continuity: float
    """Made by gas volume that continuity lost, or that a step unlike the one before displaced wrongly."""
    by_particles: float
    magnitude: float
    """Sum of the magnitudes of what the cells hold."""


class GasHeat:
    """The temperature of the gas of this process, whose `Gas` is open; arrays hold this rank's cells.

    `temperatures` (n,) [K] are refreshed in place by `step`.
    """

    def __init__(
        self,
        cells: int,
        capacity: float,
        reference: float,
        turbulent_prandtl: float,
        walls: np.ndarray,
        on_voidage: bool,
    ):
        """Gas of the heat `capacity` [J/(m3 K)]; heat counts from `reference` [K]; turbulent_prandtl [1]: 0 of a gas
        without a model; `walls` (SIDES, 2): temperature [K] and coefficient [W/(m2 K)], nan where there is none;
        on_voidage: coefficients count on the share of a wall that the gas touches, not on the whole (collective)."""
        self._library = load_library(adapter_path(), _FUNCTIONS, "fbcouple doctor --fix")
        rows = np.ascontiguousarray(walls, dtype=float)
        opened = self._library.gas_heat_open(capacity, reference, turbulent_prandtl, point_to(rows), on_voidage)
        self._check(opened)
        self.temperatures = np.empty(cells)
        self._amounts = np.zeros(len(HeatAmounts.__dataclass_fields__))
        self._check(self._library.gas_temperatures(point_to(self.temperatures)))

    def step(self, conductivity: np.ndarray, sums: np.ndarray) -> HeatAmounts:
        """The step that the gas has just taken, with `conductivity` (n,) [W/(m K)] and the sums (n, 2) over the
        particles of each cell of H [W/K] and H (T_p - reference) [W] (collective).

        Raises SolverError if OpenFOAM fails.
        """
        self._check(self._library.gas_heat_step(*map(point_to, (conductivity, sums, self._amounts))))
        self._check(self._library.gas_temperatures(point_to(self.temperatures)))
        return HeatAmounts(*self._amounts.tolist())

    def _check(self, status: int) -> None:
        if status:
            raise SolverError(f"OpenFOAM: {self._library.gas_error().decode(errors='replace')}")
