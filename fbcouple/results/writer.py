"""results.nc: everything measured in situ, opened by a bare `xarray.open_dataset`, SI units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fbcouple.geometry.grid import Grid
from fbcouple.geometry.ragged import Ragged
from fbcouple.machine.whole_files import replacing
from fbcouple.results.block_means import BLOCKS
from fbcouple.results.conventions import encode_coordinates, follow_conventions
from fbcouple.results.probes import ProbeSet, append_probes
from fbcouple.results.variables import (
    EXITS,
    HISTORIES,
    HISTORIES_OF_OUTLETS,
    HISTORIES_OF_SPECIES,
    HISTORY_VECTORS,
    MEANS,
    STAGES,
)

_PLACES = "x", "y", "z", "cell_x", "cell_y", "cell_z", "cell_volume"
COORDINATES = "time", "stage", "component", *_PLACES, "packed_voidage", "drag_onset_velocity", "snapshot_time"
"""Names that are coordinates of the dataset; the others are its variables."""
PACKED = *BLOCKS, "mesh_faces", "voidage_snapshots"
"""Variables that are compressed."""


@dataclass(frozen=True)
class Extras:
    """What some runs have beside means and history: `snapshots`, time [s] and depth-mean voidage (z, x); `exits`, name
    of EXITS -> values of the particles that left; `probes`, sets whose rows are copied from their files; `onset`, rows
    (n, 2) of a packed bed's voidage and U_mf by the case's drag [m/s], of ramps; `blocks`, variables of the solids in
    each block of the averaging window, as `lay_out_blocks` gives them."""

    snapshots: Sequence[tuple[float, np.ndarray]] = ()
    exits: Mapping[str, np.ndarray] = field(default_factory=dict)
    probes: Sequence[ProbeSet] = ()
    onset: np.ndarray | None = None
    blocks: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class MeshTable:
    """Cells of a mesh of polyhedra: `centres` (cell, 3) [m] and `volumes` (cell,) [m3]; `samples` (z, y, x), the cells
    at the places of the grid, -1 outside; the mesh's `points` (node, 3) [m] and `faces`, a row a cell: how many it has,
    and of each how many points and which."""

    centres: np.ndarray
    volumes: np.ndarray
    samples: np.ndarray
    points: np.ndarray | None = None
    faces: Ragged | None = None


def write_results(
    path: Path,
    grid: Grid,
    means: dict[str, np.ndarray],
    history: list[dict[str, Any]],
    attributes: dict[str, Any],
    extras: Extras | None = None,
    mesh: MeshTable | None = None,
) -> None:
    """Write results.nc under a temporary name and move it into place. Raises OSError if the disk does not take it.

    `means`: name -> (z, y, x) or (component, z, y, x), of a `mesh` (cell,) or (component, cell), `..._stderr` beside
    it; `history`: a row a record, `wall` in it the seconds of each stage since the row before, `tracked` particles by
    number.
    """
    extras = extras or Extras()
    data = _lay_out_means(means, ("z", "y", "x") if mesh is None else ("cell",))
    data |= _lay_out_histories(history) | _lay_out_stages(history) | dict(extras.blocks)
    data |= _lay_out_exits(extras.exits) | _lay_out_snapshots(extras.snapshots) | _lay_out_onset(extras.onset)
    data |= _lay_out_axes(grid) | (_lay_out_mesh(mesh) if mesh else {})
    times = np.array([row["time"] for row in history], dtype=float)
    data["time"] = ("time", times, {"units": "s", "long_name": "simulated time"})
    coordinates = {name: data.pop(name) for name in COORDINATES if name in data}
    encoding: dict[str, Any] = {name: {"zlib": True, "complevel": 1} for name in PACKED if name in data}
    write_dataset(path, follow_conventions(xr.Dataset(data, coordinates, attributes)), encoding, extras.probes)


def _lay_out_means(means: dict[str, np.ndarray], axes: tuple[str, ...]) -> dict[str, Any]:
    data = {}
    for name, values in means.items():
        unit, text = MEANS[name.removesuffix("_stderr")]
        dims = axes if values.ndim == len(axes) else ("component", *axes)
        words = f"standard error by block averaging of the {text}" if name.endswith("_stderr") else text
        data[name] = (dims, values, {"units": unit, "long_name": words})
    return data


def _lay_out_axes(grid: Grid) -> dict[str, Any]:
    data: dict[str, Any] = {"component": ("component", ["x", "y", "z"], {"long_name": "component of a vector"})}
    for axis, name in enumerate("xyz"):
        data[name] = (name, grid.centres(axis), {"units": "m", "long_name": f"cell centre {name}"})
    return data


def _lay_out_stages(history: list[dict[str, Any]]) -> dict[str, Any]:
    walls = np.array([[row["wall"][stage] for stage in STAGES] for row in history]).reshape(-1, len(STAGES))
    about = {"units": "s", "long_name": "wall time of the slowest rank since the last row"}
    return {
        "wall_seconds": (("time", "stage"), walls, about),
        "stage": ("stage", list(STAGES), {"long_name": "stage of a step"}),
    }


def _lay_out_exits(exits: Mapping[str, np.ndarray]) -> dict[str, Any]:
    about = {name: {"units": EXITS[name][0], "long_name": EXITS[name][1]} for name in exits}
    return {f"exit_{name}": ("exit", values, about[name]) for name, values in exits.items()}


def _lay_out_snapshots(snapshots: Sequence[tuple[float, np.ndarray]]) -> dict[str, Any]:
    if not snapshots:
        return {}
    about = {"units": "1", "long_name": "depth-mean voidage that the gas had at that time"}
    fields = np.array([field for _, field in snapshots], dtype=np.float32)
    times = np.array([time for time, _ in snapshots])
    return {
        "voidage_snapshots": (("snapshot_time", "z", "x"), fields, about),
        "snapshot_time": ("snapshot_time", times, {"units": "s", "long_name": "time of a snapshot"}),
    }


def _lay_out_onset(onset: np.ndarray | None) -> dict[str, Any]:
    if onset is None or not len(onset):
        return {}
    text = "minimum fluidization velocity by the case's drag at that voidage"
    packed = {"units": "1", "long_name": "voidage of a packed bed"}
    return {
        "packed_voidage": ("packed_voidage", onset[:, 0], packed),
        "drag_onset_velocity": ("packed_voidage", onset[:, 1], {"units": "m s-1", "long_name": text}),
    }


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


def _lay_out_mesh(mesh: MeshTable) -> dict[str, Any]:
    """Centres and volumes of the cells of a mesh, where they are sampled, and the mesh itself."""
    about = {"units": "1", "long_name": "cell at the place of the regular grid, -1 outside of the mesh"}
    data: dict[str, Any] = {
        "cell_volume": ("cell", mesh.volumes, {"units": "m3", "long_name": "volume of the cell"}),
        "sampled_cell": (("z", "y", "x"), mesh.samples, about),
    }
    for axis, name in enumerate("xyz"):
        about = {"units": "m", "long_name": f"{name} of the cell's centre"}
        data[f"cell_{name}"] = ("cell", mesh.centres[:, axis], about)
    if mesh.points is not None and mesh.faces is not None:
        entries = "of each cell its number of faces, of each its number of points, and these"
        starts = "first entry of each cell in mesh_faces, and one past the last"
        about = {"units": "m", "long_name": "points of the mesh"}
        data["mesh_points"] = (("mesh_node", "component"), mesh.points, about)
        values = mesh.faces.values.astype(np.int32)
        data["mesh_faces"] = ("mesh_entry", values, {"units": "1", "long_name": entries})
        data["mesh_starts"] = ("mesh_row", mesh.faces.starts, {"units": "1", "long_name": starts})
    return data


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
