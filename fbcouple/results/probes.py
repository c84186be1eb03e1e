"""Probes: a row of numbers a sample in a file of their own while the run goes on, and variables of results.nc.

The file grows on the disk, and nothing of it is held in memory: rows are appended, and copied block by block.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

if TYPE_CHECKING:  # a case names its probes without the readers of results
    import xarray as xr
    from netCDF4 import Dataset

# name -> unit, long name
OF_GAS: dict[str, tuple[str, str]] = {
    "pressure": ("Pa", "dynamic pressure of the gas at the point"),
    "voidage": ("1", "voidage that the gas had in the cell"),
    "gas_velocity": ("m s-1", "interstitial gas velocity in the cell"),
    "gas_flux": ("m s-1", "superficial gas velocity in the cell, voidage times velocity"),
    "gas_temperature": ("K", "temperature of the gas in the cell"),
}
OF_SOLIDS: dict[str, tuple[str, str]] = {
    "solids_fraction": ("1", "solids fraction of the cell"),
    "solids_velocity": ("m s-1", "solids velocity of the cell, mass weighted; none where no particle is"),
    "solids_flux": ("kg m-2 s-1", "solids mass flux in the cell"),
    "granular_temperature": (
        "m2 s-2",
        "third of the mean square particle velocity about the mean of the cell; none where no particle is",
    ),
    "solids_temperature": ("K", "temperature of the particles in the cell, mass weighted; none where no particle is"),
}
OF_HEAT = ("gas_temperature", "solids_temperature")
"""Quantities of a case with heat."""
PROBED = OF_GAS | OF_SOLIDS
VECTORS = ("gas_velocity", "gas_flux", "solids_velocity", "solids_flux")
COPIED = 1 << 20
"""Bytes that are copied at a time."""


def count_components(quantity: str) -> int:
    """Numbers of a quantity at a point."""
    return 3 if quantity in VECTORS else 1


def count_columns(quantities: Sequence[str]) -> int:
    """Numbers of a set at each of its points."""
    return sum(map(count_components, quantities))


@dataclass
class Rows:
    """The file of a set: rows of float64, the time [s] and each quantity's values (points, components), as many as
    `count`; what lies behind these is of a run that was stopped after its checkpoint."""

    path: Path
    columns: int
    count: int = 0
    checksum: int = 0
    """CRC-32 of the rows."""
    _file: BinaryIO | None = None

    def append(self, time: float, values: np.ndarray) -> None:
        """Add a row. Raises: OSError."""
        if self._file is None:
            self._file = self._open()
        data = np.concatenate([[time], values]).tobytes()
        self._file.write(data)
        self._file.flush()
        self.count, self.checksum = self.count + 1, zlib.crc32(data, self.checksum)

    def _open(self) -> BinaryIO:
        self.path.parent.mkdir(exist_ok=True)
        self.path.touch()
        file = self.path.open("r+b")
        file.truncate(self.count * self._width)
        file.seek(0, 2)
        return file

    @property
    def _width(self) -> int:
        return 8 * (1 + self.columns)

    def is_whole(self) -> bool:
        """Are the rows on the disk those of the checksum?"""
        found = 0
        if self.count:
            try:
                for block in self.read():
                    found = zlib.crc32(block.tobytes(), found)
            except OSError:
                return False
        return found == self.checksum

    def read(self) -> Iterator[np.ndarray]:
        """The rows (n, 1 + columns), a block at a time. Raises: OSError if the file has fewer."""
        step, left = max(COPIED // self._width, 1), self.count
        with self.path.open("rb") as file:
            while left:
                block = np.fromfile(file, float, min(step, left) * (1 + self.columns))
                if block.size < min(step, left) * (1 + self.columns):
                    raise OSError(f"{self.path} ends before its last row")
                left -= min(step, left)
                yield block.reshape(-1, 1 + self.columns)


@dataclass(frozen=True)
class ProbeSet:
    """What results.nc has of a set: its name, points (n, 3) [m], quantities, and rows."""

    name: str
    points: np.ndarray
    quantities: tuple[str, ...]
    rows: Rows


def name_variable(name: str, quantity: str) -> str:
    """The variable of results.nc that has a quantity of the set `name`, or its `time`, or the `x`, `y` or `z` of its
    points."""
    return f"probe_{name}_{quantity}"


def find_dimensions(name: str, quantity: str) -> tuple[str, ...]:
    """Dimensions of such a variable of a quantity."""
    dims = name_variable(name, "time"), name_variable(name, "point")
    return (*dims, "component") if quantity in VECTORS else dims


def append_probes(path: Path, sets: Sequence[ProbeSet]) -> None:
    """Add the variables of `sets` to the netCDF file `path`, which has the dimension `component`. Raises: OSError."""
    if not sets:
        return
    from netCDF4 import Dataset  # noqa: PLC0415  (as above)

    with Dataset(str(path), "a") as file:
        for probes in sets:
            _append(file, probes)


def _append(file: Dataset, probes: ProbeSet) -> None:
    name, count = probes.name, probes.rows.count
    time, point = name_variable(name, "time"), name_variable(name, "point")
    file.createDimension(time, count or None)  # none: of no length yet
    file.createDimension(point, len(probes.points))
    coordinates = [name_variable(name, axis) for axis in "xyz"]
    for axis, variable_name in enumerate(coordinates):
        _create(file, variable_name, (point,), ("m", f"{'xyz'[axis]} of the point"))[:] = probes.points[:, axis]
    variables = [_create(file, time, (time,), ("s", "time of a sample"))]
    for quantity in probes.quantities:
        dims = find_dimensions(name, quantity)
        variables.append(_create(file, name_variable(name, quantity), dims, PROBED[quantity]))
        variables[-1].setncatts({"coordinates": " ".join(coordinates), "cell_methods": f"{time}: point"})
    start = 0
    for rows in probes.rows.read() if count else ():
        end, column = start + len(rows), 0
        for variable in variables:
            shape = variable.shape[1:]
            width = int(np.prod(shape))
            variable[start:end] = rows[:, column : column + width].reshape(len(rows), *shape)
            column += width
        start = end


def _create(file: Dataset, name: str, dims: tuple[str, ...], about: tuple[str, str]) -> Any:
    variable = file.createVariable(name, "f8", dims, fill_value=False)
    variable.setncatts({"units": about[0], "long_name": about[1]})
    return variable


@dataclass(frozen=True)
class Probed:
    """A set as results.nc has it: `times` (t,) [s], `points` (n, 3) [m], and of each quantity the values (t, n) or (t,
    n, 3); `is_line`: whether its points are on a line, in their order."""

    name: str
    is_line: bool
    times: np.ndarray
    points: np.ndarray
    values: dict[str, np.ndarray]

    @property
    def distances(self) -> np.ndarray:
        """Of each point from the first one [m], (n,)."""
        return np.linalg.norm(self.points - self.points[0], axis=1)


def read_probes(data: xr.Dataset, case: Mapping[str, Any]) -> list[Probed]:
    """The sets of probes that the `case` of a results.nc asks for and its `data` has."""
    sets = []
    for table in list_tables(case):
        name = table["name"]
        if name_variable(name, "time") not in data:
            continue
        points = np.column_stack([data[name_variable(name, axis)].values for axis in "xyz"])
        values = {q: data[name_variable(name, q)].values for q in table["quantities"]}
        sets.append(
            Probed(name, table.get("line") is not None, data[name_variable(name, "time")].values, points, values)
        )
    return sets


def list_tables(case: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The tables [[output.probes]] of a case."""
    return list((case.get("output") or {}).get("probes") or ())
