"""Solids in each block of the averaging window, means over the depth: a number that is made of maps has its standard
error from what it is without one block after the other.

The standard errors of the maps do not tell it: cells err together or against each other, and a sum of their errors is a
bound that may be several times too high.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

BLOCKS: dict[str, tuple[str, str]] = {
    "block_solids_fraction": ("1", "solids fraction"),
    "block_solids_mass": ("kg m-3", "mass of the solids over the volume"),
    "block_solids_flux": ("kg m-2 s-1", "solids mass flux"),
    "block_solids_energy": ("kg m-1 s-2", "mass of the solids times the square of their velocity over the volume"),
}
"""Name -> unit, and what it is the depth mean of over each block (block, z, x), the flux (block, component, z, x)."""
SAMPLES, START, REPLICA = "block_samples", "block_start", "block_replica"
COLUMNS = 6
"""Numbers of a place in a block: fraction, mass, the components of the flux, energy."""
_FLUX = slice(2, 5)


def lay_out_blocks(starts: Sequence[float], samples: Sequence[int], rows: Iterable[np.ndarray]) -> dict[str, Any]:
    """Variables of a dataset for blocks of as many `samples` each, the first of them at `starts` [s], with `rows`
    (COLUMNS, z, x) of each."""
    about = {"units": "1", "long_name": "samples that the means of a block are of"}
    begin = {"units": "s", "long_name": "time of the first sample of a block"}
    found: dict[str, Any] = {
        SAMPLES: ("block", np.array(samples, dtype=np.int32), about),
        START: ("block", np.array(starts, dtype=float), begin),
    }
    packed = np.array(list(rows), dtype=np.float32)
    parts = packed[:, 0], packed[:, 1], packed[:, _FLUX], packed[:, 5]
    for (name, (unit, text)), values in zip(BLOCKS.items(), parts, strict=True):
        dims = ("block", "component", "z", "x") if values.ndim == 4 else ("block", "z", "x")
        found[name] = (dims, values, {"units": unit, "long_name": f"depth mean over each block of the {text}"})
    return found


def join_blocks(parts: Sequence[xr.Dataset]) -> dict[str, Any]:
    """The variables of `lay_out_blocks` of all replicas one after another, and `REPLICA`, of which replica each block
    is, counted from 1; nothing unless all have blocks."""
    if not all(has_blocks(part) for part in parts):
        return {}
    names = (SAMPLES, START, *BLOCKS)
    found = {
        name: (parts[0][name].dims, np.concatenate([part[name].values for part in parts]), parts[0][name].attrs)
        for name in names
    }
    numbers = np.repeat(np.arange(1, 1 + len(parts)), [part.sizes["block"] for part in parts]).astype(np.int32)
    return found | {REPLICA: ("block", numbers, {"units": "1", "long_name": "replica that a block is of, from 1"})}


def pair_blocks(data: xr.Dataset, most: int) -> xr.Dataset:
    """`data` with at most `most` blocks, neighbours joined in pairs as often as that takes; a last one without another
    stays as it is."""
    while data.sizes.get("block", 0) > most:
        samples = data[SAMPLES].values.astype(float)
        first = np.arange(0, len(samples), 2)
        joined = {SAMPLES: np.add.reduceat(samples, first).astype(np.int32), START: data[START].values[first]}
        for name in BLOCKS:
            values = data[name].transpose("block", ...).values
            weight = samples.reshape(-1, *[1] * (values.ndim - 1))
            total = np.add.reduceat(weight, first)
            joined[name] = (np.add.reduceat(weight * values, first) / total).astype(np.float32)
        kept = {name: data[name].transpose("block", ...) for name in joined}
        found = {name: (kept[name].dims, values, data[name].attrs) for name, values in joined.items()}
        data = data.drop_dims("block").assign(found)
    return data


def take_blocks(data: xr.Dataset, replica: int) -> xr.Dataset:
    """`data` with the blocks of one replica alone, counted from 1."""
    if REPLICA not in data:
        return data
    return data.isel(block=np.flatnonzero(data[REPLICA].values == replica)).drop_vars(REPLICA)


def has_blocks(data: xr.Dataset) -> bool:
    """Whether there is a block of the solids."""
    return SAMPLES in data and all(name in data for name in BLOCKS)


def pack_blocks(data: xr.Dataset) -> np.ndarray:
    """The rows (blocks, COLUMNS, z, x) of the blocks in `data`, 0 outside of a mesh."""
    fields = [data[name].transpose("block", ..., "z", "x").values.astype(float) for name in BLOCKS]
    rows = np.concatenate([field if field.ndim == 4 else field[:, None] for field in fields], axis=1)
    return np.nan_to_num(rows)


def mirror(rows: np.ndarray) -> np.ndarray:
    """Rows (..., COLUMNS, z, x) as a mirror in the middle of the width shows them: x turned round, and the flux along
    it."""
    turned = rows[..., ::-1].copy()
    turned[..., _FLUX.start, :, :] *= -1.0
    return turned


def unpack_means(row: np.ndarray, coords: Mapping[str, Any]) -> xr.Dataset:
    """The time means that `row` (COLUMNS, z, x) makes, on a mesh of one cell in y with `coords`."""
    mass, flux = row[1], row[_FLUX]
    velocity = np.divide(flux, mass, out=np.zeros_like(flux), where=mass > 0.0)
    square = np.divide(row[5], mass, out=np.zeros_like(mass), where=mass > 0.0)
    agitation = square - (velocity**2).sum(axis=0)
    mean, vector = ("z", "y", "x"), ("component", "z", "y", "x")
    return xr.Dataset(
        {
            "solids_fraction": (mean, row[0][:, None]),
            "solids_flux": (vector, flux[:, :, None]),
            "solids_velocity": (vector, velocity[:, :, None]),
            "agitation": (mean, np.maximum(agitation, 0.0)[:, None]),
        },
        coords,
    )
