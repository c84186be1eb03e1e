"""Conductivity of the gas with particles in it, by the word of `heat.bed_conduction`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Law = Callable[[np.ndarray, float, float], np.ndarray]

BED_CONDUCTIVITIES: dict[str, Law] = {}
_SERIES_UP_TO = 0.05
"""|N| below which the closed form loses digits and its series has them."""
_TERMS = 14
_NO_SOLIDS = 1e-12


def bed_conductivity(name: str) -> Callable[[Law], Law]:
    """Register a law under `name`: voidage (n,) [1], conductivities of gas and particles [W/(m K)] -> that of the
    cells (n,) [W/(m K)]."""

    def register(law: Law) -> Law:
        BED_CONDUCTIVITIES[name] = law
        return law

    return register


@bed_conductivity("none")
def conduct_by_gas(voidage: np.ndarray, gas: float, particles: float) -> np.ndarray:
    """eps k: the gas conducts in the part of the cell that it has, and the particles not at all."""
    return voidage * gas


@bed_conductivity("zehner-schlunder")
def conduct_by_bed(voidage: np.ndarray, gas: float, particles: float) -> np.ndarray:
    """A packed bed at rest with gas between its spheres, contacts of no area; k at voidage 1.

    k_bed/k = 1 - sqrt(phi) + sqrt(phi) 2/N (B/N^2 (1 - 1/r) ln(r/B) - (B + 1)/2 - (B - 1)/N), with r the
    conductivity of the particles over that of the gas, phi = 1 - eps, B = 1.25 (phi/eps)^(10/9) of spheres, and
    N = 1 - B/r. Packed beds, eps 0.35 to 0.6; used above that as it goes over into the gas alone.

    Zehner and Schlunder 1970, Chem. Ing. Tech. 42:933 (no radiation, no Knudsen effect, no flattened contacts).
    """
    solids = np.maximum(1.0 - voidage, 0.0)
    there = solids > _NO_SOLIDS
    phi = np.where(there, solids, 0.5)
    shape = 1.25 * (phi / (1.0 - phi)) ** (10.0 / 9.0)
    core = _find_core(shape, particles / gas)
    root = np.sqrt(phi)
    return gas * np.where(there, 1.0 - root + root * core, 1.0)


def _find_core(shape: np.ndarray, ratio: float) -> np.ndarray:
    """Conductivity of the part of the bed with spheres in it over that of the gas; B = `shape`, r = `ratio`."""
    n = 1.0 - shape / ratio
    is_small = np.abs(n) < _SERIES_UP_TO
    safe = np.where(is_small, 0.5, n)
    closed = shape / safe**2 * (1.0 - 1.0 / ratio) * np.log(ratio / shape)
    closed = 2.0 / safe * (closed - 0.5 * (shape + 1.0) - (shape - 1.0) / safe)
    # B/N^2 (1 - 1/r) = (B - 1 + N)/N^2 and ln(r/B) = N + N^2/2 + N^3/3 + ...: what is left after the poles have gone.
    near = np.where(is_small, n, 0.0)
    series = sum(near**j * ((shape - 1.0) / (j + 3.0) + 1.0 / (j + 2.0)) for j in range(_TERMS))
    return np.where(is_small, 2.0 * series, closed)
