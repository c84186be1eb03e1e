"""Means as if averaging had started later: of the blocks of the window that begin then, without a run for it.

The blocks hold depth means of the solids; means of the gas, and the granular temperature, are not kept in them.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from fbcouple.errors import CaseError
from fbcouple.results.block_errors import estimate_errors
from fbcouple.results.block_means import SAMPLES, START, has_blocks, pack_blocks, unpack_means
from fbcouple.results.conventions import STANDARD_ERROR
from fbcouple.results.reduced import reduce
from fbcouple.results.replicas import Replica, average_windows
from fbcouple.results.variables import MEANS

FEWEST = 3
"""Blocks that means are of at least: fewer have no standard error."""
_NEAR = 1e-9
_RATIOS = ("solids_velocity", "agitation")
_WHOLE = 0.99
"""Samples, of those of the longest block, from which a block counts for standard errors: the last may be cut short."""


def begin_later(replica: Replica, start: float) -> Replica:
    """The reduced `replica` with the means of its blocks that begin at `start` [s] or after it, and windows from there.

    Raises: CaseError if it has no blocks, or too few of them after `start`.
    """
    name, data = replica.about["name"], replica.data
    if not has_blocks(data):
        text = "has no blocks of its averaging window, so that no part of it can be taken; run it by this version"
        raise CaseError([f"--from: {name}: {text}, or set averages.start."])
    begins = data[START].values.astype(float)
    kept = np.flatnonzero(begins >= start * (1.0 - _NEAR))
    if len(kept) < FEWEST:
        known = f"{len(begins)} blocks begin at {begins[0]:.4g} to {begins[-1]:.4g} s"
        text = f"{start:g} s is given, and {len(kept)} of its blocks begin then or later, at least {FEWEST} are wanted"
        raise CaseError([f"--from: {name}: {text} ({known}); give an earlier time, or let the run go on."])
    small = reduce(replace(replica, data=data.isel(block=kept)))
    window = (float(begins[kept[0]]), replica.window[1])
    made = small.data.drop_vars([str(one) for one in small.data.data_vars if _is_mean(str(one))])
    made = made.assign(_average_blocks(small.data))
    samples = int(data[SAMPLES].values[kept].sum())
    times = data["time"].values[data["time"].values >= window[0]] if "time" in data else np.empty(0)
    told = {"samples": samples, "window": list(window), "first_row": float(times[0]) if times.size else None}
    windows = replica.windows if len(kept) == len(begins) else average_windows(data, window)
    return Replica(made, replica.case, samples, window, windows, replica.about | told)


def _is_mean(name: str) -> bool:
    return name.removesuffix(STANDARD_ERROR) in MEANS


def _average_blocks(data: xr.Dataset) -> dict[str, Any]:
    """Means of the solids over the blocks in `data`, of one cell in y, with their standard errors."""
    rows, samples = pack_blocks(data), data[SAMPLES].values.astype(float)
    mean = np.tensordot(samples / samples.sum(), rows, 1)
    whole = [unpack_means(row, {}) for row in rows[samples >= _WHOLE * samples.max()]]
    found: dict[str, Any] = {}
    for name, field in unpack_means(mean, {}).data_vars.items():
        # Of ratios nothing is known where there are no solids.
        parts = np.array(
            [part[name].where(part["solids_fraction"] > 0.0) if name in _RATIOS else part[name] for part in whole]
        )
        for full, values in ((str(name), field.values), (f"{name}{STANDARD_ERROR}", _find_errors(parts))):
            found[full] = _place(data, full, field.dims, values)
    return found


def _find_errors(parts: np.ndarray) -> np.ndarray:
    """Standard errors of the mean of `parts` (blocks, ...); of a vector (blocks, component, z, y, x) each component has
    a correlation of its own."""
    cells = parts.reshape(len(parts), parts.shape[1] if parts.ndim == 5 else 1, -1)
    return estimate_errors(cells.transpose(0, 2, 1)).T.reshape(parts.shape[1:])


def _place(data: xr.Dataset, name: str, dims: tuple[Any, ...], values: np.ndarray) -> tuple[Any, ...]:
    """The variable of a mean at all places (..., z, y, x); of a mesh at those inside of it."""
    about = dict(data[name].attrs) if name in data else {"units": MEANS[name.removesuffix(STANDARD_ERROR)][0]}
    if "sampled_cell" not in data:
        return dims, values, about
    inside = data["sampled_cell"].transpose("z", "y", "x").values >= 0
    return ("cell",) if values.ndim == 3 else ("component", "cell"), values[..., inside], about
