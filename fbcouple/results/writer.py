"""results.nc: everything measured in situ, opened by a bare `xarray.open_dataset`, SI units."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TextIO

import numpy as np
import xarray as xr

from fbcouple.geometry.grid import Grid
from fbcouple.geometry.ragged import Ragged
from fbcouple.machine.whole_files import replacing
from fbcouple.results.block_means import BLOCKS
from fbcouple.results.conventions import encode_coordinates, follow_conventions
from fbcouple.results.probes import ProbeSet, append_probes

STAGES = ("dem", "cfd", "map", "drag", "react", "average", "record", "wait")

# name -> unit, long name
MEANS: dict[str, tuple[str, str]] = {
    "solids_fraction": ("1", "time-mean solids fraction"),
    "solids_flux": ("kg m-2 s-1", "time-mean solids mass flux"),
    "solids_velocity": ("m s-1", "time-mean solids velocity, mass weighted"),
    "agitation": ("m2 s-2", "mean square of the particle velocity about the time mean"),
    "granular_temperature": ("m2 s-2", "third of the mean square particle velocity about the instantaneous cell mean"),
    "voidage": ("1", "time-mean voidage that the gas had"),
    "gas_velocity": ("m s-1", "time-mean interstitial gas velocity"),
    "gas_flux": ("m s-1", "time-mean superficial gas velocity, voidage times velocity"),
    "pressure": ("Pa", "time-mean dynamic pressure"),
    "gas_temperature": ("K", "time-mean temperature of the gas, weighted by voidage"),
    "solids_temperature": ("K", "time-mean temperature of the particles, weighted by mass"),
}
HISTORIES: dict[str, tuple[str, str]] = {
    "bed_height": ("m", "height above the floor of the uppermost layer whose mean solids fraction exceeds 0.2"),
    "pressure_drop": (
        "Pa",
        "dynamic pressure at the inlet against the outlet, mean since the last row (none at the start)",
    ),
    "averages_start": (
        "s",
        "begin of the time means, where the run finds it itself; none while the start-up is not seen to be over",
    ),
    "averages_error": (
        "1",
        "standard error of the mean averages.error_of over the mean, of maps root mean square; none before it is known",
    ),
    "expected_end": ("s", "time at which the means are expected to have the error averages.until_error"),
    "inlet_velocity": (
        "m s-1",
        "superficial velocity of the gas that came in by the inlet, mean since the last row; of ramps only",
    ),
    "gas_support": ("1", "upward force of the gas over the weight of the particles, mean since the last row"),
    "solids_volume": ("m3", "solids volume that the gas sees"),
    "solids_centre_z": ("m", "height of the particles' centre of mass above the floor"),
    "particles": ("1", "number of particles"),
    "particles_fed": ("1", "particles that came in by feeds up to now"),
    "particles_removed": ("1", "particles that left by outlets up to now"),
    "particles_owed": ("1", "particles that are due and wait for a free place in their feed"),
    "mass_fed": ("kg", "mass that came in by feeds up to now"),
    "mass_removed": ("kg", "mass that left by outlets up to now"),
    "heat_fed": ("J", "heat m c T that particles had as they came in, up to now"),
    "heat_removed": ("J", "heat m c T that particles had as they left, up to now"),
    "ledger_error": (
        "1",
        "particles that came and went against those that there are: missing ones, and the part of mass or momentum",
    ),
    "momentum_error": ("1", "largest imbalance of a step over its impulse since the last row"),
    "kinetic_energy": ("J", "kinetic energy of the particles' translation"),
    "gas_mass_error": (
        "1",
        "gas volume lost by continuity in a step, largest since the last row, over what the fastest inlet velocity "
        "brings in that time; where nothing ever comes in, over all the gas",
    ),
    "gas_inflow_error": (
        "1",
        "superficial velocity at the inlet against the case's, farthest off since the last row, over the fastest one",
    ),
    "displaced_gas_error": (
        "1",
        "gas volume that coupling steps not as long as the one before displaced too much or too little, added up cell "
        "by cell since the last row, over the solids volume",
    ),
    "gas_flux_error": (
        "1",
        "gas flux at a height (in a mesh of polyhedra: at the outlet) against continuity, farthest off, over the "
        "fastest inflow",
    ),
    "gas_backflow": (
        "1",
        "gas that came in by the outlets, over all that passed them, in and out, since the last row",
    ),
    "particles_at_outlet": ("1", "particles within a radius of the outlet, which is a wall for them"),
    "max_courant": ("1", "largest Courant number since the last row"),
    "min_voidage": ("1", "least voidage of a cell"),
    "cells_over_packed": ("1", "cells with a solids fraction above 0.74, the closest packing of equal spheres"),
    "max_overlap": ("1", "largest overlap of two particles over their mean diameter"),
    "substeps": ("1", "DEM steps in the last fluid step"),
    "mean_gas_temperature": ("K", "mean temperature of the gas, over its volume"),
    "mean_particle_temperature": ("K", "mean temperature of the particles, over their mass"),
    "min_temperature": ("K", "least temperature of a cell of gas or of a particle"),
    "max_temperature": ("K", "largest temperature of a cell of gas or of a particle"),
    "heat_given": ("W", "heat from the gas to the particles, mean since the last row"),
    "heat_by_walls": ("W", "heat that came to the gas by walls, mean since the last row"),
    "heat_by_inlets": (
        "W",
        "heat that came in by inlets, counted from the temperature of the inlet's gas, mean since the last row",
    ),
    "heat_by_outlets": ("W", "heat that came in by outlets, counted in the same way, mean since the last row"),
    "heat_by_contacts": ("W", "heat that came to the particles by contacts with walls, mean since the last row"),
    "heat_by_continuity": ("W", "heat that errors of the gas' continuity made, mean since the last row"),
    "heat_error": ("1", "largest error of a step's ledger of heat over the heat held, since the last row"),
}


HISTORY_VECTORS: dict[str, tuple[str, str]] = {
    "momentum_fed": ("kg m s-1", "momentum that particles had as they came in, up to now"),
    "momentum_removed": ("kg m s-1", "momentum that particles had as they left, up to now"),
}
HISTORIES_OF_SPECIES: dict[str, tuple[str, str]] = {
    "species_centre_z": ("m", "height of the centre of mass of each species above the floor; of mixtures only"),
}
HISTORIES_OF_OUTLETS: dict[str, tuple[str, str]] = {
    "outlet_backflow": (
        "1",
        "gas that came in by each outlet, over all that passed it, in and out, since the last row; of several only",
    ),
}
EXITS: dict[str, tuple[str, str]] = {
    "number": ("1", "number of a particle that left"),
    "entry_time": ("s", "time at which a particle that left had come in; 0 of those of the start"),
    "feed": ("1", "feed by which a particle that left had come in, counted from 1; 0: it was there at the start"),
    "time": ("s", "time at which a particle left"),
    "outlet": ("1", "outlet by which a particle left, counted from 1"),
    "mass": ("kg", "mass of a particle that left"),
}
"""Of each particle that left, in the order of leaving: variables `exit_...` over the dimension `exit`."""


def write_results(
    path: Path,
    grid: Grid,
    means: dict[str, np.ndarray],
    history: list[dict[str, Any]],
    attributes: dict[str, Any],
    snapshots: Sequence[tuple[float, np.ndarray]] = (),
    exits: Mapping[str, np.ndarray] | None = None,
    probes: Sequence[ProbeSet] = (),
    onset: np.ndarray | None = None,
    blocks: Mapping[str, Any] | None = None,
    centres: np.ndarray | None = None,
    volumes: np.ndarray | None = None,
    samples: np.ndarray | None = None,
    points: np.ndarray | None = None,
    faces: Ragged | None = None,
) -> None:
    """Write results.nc under a temporary name and move it into place. Raises OSError if the disk does not take it.

    `means`: name -> (z, y, x) or (component, z, y, x), `..._stderr` beside it; `history`: a row a record, `wall`
    in it the seconds of each stage since the row before, `tracked` particles by number; `snapshots`:
    time [s] and depth-mean voidage (z, x); `exits`: name of EXITS -> values of the particles that left;
    `probes`: sets of probes, whose rows are copied from their files; `onset`: rows (n, 2) of a
    packed bed's voidage and U_mf by the case's drag [m/s], none where no ramp is to be held against them; `blocks`:
    variables of the solids in each block of the averaging window, as `lay_out_blocks` gives them.

    Of a mesh of polyhedra the means are (cell,) or (component, cell), with the cells' `centres` (cell, 3) [m] and
    `volumes` (cell,) [m3], the mesh's `points` (node, 3) [m] and `faces`, a row a cell: how many it has, and of each
    how many points and which. `samples` (z, y, x) are the cells at the places of `grid`, -1 outside.
    """
    data: dict[str, Any] = {}
    axes = ("z", "y", "x") if samples is None else ("cell",)
    for name, values in means.items():
        unit, text = MEANS[name.removesuffix("_stderr")]
        dims = axes if values.ndim == len(axes) else ("component", *axes)
        words = f"standard error by block averaging of the {text}" if name.endswith("_stderr") else text
        data[name] = (dims, values, {"units": unit, "long_name": words})
    data |= _lay_out_histories(history) | dict(blocks or {})
    for name, values in (exits or {}).items():
        unit, text = EXITS[name]
        data[f"exit_{name}"] = ("exit", values, {"units": unit, "long_name": text})
    walls = np.array([[row["wall"][stage] for stage in STAGES] for row in history]).reshape(-1, len(STAGES))
    data["wall_seconds"] = (
        ("time", "stage"),
        walls,
        {"units": "s", "long_name": "wall time of the slowest rank since the last row"},
    )
    coordinates: dict[str, Any] = {
        "stage": ("stage", list(STAGES), {"long_name": "stage of a step"}),
        "component": ("component", ["x", "y", "z"], {"long_name": "component of a vector"}),
    }
    for axis, name in enumerate("xyz"):
        coordinates[name] = (name, grid.centres(axis), {"units": "m", "long_name": f"cell centre {name}"})
    if centres is not None:
        coordinates |= _lay_out_cells(centres, volumes)
        about = {"units": "1", "long_name": "cell at the place of the regular grid, -1 outside of the mesh"}
        data["sampled_cell"] = (("z", "y", "x"), samples, about)
    if onset is not None and len(onset):
        about = {"units": "1", "long_name": "voidage of a packed bed"}
        coordinates["packed_voidage"] = ("packed_voidage", onset[:, 0], about)
        about = {"units": "m s-1", "long_name": "minimum fluidization velocity by the case's drag at that voidage"}
        data["drag_onset_velocity"] = ("packed_voidage", onset[:, 1], about)
    encoding: dict[str, Any] = {name: {"zlib": True, "complevel": 1} for name in BLOCKS if name in data}
    if points is not None and faces is not None:
        data |= _lay_out_mesh(points, faces)
        encoding["mesh_faces"] = {"zlib": True, "complevel": 1}
    times = np.array([row["time"] for row in history], dtype=float)
    coordinates["time"] = ("time", times, {"units": "s", "long_name": "simulated time"})
    if snapshots:
        about = {"units": "1", "long_name": "depth-mean voidage that the gas had at that time"}
        fields = np.array([field for _, field in snapshots], dtype=np.float32)
        data["voidage_snapshots"] = (("snapshot_time", "z", "x"), fields, about)
        times = np.array([time for time, _ in snapshots])
        coordinates["snapshot_time"] = ("snapshot_time", times, {"units": "s", "long_name": "time of a snapshot"})
        encoding["voidage_snapshots"] = {"zlib": True, "complevel": 1}
    write_dataset(path, follow_conventions(xr.Dataset(data, coordinates, attributes)), encoding, probes)


def _lay_out_histories(history: list[dict[str, Any]]) -> dict[str, Any]:
    """What the rows of the history hold, over `time`, vectors over `component`, mixtures over `species` and several
    outlets of the gas over `outlet`, too."""
    data: dict[str, Any] = {}
    first = history[0] if history else {}
    for entries, dims in (
        (HISTORIES, ("time",)),
        (HISTORY_VECTORS, ("time", "component")),
        (HISTORIES_OF_SPECIES, ("time", "species")),
        (HISTORIES_OF_OUTLETS, ("time", "outlet")),
    ):
        for name in [name for name in entries if name in first]:
            unit, text = entries[name]
            data[name] = (dims, np.array([row[name] for row in history]), {"units": unit, "long_name": text})
    if "species_centre_z" in first:
        numbers = np.arange(1, 1 + len(first["species_centre_z"]))
        data["species"] = ("species", numbers, {"long_name": "number of the species, in the order of the case"})
    if "outlet_backflow" in first:
        numbers = np.arange(1, 1 + len(first["outlet_backflow"]))
        data["outlet"] = ("outlet", numbers, {"long_name": "number of the outlet of the gas, in the order of the case"})
    return data | (_lay_out_tracks(history) if "tracked" in first else {})


def _lay_out_cells(centres: np.ndarray, volumes: np.ndarray | None) -> dict[str, Any]:
    """Centres and volumes of the cells of a mesh."""
    found = {"cell_volume": ("cell", volumes, {"units": "m3", "long_name": "volume of the cell"})}
    for axis, name in enumerate("xyz"):
        about = {"units": "m", "long_name": f"{name} of the cell's centre"}
        found[f"cell_{name}"] = ("cell", centres[:, axis], about)
    return found


def _lay_out_mesh(points: np.ndarray, faces: Ragged) -> dict[str, Any]:
    """The mesh itself."""
    entries = "of each cell its number of faces, of each its number of points, and these"
    starts = "first entry of each cell in mesh_faces, and one past the last"
    return {
        "mesh_points": (("mesh_node", "component"), points, {"units": "m", "long_name": "points of the mesh"}),
        "mesh_faces": ("mesh_entry", faces.values.astype(np.int32), {"units": "1", "long_name": entries}),
        "mesh_starts": ("mesh_row", faces.starts, {"units": "1", "long_name": starts}),
    }


def _lay_out_tracks(history: list[dict[str, Any]]) -> dict[str, Any]:
    """Positions and velocities (time, tracked, component) of the tracked particles, and their numbers."""
    numbers = list(history[0]["tracked"])
    motion = np.array([[row["tracked"][number] for number in numbers] for row in history])
    dims = ("time", "tracked", "component")
    return {
        "tracked": ("tracked", [int(number) for number in numbers], {"long_name": "number of a tracked particle"}),
        "tracked_position": (dims, motion[..., :3], {"units": "m", "long_name": "centre of a tracked particle"}),
        "tracked_velocity": (dims, motion[..., 3:], {"units": "m s-1", "long_name": "velocity of a tracked particle"}),
    }


def write_dataset(path: Path, dataset: xr.Dataset, encoding: dict[str, Any], probes: Sequence[ProbeSet] = ()) -> None:
    """Write `dataset` and `probes` as netCDF, all of it or nothing. Raises: OSError."""
    try:
        with replacing(path) as fresh:
            dataset.to_netcdf(fresh, encoding=encode_coordinates(dataset, encoding))
            append_probes(fresh, probes)
    except (OSError, RuntimeError) as error:  # the latter are the netCDF library's
        raise OSError(f"{error}; is the disk full?") from error


def append_line(file: TextIO, row: dict[str, Any]) -> None:
    """Append `row` to the line log, with a checksum over the rest of the line."""
    text = json.dumps(row)
    file.write(f'{text[:-1]}, "crc32": {zlib.crc32(text.encode())}}}\n')
    file.flush()


def read_line(line: str) -> dict[str, Any] | None:
    """The row of a line of the log, or None if the line is not whole."""
    text, mark, checksum = line.rstrip("\n").rpartition(', "crc32": ')
    if not mark or not checksum.endswith("}") or checksum[:-1] != str(zlib.crc32(f"{text}}}".encode())):
        return None
    return json.loads(f"{text}}}")


def read_log(path: Path) -> list[dict[str, Any]]:
    """The rows of a line log up to the first line that is not whole."""
    rows = []
    for line in path.read_text(encoding="utf-8").splitlines(keepends=True):
        row = read_line(line)
        if row is None:
            break
        rows.append(row)
    return rows
