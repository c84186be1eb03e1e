"""Results that are small: means averaged over the depth, histories of few rows, and of each replica enough to pool it
again with others."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fbcouple.results.block_means import BLOCKS, SAMPLES, START, has_blocks, pair_blocks
from fbcouple.results.conventions import STANDARD_ERROR, follow_conventions
from fbcouple.results.depth_means import depth_average
from fbcouple.results.histories import RULES, find_rule, join_rows
from fbcouple.results.pooling import pool
from fbcouple.results.reader import sample
from fbcouple.results.replicas import OF_EACH, REDUCED, Replica
from fbcouple.results.told import REPLICAS_OF
from fbcouple.results.variables import MEANS
from fbcouple.results.weights import OF_SOLIDS, find_weight
from fbcouple.results.writer import write_dataset

ROWS = 200
"""Rows of a history that are kept."""
JOINED = "joined_rows"
"""Attribute: how many rows of the run each row of a history stands for."""
MOST_BLOCKS = 20
"""Blocks of the averaging window of a replica that are kept."""
_BITS, _ERROR_BITS, _BLOCK_BITS = 16, 7, 5
"""Bits of the fraction that are kept of means, of standard errors and of blocks: they are then right to 8e-6, 0.4 and
1.6 %, each with an error of its own."""
_PACKED = 1000
"""Numbers from which a variable is packed: what tells of the packing takes some kB."""
_EXACT = ("solids_volume", "particles", "particles_fed", "particles_removed", "particles_owed")
"""Histories that are kept in double precision: what changes of them, and may not, is less than a single one tells."""
_KEPT = ("stage", "component", "species", "outlet")


def reduce(replica: Replica) -> Replica:
    """The replica with its means averaged over the depth, as figures average them, on a mesh of one cell in y.

    Quantities of particles are averaged with the solids, temperatures with the mass or the voidage, and standard errors
    as what they are of: they are then bounds, as if all errors along the depth were one.
    """
    if replica.data.attrs.get(REDUCED):
        return replica
    data = sample(replica.data)
    case = replica.case
    flat = {
        name: _flatten(data, case, name) for mean in MEANS for name in (mean, f"{mean}{STANDARD_ERROR}") if name in data
    }
    middle = float(0.5 * (data["y"].values[0] + data["y"].values[-1]))
    axes = {"x": data["x"], "z": data["z"], "y": ("y", [middle], data["y"].attrs), "component": data["component"]}
    grid = {name: field.expand_dims(y=[middle]).transpose(..., "z", "y", "x") for name, field in flat.items()}
    kept = {name: grid[name].assign_attrs(data[name].attrs) for name in grid}
    made = xr.Dataset(kept, attrs=data.attrs | {REDUCED: 1}).assign_coords(axes)
    made = _name_cells(made, data) if "inside" in data.coords else made
    thin = _thin(replica.data)
    coords = {name: replica.data[name] for name in _KEPT if name in replica.data.coords}
    blocks = pair_blocks(replica.data[[SAMPLES, START, *BLOCKS]], MOST_BLOCKS) if has_blocks(replica.data) else {}
    made = made.assign(thin.data_vars).assign(blocks).assign_attrs(thin.attrs)
    return replace(replica, data=made.assign_coords(coords | {"time": thin["time"]}))


def _flatten(data: xr.Dataset, case: Mapping[str, Any], name: str) -> xr.DataArray:
    field, mean = data[name].astype(float), name.removesuffix(STANDARD_ERROR)
    # The velocity as figures have it: by the solids, which is by the mass but where densities differ.
    weight = find_weight(data, case, OF_SOLIDS[0] if mean == "solids_velocity" else mean)
    if weight is None:
        return depth_average(field).drop_vars("inside", errors="ignore")
    total = weight.sum("y")
    flat = (weight * field.where(weight > 0.0, 0.0)).sum("y", skipna=name == mean) / total.where(total > 0.0)
    return flat.drop_vars("inside", errors="ignore")


def _name_cells(made: xr.Dataset, data: xr.Dataset) -> xr.Dataset:
    """Of a mesh: means over the places inside of it, and at each place the number of its cell."""
    inside = data["inside"].any("y").expand_dims(y=made["y"].values).transpose("z", "y", "x").values
    numbers = np.where(inside, np.cumsum(inside).reshape(inside.shape) - 1, -1)
    found: dict[str, Any] = {"sampled_cell": (("z", "y", "x"), numbers, {"units": "1", "long_name": "cell of a place"})}
    for name, field in made.data_vars.items():
        values = field.transpose(..., "z", "y", "x").values[..., inside]
        dims = ("cell",) if values.ndim == 1 else ("component", "cell")
        found[str(name)] = (dims, values, field.attrs)
    return xr.Dataset(found, {axis: made[axis] for axis in (*"xyz", "component")}, made.attrs)


def _thin(data: xr.Dataset) -> xr.Dataset:
    """At most `ROWS` rows of each history, and the first: rows between are joined as `RULES` say."""
    count = data.sizes.get("time", 0)
    if not count:
        return xr.Dataset(coords={"time": data["time"]}, attrs={JOINED: 1})
    every = max(-(-(count - 1) // ROWS), 1)
    begins = np.array([0, *range(1, count, every)])
    ends = np.append(begins[1:], count) - 1
    found = {}
    for name in [name for name in RULES if name in data]:
        values = data[name].transpose("time", ...)
        rows = values.values.astype(float)
        joined = join_rows(find_rule(name, data).rows, rows, begins, rows[0])
        found[name] = (values.dims, joined, data[name].attrs)
    return xr.Dataset(found, {"time": ("time", data["time"].values[ends], data["time"].attrs)}, {JOINED: every})


def pool_reduced(replicas: Sequence[Replica], defaults: Mapping[str, Any] | None = None) -> xr.Dataset:
    """As `pool`, of reduced replicas, with what is needed to pool them again."""
    small = [reduce(one) for one in replicas]
    pooled = pool(small, defaults)
    told = [one.about | {"windows": one.windows} for one in small]
    found: dict[str, Any] = {}
    for name in [name for mean in MEANS for name in (mean, f"{mean}{STANDARD_ERROR}") if name in pooled]:
        if len(small) > 1 and all(name in one.data for one in small):
            values = np.array([one.data[name].values for one in small])
            about = {"units": pooled[name].attrs.get("units", "1"), "long_name": f"{name} of each replica"}
            found[f"{OF_EACH}{name}"] = (("replica", *small[0].data[name].dims), values, about)
    return pooled.assign(found).assign_attrs({REDUCED: 1, REPLICAS_OF: json.dumps(told)})


def write(path: Path, data: xr.Dataset) -> None:
    """Write a pooled dataset, packed; a reduced one to `_BITS`.

    Raises: OSError.
    """
    is_reduced = bool(data.attrs.get(REDUCED))
    encoding: dict[str, Any] = {}
    data = data.copy()
    for name in map(str, data.data_vars):
        if data[name].ndim and data[name].dtype.kind == "f":
            encoding[name] = {}
            if data[name].size > _PACKED:
                encoding[name] = {"zlib": True, "complevel": 9 if is_reduced else 1, "shuffle": True}
            if is_reduced and name not in _EXACT:
                data[name] = data[name].astype(np.float32)
            if is_reduced and data[name].size > _PACKED:
                bits = _ERROR_BITS if name.endswith(STANDARD_ERROR) else _BLOCK_BITS if name in BLOCKS else _BITS
                encoding[name] |= {"significant_digits": bits, "quantize_mode": "BitRound"}
    write_dataset(path, follow_conventions(data), encoding)
