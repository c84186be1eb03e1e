"""What a file of start positions holds: centres, and what else it says of the particles.

It is a table (CSV), a text dump or a data file of LIGGGHTS or LAMMPS, told apart by what stands in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.input_files.data_file import read_data
from fbcouple.input_files.dump_file import read_dump
from fbcouple.input_files.liggghts_files import POSITIONS, SPINS, SUFFIXES, VELOCITIES, find_format
from fbcouple.input_files.number_table import Form, Table, read_table
from fbcouple.input_files.units import DENSITIES, LENGTHS, SPEEDS

ENDINGS = (".csv", *SUFFIXES)
"""What a file of start positions is called."""
RATES = {"rad/s": 1.0, "1/s": 1.0, "rad s-1": 1.0, "s-1": 1.0}
KELVIN = {"K": 1.0}
LARGEST = 2_000_000_000
"""Bytes that a file of start positions may have."""
SAME_SIZE = 1e-5
"""Relative difference that two texts of one size may have: programs write six digits."""


def _name_parts(columns: tuple[str, ...], *vectors: str) -> dict[str, str]:
    """How programs (ParaView) head the three parts of a vector."""
    parts = [(part, column) for names in ("012", "xyz") for part, column in zip(names, columns, strict=True)]
    return {f"{vector}{sign}{part}": column for vector in vectors for sign in ":_" for part, column in parts}


_UNCLEAR = {
    "phase id": "MFIX writes so, and its y points up where here z does; name the columns by what they are here, as a "
    "rule `x,z,y,kind,diameter,density,vx,vz,vy` (kinds as the case numbers them)",
    "type": "if it is the kind of the particle, as the case numbers them, call it `kind`, else remove it",
    "mass": "the mass of a particle follows from `diameter` and `density`; give these",
    **{word: "if it is the diameter call it `diameter`, else remove it" for word in ("d", "dp", "size", "d p")},
    **{word: "if it is the radius of the particle call it `radius`, else remove it" for word in ("r", "rad", "rp")},
    **{word: "if it is the density of the particle call it `density`, else remove it" for word in ("rho", "rho p")},
    **{
        word: f"if it is the velocity along {axis} call it `v{axis}`, else remove it"
        for axis, words in zip("xyz", (("u", "ux"), ("v", "uy"), ("w", "uz")), strict=True)
        for word in words
    },
}
FORM = Form(
    columns={
        **dict.fromkeys(POSITIONS, LENGTHS),
        **dict.fromkeys(VELOCITIES, SPEEDS),
        **dict.fromkeys(SPINS, RATES),
        "radius": LENGTHS,
        "diameter": LENGTHS,
        "density": DENSITIES,
        "temperature": KELVIN,
        "kind": {},
    },
    needed=POSITIONS,
    rows="particles",
    largest=LARGEST,
    aliases=_name_parts(POSITIONS, "points", "coords", "position")
    | _name_parts(VELOCITIES, "v", "velocity")
    | {"radii": "radius", "diameters": "diameter"},
    unclear=_UNCLEAR,
)


@dataclass(frozen=True)
class StartFile:
    """Of each particle: centre [m], velocity [m/s] and angular velocity [rad/s] (n, 3), kind from 1, LIGGGHTS' type,
    diameter [m], density [kg m-3], temperature [K] (n,).

    None where the file does not say it; `unread`: heads of columns that are not looked at.
    """

    positions: np.ndarray
    velocities: np.ndarray | None = None
    spins: np.ndarray | None = None
    kinds: np.ndarray | None = None
    types: np.ndarray | None = None
    diameters: np.ndarray | None = None
    densities: np.ndarray | None = None
    temperatures: np.ndarray | None = None
    unread: tuple[str, ...] = ()


def read_start(path: Path, step: int | None = None) -> StartFile:
    """Read a file of start positions: x, y, z, and what else it says of the particles; of a dump the time `step`.

    Raises: CaseError (one text, without the key) with what was found in the file that cannot serve.
    """
    try:
        stat = path.stat()
    except OSError:
        return _read(path, step)  # says why
    return _read_once(path.absolute(), step, stat.st_mtime_ns, stat.st_size, stat.st_ino)


@lru_cache(maxsize=1)
def _read_once(path: Path, step: int | None, *version: int) -> StartFile:
    return _read(path, step)


def _read(path: Path, step: int | None) -> StartFile:
    table, name = _read_columns(path, step), path.name
    columns = table.columns
    return StartFile(
        np.stack([columns[axis] for axis in POSITIONS], axis=1),
        _join_vector(name, columns, VELOCITIES),
        _join_vector(name, columns, SPINS),
        _require_whole(name, "kind", columns.get("kind")),
        _require_whole(name, "type", columns.get("type")),
        _find_diameters(name, columns),
        _require_positive(name, "density", columns.get("density")),
        _require_positive(name, "temperature", columns.get("temperature")),
        table.unread,
    )


def _read_columns(path: Path, step: int | None) -> Table:
    try:
        written = find_format(path) if path.is_file() and path.stat().st_size <= LARGEST else None
    except OSError:
        written = None  # the table's reader says why
    if step is not None and written != "dump":
        raise CaseError([f"{path.name} is no dump and has no time steps; remove particles.positions_step."])
    if written is None:
        return read_table(path, FORM)
    return read_dump(path, step) if written == "dump" else read_data(path)


def _join_vector(name: str, columns: dict[str, np.ndarray], parts: tuple[str, ...]) -> np.ndarray | None:
    found = [part for part in parts if part in columns]
    if found and len(found) < len(parts):
        raise CaseError(
            [f"{name} has not all of the columns {', '.join(parts[:-1])} and {parts[-1]}; give all three or none."]
        )
    return np.stack([columns[part] for part in parts], axis=1) if found else None


def _require_whole(name: str, column: str, values: np.ndarray | None) -> np.ndarray | None:
    if values is None:
        return None
    if (broken := np.flatnonzero((values < 1) | (values != np.floor(values)) | (values > 1e6))).size:
        text = f"{name}: the {column} of particle {broken[0] + 1} is no whole number from 1 ({values[broken[0]]:g})"
        raise CaseError([f"{text}; fix it."])
    return values.astype(int)


def _find_diameters(name: str, columns: dict[str, np.ndarray]) -> np.ndarray | None:
    diameters = _require_positive(name, "diameter", columns.get("diameter"))
    radii = _require_positive(name, "radius", columns.get("radius"))
    if diameters is None or radii is None:
        return diameters if radii is None else 2.0 * radii
    apart = np.flatnonzero(np.abs(diameters - 2.0 * radii) > SAME_SIZE * diameters)
    if apart.size:
        row = apart[0]
        text = f"{name}: particle {row + 1} has the diameter {diameters[row]:g} and the radius {radii[row]:g} m"
        raise CaseError([f"{text}; fix it, or give one of the two columns."])
    return diameters


def _require_positive(name: str, column: str, values: np.ndarray | None) -> np.ndarray | None:
    if values is not None and (broken := np.flatnonzero(values <= 0.0)).size:
        text = f"{name}: the {column} of particle {broken[0] + 1} is {values[broken[0]]:g}"
        raise CaseError([f"{text}, above 0 is allowed; fix it."])
    return values
