"""Frames of a run: all particles, and the gas in every cell, at single moments."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from fbcouple.errors import CaseError
from fbcouple.results.reader import NotDrawableError
from fbcouple.results.stored import load

_PARTICLES = ("position", "velocity", "diameter")
_GAS = ("voidage", "gas_velocity", "gas_temperature")
_MARKS = ("species", "feed", "temperature")
_PARCEL = "parcel_diameter"
_SHAPES: dict[str, tuple[str, ...]] = {
    "time": (),
    "position": ("particle", "component"),
    "velocity": ("particle", "component"),
    "diameter": ("particle",),
    _PARCEL: ("particle",),
    "number": ("particle",),
    "species": ("particle",),
    "feed": ("particle",),
    "temperature": ("particle",),
    "voidage": ("z", "y", "x"),
    "gas_velocity": ("component", "z", "y", "x"),
    "gas_temperature": ("z", "y", "x"),
}


@dataclass(frozen=True)
class Frame:
    """One moment: `time` [s]; of particles, or parcels, positions [m] and velocities [m/s] (n, 3), diameters [m] and
    numbers (n,); of the gas `voidage` (z, y, x) and velocity (component, z, y, x) [m/s] in the cells, None in a case
    without gas.

    `species` and `feeds` (n,): which species each particle is of, and by which feed it came in, 0 of those of the
    start; None where there is one species, or no particles come or go. `grain_diameters` [m] (n,): of the grains that
    parcels stand for; None where it has no parcels. `temperatures` [K] (n,) of the particles and
    `gas_temperature` [K] (z, y, x): None in a case without heat.
    """

    time: float
    positions: np.ndarray
    velocities: np.ndarray
    diameters: np.ndarray
    voidage: np.ndarray | None
    gas_velocity: np.ndarray | None
    numbers: np.ndarray
    species: np.ndarray | None = None
    feeds: np.ndarray | None = None
    temperatures: np.ndarray | None = None
    gas_temperature: np.ndarray | None = None
    grain_diameters: np.ndarray | None = None

    @property
    def speeds(self) -> np.ndarray:
        """Speed of each particle [m/s], (n,)."""
        return np.linalg.norm(self.velocities, axis=1)


def read_frame(path: Path) -> Frame:
    """Read one frame. Raises: NotDrawableError if the file is damaged, or is no frame."""
    try:
        data = load(path)
    except CaseError as error:
        text = "; ".join(error.problems)
        raise NotDrawableError([f"a frame cannot be read: {text} Or remove it."]) from error
    if odd := [name for name, dims in _SHAPES.items() if not _has(data, name, dims)]:
        text = f"{path} has no {odd[0]} over ({', '.join(_SHAPES[odd[0]])}): it is no frame"
        raise NotDrawableError([f"{text}; remove it, or run the case again."])
    voidage, velocity, warmth = (data[name].values if name in data else None for name in _GAS)
    numbers = data["number"].values if "number" in data else np.arange(1, data.sizes["particle"] + 1)
    species, feeds, temperatures = (data[name].values if name in data else None for name in _MARKS)
    positions, velocities, diameters = (data[name].values for name in _PARTICLES)
    diameters, grains = (data[_PARCEL].values, diameters) if _PARCEL in data else (diameters, None)
    moment = float(data["time"]), positions, velocities, diameters
    return Frame(*moment, voidage, velocity, numbers, species, feeds, temperatures, warmth, grains)


def _has(data: xr.Dataset, name: str, dims: tuple[str, ...]) -> bool:
    if name not in data:
        return name in (*_GAS, *_MARKS, _PARCEL, "number")
    return data[name].dims == dims and data[name].dtype.kind in "iuf" and data.sizes.get("component", 3) == 3
