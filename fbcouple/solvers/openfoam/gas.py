"""The gas of this rank: OpenFOAM's solution of the volume-averaged equations, step by step."""

from __future__ import annotations

import ctypes
import math
import os
import re
import shutil
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path

import numpy as np

from fbcouple.errors import DivergedError, SolverError
from fbcouple.geometry.polyhedra import Polyhedra, take_apart
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.ragged import pile_up
from fbcouple.run_folder.plain_files import format_moved, is_same
from fbcouple.solvers.c_library import Signature, load_library
from fbcouple.solvers.openfoam.build import adapter_path

_double = ctypes.POINTER(ctypes.c_double)
_whole = ctypes.POINTER(ctypes.c_int64)
_FUNCTIONS: dict[str, Signature] = {
    "gas_error": (ctypes.c_char_p, []),
    "gas_open": (
        ctypes.c_int,
        [ctypes.c_int, ctypes.POINTER(ctypes.c_char_p), ctypes.c_char_p, ctypes.c_double, ctypes.c_int],
    ),
    "gas_time_name": (ctypes.c_char_p, []),
    "gas_cell_count": (ctypes.c_int64, []),
    "gas_cells": (ctypes.c_int, [_double, _double]),
    "gas_mesh_sizes": (ctypes.c_int, [_whole]),
    "gas_mesh": (ctypes.c_int, [_double, *[_whole] * 6]),
    "gas_set_inlet": (ctypes.c_int, [ctypes.c_int, _whole, _double]),
    "gas_expand": (ctypes.c_int, [ctypes.c_double, ctypes.c_double]),
    "gas_start": (ctypes.c_int, [_double]),
    "gas_step": (ctypes.c_int, [ctypes.c_double, ctypes.c_double, _double, _double]),
    "gas_fields": (ctypes.c_int, [_double, _double, _double, _double]),
    "gas_derive": (ctypes.c_int, [ctypes.c_char_p, _double]),
    "gas_measure": (ctypes.c_int, [_double]),
    "gas_outlets": (ctypes.c_int, [_double]),
    "gas_write": (ctypes.c_int, []),
}
_END_OF_FILE = b"************************ //"
_SYSTEM_PROJECT = "/usr/share/openfoam"


@dataclass(frozen=True)
class GasReport:
    """What the last gas step was like, the same on every rank."""

    courant: float
    fourier: float
    lost: float
    """Gas volume that continuity lost [m3/s]; all volumes are those that the gas has at the density of the case."""
    inflow: float
    """Gas volume that came in by the inlet [m3/s], below 0 where it went out."""
    inlet_pressure: float
    """Mean dynamic pressure at the faces of the inlet [Pa]."""
    iterations: int
    displaced_wrongly: float
    """Gas volume [m3] that the step displaced too much or too little, cell by cell: it was not as long as the one in
    which the particles moved."""
    outflow: float
    """Gas volume that went out by the outlet [m3/s]."""
    backflow: float
    """Gas volume that came in by the outlet [m3/s]."""


class Gas:
    """OpenFOAM in this process, one instance a process; arrays hold this rank's cells.

    `state` (n, 6), of which `velocity` (n, 3) [m/s] and `pressure_gradient` (n, 3) [Pa/m] are the halves, `pressure`
    (n,) [Pa], and `voidage` (n,), what they were solved with, are refreshed in place by `step`; `centres` (n, 3) [m]
    and `volumes` (n,) [m3] are fixed.
    `momentum_loss` (7,) is what the cells gave to the particles in the last step, as sums: V (K u - S) [N], V alpha
    grad P [N], V alpha [m3].
    """

    def __init__(self, case: Path, log: Path, density: float, correctors: int, rank: int | None) -> None:
        """`rank` of several, for each of which `case` holds a part of the mesh; None where one has it all."""
        os.environ.setdefault("WM_PROJECT_DIR", _SYSTEM_PROJECT)
        self._case, self._place = case, case.resolve()
        self._folder = case if rank is None else case / f"processor{rank}"
        # OpenFOAM would trap floating-point exceptions in all of Python; a gas that is not finite is caught by checks.
        os.environ["FOAM_SIGFPE"] = "false"
        mend = "fbcouple doctor --fix"
        self._library = load_library(adapter_path(), _FUNCTIONS, mend)
        words = [b"fbcouple", b"-case", os.fsencode(case)] + ([] if rank is None else [b"-parallel"])
        arguments = (ctypes.c_char_p * (len(words) + 1))(*words, None)
        self._check(self._library.gas_open(len(words), arguments, os.fsencode(log), density, correctors))
        n = self._library.gas_cell_count()
        self.centres, self.volumes = np.empty((n, 3)), np.empty(n)
        self._check(self._library.gas_cells(point_to(self.centres), point_to(self.volumes)))
        self.state, self.pressure, self.voidage = np.empty((n, 6)), np.empty(n), np.empty(n)
        self.velocity, self.pressure_gradient = self.state[:, :3], self.state[:, 3:]
        self._totals = np.zeros(8)
        self.momentum_loss = self._totals[:7]
        self._read_fields()

    @cached_property
    def clean_input(self) -> tuple[np.ndarray, np.ndarray]:
        """Voidage and drag of a gas without particles."""
        n = len(self.volumes)
        return np.ones(n), np.zeros((n, 4))

    @property
    def is_finite(self) -> bool:
        """Was every number of the last step's fields finite? A sum over them is not if one of them is not."""
        return math.isfinite(sum(self._totals.tolist()))

    def read_polyhedra(self) -> Polyhedra:
        """The cells of this rank in the order of all its arrays, with their numbers in the whole mesh."""
        sizes = np.empty(4, np.int64)
        self._check(self._library.gas_mesh_sizes(_point_whole(sizes)))
        points, faces, inner, corners = sizes.tolist()
        coordinates = np.empty((points, 3))
        counts = faces, corners, faces, inner, len(self.volumes), points
        lengths, values, owner, neighbour, cells, ids = (np.empty(count, np.int64) for count in counts)
        wholes = map(_point_whole, (lengths, values, owner, neighbour, cells, ids))
        self._check(self._library.gas_mesh(point_to(coordinates), *wholes))
        mesh = PolyMesh(coordinates, pile_up(lengths, values), owner, neighbour, {})
        return take_apart(mesh, self.centres, cells, ids)

    def set_inlet(self, tables: Sequence[Sequence[tuple[float, float]]]) -> None:
        """From now on the inlet follows `tables`, one of each inlet: times [s] and superficial velocities [m/s]. For a
        gas that goes on from a checkpoint, which has the tables that it was written with."""
        lengths = np.array([len(rows) for rows in tables], np.int64)
        rows = np.concatenate([np.array(rows, np.float64) for rows in tables]).ravel()
        self._check(self._library.gas_set_inlet(len(tables), _point_whole(lengths), point_to(rows)))

    def expand(self, temperature: float, gravity: float) -> None:
        """From now on the density follows the temperature of the `GasHeat` that is open, as that of an ideal gas does
        that has the density of the case at `temperature` [K]; gravity [m/s2] downwards (collective)."""
        self._check(self._library.gas_expand(temperature, gravity))

    def start(self, voidage: np.ndarray) -> None:
        """Give the voidage (n,) at time zero, so that d(eps)/dt of the first step is the particles' own."""
        self._check(self._library.gas_start(point_to(voidage)))
        self._read_fields()

    def step(self, dt: float, voidage: np.ndarray, drag: np.ndarray, moved: float = 0.0) -> None:
        """Advance by `dt` [s] with the new voidage (n,) and the sums (n, 4) over the particles of each cell of beta
        [kg/s] and beta v [N]: V K and V S of the drag S - K u.

        moved [s]: length of the step in which the particles made the voidage change, so that d(eps)/dt is their own;
        0: as long as this one.

        Raises DivergedError if the solution is not finite, SolverError if OpenFOAM fails otherwise.
        """
        status = self._library.gas_step(dt, moved or dt, point_to(voidage), point_to(drag))
        if status and re.search(r"'-?(nan|inf)'", words := self._library.gas_error().decode(errors="replace")):
            raise DivergedError(f"the gas step of {dt:.6g} s gave numbers that are none; OpenFOAM: {words}")
        self._check(status)
        self._read_fields()

    def measure(self) -> GasReport:
        """What the last step was like (collective)."""
        values = np.empty(len(fields(GasReport)))
        self._check(self._library.gas_measure(point_to(values)))
        courant, fourier, lost, inflow, pressure, iterations, *others = values.tolist()
        return GasReport(courant, fourier, lost, inflow, pressure, int(iterations), *others)

    def measure_outlets(self, count: int) -> np.ndarray:
        """Gas volume [m3/s] that went out by each of the `count` outlets of the mesh in the last step, and that came in
        by it, (count, 2) (collective)."""
        flows = np.empty((count, 2))
        self._check(self._library.gas_outlets(point_to(flows)))
        return flows

    def derive(self, names: Sequence[str]) -> np.ndarray:
        """Fields of the velocity as it is now, shape (n, 3 names), of "curl" [1/s], "convection" u.grad(u) and
        "viscous" div(tau)/rho [m/s2] (collective)."""
        fields = [np.empty((len(self.volumes), 3)) for _ in names]
        for name, field in zip(names, fields, strict=True):
            self._check(self._library.gas_derive(name.encode(), point_to(field)))
        return np.concatenate(fields, axis=1)

    def write(self) -> Path:
        """Write this rank's fields as an OpenFOAM time directory (collective).

        Every registered field with AUTO_WRITE is in it, in binary; one that a later step starts from needs no more.
        Returns the directory. Raises SolverError if a file in it is cut short, as on a full disk, or the case was
        moved: OpenFOAM goes by the path that it had at the start, and would make it again.
        """
        self._require_in_place()
        self._check(self._library.gas_write())
        folder = self._folder / self._library.gas_time_name().decode()
        self._require_in_place(folder)
        for file in folder.rglob("*"):
            if file.is_file() and not file.read_bytes().rstrip().endswith(_END_OF_FILE):
                raise SolverError(f"OpenFOAM: {file} is cut short; is the disk full?")
        return folder

    def _require_in_place(self, written: Path | None = None) -> None:
        """Raise SolverError if the case was moved; `written`, which went to the old place then, is removed there."""
        if is_same(self._place, self._case):
            return
        if written:
            there = self._place / written.relative_to(self._case)
            shutil.rmtree(there, ignore_errors=True)
            with suppress(OSError):  # what is not empty was there
                for folder in there.parents[: len(there.parents) - len(self._place.parents) + 1]:
                    folder.rmdir()
        raise SolverError(format_moved(self._place.parent))

    def _read_fields(self) -> None:
        self._check(self._library.gas_fields(*map(point_to, (self.state, self.pressure, self.voidage, self._totals))))

    def _check(self, status: int) -> None:
        if status:
            raise SolverError(f"OpenFOAM: {self._library.gas_error().decode(errors='replace')}")


def point_to(array: np.ndarray) -> ctypes._Pointer:
    """The start of an array, as C takes it. Raises TypeError for one that it would read wrongly."""
    if array.dtype != np.float64 or not array.flags.c_contiguous:
        raise TypeError(f"the adapter takes contiguous float64 arrays, not {array.dtype}")
    return ctypes.cast(array.ctypes.data, _double)


def _point_whole(array: np.ndarray) -> ctypes._Pointer:
    return ctypes.cast(array.ctypes.data, _whole)
