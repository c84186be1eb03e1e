"""The particles of this rank: stock LIGGGHTS by its C library, seen through NumPy views."""

from __future__ import annotations

import ctypes
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.errors import SolverError
from fbcouple.solvers.c_library import Signature, load_library
from fbcouple.solvers.c_stream import shorten, standard_output_into
from fbcouple.solvers.site_files import find_liggghts

_COMMUNICATOR = {4: ctypes.c_int, 8: ctypes.c_void_p}[MPI._sizeof(MPI.Comm)]
"""The handle of a communicator in C: a pointer in Open MPI, a number in MPICH and what stems from it."""
_FUNCTIONS: dict[str, Signature] = {
    "lammps_open": (
        None,
        [ctypes.c_int, ctypes.POINTER(ctypes.c_char_p), _COMMUNICATOR, ctypes.POINTER(ctypes.c_void_p)],
    ),
    "lammps_close": (None, [ctypes.c_void_p]),
    "lammps_file": (None, [ctypes.c_void_p, ctypes.c_char_p]),
    "lammps_command": (ctypes.c_char_p, [ctypes.c_void_p, ctypes.c_char_p]),
    "lammps_extract_global": (ctypes.c_void_p, [ctypes.c_void_p, ctypes.c_char_p]),
    "lammps_extract_atom": (ctypes.c_void_p, [ctypes.c_void_p, ctypes.c_char_p]),
    "lammps_extract_fix": (
        ctypes.c_void_p,
        [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_int],
    ),
}
_view_memory = ctypes.pythonapi.PyMemoryView_FromMemory
_view_memory.restype, _view_memory.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_ssize_t, ctypes.c_int]
_WRITABLE = 0x200
_VIEWS = 64
"""Views kept from step to step: LIGGGHTS moves its arrays seldom."""

IDENTITY = ("number", "entry_time", "feed")
"""What a particle is known by where particles come and go: a number that no other one ever has, when it came in [s],
and by which feed, counted from 1; 0 and 0 for those of the start."""

_LOOK_EVERY = 1000
"""Calls of `advance` between two looks at the length of the log; a call adds a kilobyte at most."""


class Liggghts:
    """LIGGGHTS in this process, one instance a process.

    Every array is a view into LIGGGHTS' own memory with a row per particle of this rank. A view is valid until the
    next `advance`: ask again after it.
    """

    def __init__(
        self,
        deck: Path,
        log: Path,
        comm: MPI.Comm,
        restart: Path | None = None,
        remembers: bool = False,
        identifies: bool = False,
    ) -> None:
        """Read the deck `deck`, with the particles of the file `restart` in place of its own where one is given. If it
        `remembers`, every `advance` first keeps the velocities; if it `identifies`, particles have an `identity`; the
        deck has a place for them."""
        self.remembers, self.identifies, self._carried = remembers, identifies, 0.0
        self.held_gravity = 0.0
        """Gravity [m/s2] whose weight is in `held_force`; 0 where LIGGGHTS has a fix of its own for it."""
        self._library = load_library(find_liggghts(), _FUNCTIONS, "sudo apt-get install liggghts")
        self._log, self._runs = log if comm.rank == 0 else None, 0
        words = [b"liggghts", b"-log", b"none"]
        arguments = (ctypes.c_char_p * (len(words) + 1))(*words, None)
        handle = _COMMUNICATOR.from_address(MPI._addressof(comm))
        self._lammps = ctypes.c_void_p()
        # The screen and not the log: what goes wrong on one rank LIGGGHTS tells on its screen alone.
        with standard_output_into(log):
            self._library.lammps_open(len(words), arguments, handle, ctypes.byref(self._lammps))
        if restart:
            deck = _put_restart(deck, restart, log.with_name("in.resumed"), comm)
        self.read(deck)
        self._count = self._global("nlocal", ctypes.c_int)
        self._views: dict[tuple[int, Any, tuple[int, ...]], np.ndarray] = {}
        self.bounds = self._read_bounds()

    @property
    def count(self) -> int:
        """Particles of this rank."""
        return self._count.value

    @property
    def tags(self) -> np.ndarray:
        """LIGGGHTS' own numbers of the particles, shape (count,); where particles come and go one may be used again."""
        return self._atoms("id", ctypes.c_int)

    @property
    def numbers(self) -> np.ndarray:
        """Numbers of the particles, from 1 in the order of the data file and then in that of coming in, shape (count,);
        rows may change places."""
        return self.identity[:, 0].astype(np.int64) if self.identifies else self.tags

    @property
    def types(self) -> np.ndarray:
        """LIGGGHTS' types of the particles, from 1: the kinds of the case, in its order; shape (count,)."""
        return self._atoms("type", ctypes.c_int)

    @property
    def positions(self) -> np.ndarray:
        """Centres [m], shape (count, 3)."""
        return self._atoms("x", ctypes.c_double, 3)

    @property
    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape (count, 3)."""
        return self._atoms("v", ctypes.c_double, 3)

    @property
    def angular_velocities(self) -> np.ndarray:
        """Angular velocities [rad/s], shape (count, 3); they change only where the case asks for rotation."""
        return self._atoms("omega", ctypes.c_double, 3)

    @property
    def forces(self) -> np.ndarray:
        """Total force of the last sub-step [N], shape (count, 3): what the next sub-step starts with."""
        return self._atoms("f", ctypes.c_double, 3)

    @property
    def radii(self) -> np.ndarray:
        """Radii [m], shape (count,)."""
        return self._atoms("radius", ctypes.c_double)

    @property
    def densities(self) -> np.ndarray:
        """Densities [kg m-3] of the material, shape (count,)."""
        return self._atoms("density", ctypes.c_double)

    @property
    def masses(self) -> np.ndarray:
        """Masses [kg] that move, shape (count,): with the gas that particles carry along (`add_inertia`)."""
        return self._atoms("rmass", ctypes.c_double)

    @property
    def held_force(self) -> np.ndarray:
        """Force of the gas and, with `held_gravity`, the weight [N], shape (count, 3), writable: held over the
        sub-steps, it travels with its particle."""
        pointer = self._library.lammps_extract_fix(self._lammps, b"dragforce", 1, 2, 0, 0)
        return self._view(pointer, ctypes.c_double, self.count, 3)

    @property
    def weights(self) -> np.ndarray:
        """Weight [N] of each particle that is in `held_force`, downwards, shape (count,)."""
        return self.held_gravity * self.masses

    @property
    def gas_force(self) -> np.ndarray:
        """Force of the gas [N], shape (count, 3): a copy."""
        force = self.held_force.copy()
        force[:, 2] += self.weights
        return force

    @property
    def last_velocities(self) -> np.ndarray:
        """Velocities [m/s] before the last `advance`, shape (count, 3); only if it `remembers`."""
        pointer = self._library.lammps_extract_fix(self._lammps, b"lastVelocity", 1, 2, 0, 0)
        return self._view(pointer, ctypes.c_double, self.count, 3)

    @property
    def drag_only_velocities(self) -> np.ndarray:
        """Velocities [m/s] that travel with the particles for whoever writes them, shape (count, 3), writable; only if
        the deck has a place for them."""
        pointer = self._library.lammps_extract_fix(self._lammps, b"drivenVelocity", 1, 2, 0, 0)
        return self._view(pointer, ctypes.c_double, self.count, 3)

    @property
    def identity(self) -> np.ndarray:
        """Columns IDENTITY of each particle, shape (count, 3), writable, which travel with it and into checkpoints;
        only if the deck has a place for them."""
        pointer = self._library.lammps_extract_fix(self._lammps, b"identity", 1, 2, 0, 0)
        return self._view(pointer, ctypes.c_double, self.count, len(IDENTITY))

    @property
    def temperatures(self) -> np.ndarray:
        """Temperatures [K] of the particles, shape (count,), writable, which travel with them and into checkpoints;
        only if the deck has a place for them. Where contacts conduct the DEM steps change them."""
        pointer = self._library.lammps_extract_fix(self._lammps, b"Temp", 1, 1, 0, 0)
        return self._view(pointer, ctypes.c_double, self.count)

    @property
    def own_masses(self) -> np.ndarray:
        """Masses [kg], shape (count,), without gas that they carry along: what counts as solids."""
        return 4.0 / 3.0 * np.pi * self.radii**3 * self.densities if self._carried else self.masses

    @property
    def carried_mass(self) -> float:
        """Mass [kg] of the gas that this rank's particles carry along."""
        return float((self.masses - self.own_masses).sum()) if self._carried else 0.0

    def add_inertia(self, density: float) -> None:
        """Let each particle have the mass of its own density and of `density` [kg m-3] more; once or again."""
        self._carried = density
        self.masses[:] = 4.0 / 3.0 * np.pi * self.radii**3 * (self.densities + density)

    def remove(self, rows: np.ndarray) -> None:
        """Delete this rank's particles of `rows` (n,), where it has some to delete (collective).

        The deck has the group, empty, whose particles are deleted. What contacts remember is stored with the particles
        first, so that rows may change; `advance` with `first` has to follow before anything moves.
        """
        self.command(f"group leaving id {' '.join(map(str, self.tags[rows])) or 0}")
        self.command("delete_atoms group leaving compress no")

    def create(
        self, types: np.ndarray, positions: np.ndarray, diameters: np.ndarray, densities: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Make particles at rest of LIGGGHTS `types` (n,) at `positions` (n, 3) [m], given to all ranks (collective).

        `remove`, of none if need be, has to come before it, and `advance` with `first` after it.
        Returns: which of them are this rank's, and their rows.
        """
        before = self.count
        for kind, (x, y, z) in zip(types.tolist(), positions.tolist(), strict=True):
            self.command(f"create_atoms {kind} single {x!r} {y!r} {z!r} units box")
        rows = np.arange(before, self.count)
        numbers = {tuple(position): number for number, position in enumerate(positions.tolist())}
        mine = np.array([numbers[tuple(position)] for position in self.positions[rows].tolist()], dtype=int)
        self.radii[rows] = 0.5 * diameters[mine]
        self.densities[rows] = densities[mine]
        self.masses[rows] = np.pi / 6.0 * diameters[mine] ** 3 * (densities[mine] + self._carried)
        return mine, rows

    def ghost_positions(self) -> np.ndarray:
        """Centres [m] of this rank's particles and of its neighbours' near its border, shape (>= count, 3)."""
        rows = self.count + self._global("nghost", ctypes.c_int).value
        return self._view(self._library.lammps_extract_atom(self._lammps, b"x"), ctypes.c_double, rows, 3)

    def ghost_radii(self) -> np.ndarray:
        """Radii [m] that go with `ghost_positions`."""
        rows = self.count + self._global("nghost", ctypes.c_int).value
        return self._view(self._library.lammps_extract_atom(self._lammps, b"radius"), ctypes.c_double, rows)

    def advance(self, steps: int, first: bool = False) -> None:
        """Take `steps` DEM steps (collective); `first` also sets up, afterwards the run continues as it stands."""
        if self.remembers and steps:
            self.last_velocities[:] = self.velocities
        self.command(f"run {steps}" if first else f"run {steps} pre no post no")
        self._runs += 1
        if self._log and self._runs % _LOOK_EVERY == 0:
            shorten(self._log)

    def has_own_gravity(self) -> bool:
        """Has the deck a fix for gravity, by the name that fbcouple gives it (collective)?"""
        return bool(self._library.lammps_extract_fix(self._lammps, b"gravity", 0, 0, 0, 0))

    def has_temperatures(self) -> bool:
        """Has the deck a place for temperatures of the particles (collective)?"""
        return bool(self._library.lammps_extract_fix(self._lammps, b"Temp", 1, 1, 0, 0))

    def command(self, line: str) -> None:
        """Give one LIGGGHTS command; an error in it ends the process, the words are in its log."""
        self._library.lammps_command(self._lammps, line.encode())

    def read(self, deck: Path) -> None:
        """Give the commands of a further `deck` (collective)."""
        self._library.lammps_file(self._lammps, os.fsencode(deck))

    def close(self) -> None:
        """End LIGGGHTS (collective)."""
        self._library.lammps_close(self._lammps)

    def _read_bounds(self) -> np.ndarray:
        names = [f"sub{axis}{end}" for end in ("lo", "hi") for axis in "xyz"]
        return np.array([self._global(name, ctypes.c_double).value for name in names]).reshape(2, 3)

    def _global(self, name: str, kind: Any) -> Any:
        pointer = self._library.lammps_extract_global(self._lammps, name.encode())
        if not pointer:
            raise SolverError(f"LIGGGHTS has no global value {name}; fbcouple wants LIGGGHTS-PUBLIC 3.8")
        return kind.from_address(pointer)

    def _atoms(self, name: str, kind: Any, columns: int = 1) -> np.ndarray:
        return self._view(self._library.lammps_extract_atom(self._lammps, name.encode()), kind, self.count, columns)

    def _view(self, pointer: int | None, kind: Any, rows: int, columns: int = 1) -> np.ndarray:
        shape = (rows,) if columns == 1 else (rows, columns)
        if rows == 0:
            return np.empty(shape, dtype=kind)
        if not pointer:
            raise SolverError("LIGGGHTS has no such property of its particles")
        # A table of rows in LIGGGHTS is one block; its first row pointer is the start of the block.
        start = pointer if columns == 1 else ctypes.c_void_p.from_address(pointer).value
        assert start is not None
        key = start, kind, shape  # what was freed as whole numbers may come back as real ones
        if key not in self._views:
            if len(self._views) >= _VIEWS:
                self._views.clear()
            memory = _view_memory(start, rows * columns * ctypes.sizeof(kind), _WRITABLE)
            self._views[key] = np.frombuffer(memory, dtype=kind).reshape(shape)
        return self._views[key]


def _put_restart(deck: Path, restart: Path, path: Path, comm: MPI.Comm) -> Path:
    """Write `deck` to `path` with `restart` read in place of its data file, or of its empty box (collective)."""
    if not re.fullmatch(r"[\w./-]+", str(restart)):
        raise SolverError(f"{str(restart)!r} is no path that a LIGGGHTS deck can name")
    if comm.rank == 0:
        pattern = r"(?m)^(read_data|create_box)\b.*$"
        text, found = re.subn(pattern, f"read_restart    {restart}", deck.read_text(encoding="utf-8"))
        if found != 1:
            raise SolverError(f"{deck} has {found} lines that read or make a box, 1 is wanted to resume")
        path.write_text(text, encoding="utf-8")
    comm.Barrier()
    return path
