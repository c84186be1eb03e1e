"""Means over replicas, runs of one case with different seeds, as one results.nc, with errors from between them.

A time mean is a ratio of sums over samples and, for some quantities, over what they are of: velocity and temperature
of the solids over the mass, agitation and granular temperature over the solids, temperature of the gas over the
voidage. So is the pooled one: sum w x / sum w, with the samples of each replica times that of the cell for w.

The squared error between R replicas is R/(R - 1) sum q^2 (x - mean)^2, q = w/sum w: s^2/R for equal weights. It is
right whatever the correlation in time, and rests on R - 1 numbers in each cell: for few replicas it is a bad number
for a cell and a good one for a map. The block errors within the replicas are the other way round: many blocks, and too
small by a common factor where blocks are short against the correlation. So a map is told by both: the squared error of
a cell is the mean of that between replicas, with R - 1 as weight, and of that within, times one factor for the map that
makes their sums over it equal, with R (blocks - 1) as weight. Histories have block errors without that factor.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from fbcouple.results.alike import require_alike
from fbcouple.results.block_means import join_blocks
from fbcouple.results.conventions import STANDARD_ERROR
from fbcouple.results.histories import find_worst
from fbcouple.results.replicas import WINDOW_BLOCKS, Replica
from fbcouple.results.told import DRIFT, OVER, REPLICAS_OF
from fbcouple.results.variables import MEANS
from fbcouple.results.weights import find_weight

REPLICAS, WINDOW_MEAN = "replicas", "window_mean"
"""Attribute of a pooled results.nc: how many replicas are in it. `replicas_of` tells of each, as JSON."""
_OF_ONE = ("averaging_error", "averaging_error_of", "ended_by", "changed_since_set_up", "updates", OVER, DRIFT)
"""Attributes that a pool does not take from its first replica."""
ADDED = ("core_seconds", "cpu_seconds")
_BLOCKS = 10
"""Blocks of a window where the case does not say them: the default of averages.blocks."""


@dataclass(frozen=True)
class Pooled:
    """The `mean` of values of replicas and its standard `error`, nan where none is known."""

    mean: np.ndarray
    error: np.ndarray


def combine(values: np.ndarray, weights: np.ndarray, within: np.ndarray, blocks: float, scaled: bool = True) -> Pooled:
    """Pool `values` (replicas, ...) with `weights` and block errors `within` of the same shape.

    A replica with weight 0 has no value there. blocks: of the errors within; scaled: those are too small by a common
    factor, and all of `values` are one map.
    """
    known = (weights > 0.0) & np.isfinite(values)
    counted = np.where(known, weights, 0.0)
    total = counted.sum(axis=0)
    share = np.divide(counted, total, out=np.zeros_like(counted), where=total > 0.0)
    given = np.where(known, values, 0.0)
    mean = np.where(total > 0.0, (share * given).sum(axis=0), np.nan)
    held = known.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        between = np.where(known, share * (given - mean), 0.0)
        between = np.where(held > 1, held / (held - 1) * (between**2).sum(axis=0), np.nan)
    inner = np.where(known, share * within, 0.0)
    inner = (inner**2).sum(axis=0)  # nan where one of the replicas has none
    if len(values) == 1:
        return Pooled(mean, np.where(held > 0, np.sqrt(inner), np.nan))
    if scaled:
        whole = np.isfinite(between) & np.isfinite(inner) & (held == len(values))
        sums = inner[whole].sum()
        inner = inner * (between[whole].sum() / sums if sums > 0.0 else np.nan)
    outer_parts, inner_parts = np.maximum(held - 1.0, 0.0), held * (blocks - 1.0)
    pairs = [(between, outer_parts), (inner, inner_parts)]
    parts = sum(np.where(np.isfinite(square), part, 0.0) for square, part in pairs)
    squares = sum(np.where(np.isfinite(square), part * square, 0.0) for square, part in pairs)
    with np.errstate(invalid="ignore", divide="ignore"):
        return Pooled(mean, np.where(parts > 0.0, np.sqrt(squares / parts), np.nan))


def weigh(replica: Replica, name: str) -> np.ndarray:
    """What a replica's mean `name` counts in a pool, of the shape of that mean: its samples times what the mean is an
    average over, see `find_weight`."""
    field = replica.data[name]
    weight = find_weight(replica.data, replica.case, name)
    if weight is None:
        return np.full(field.shape, float(replica.samples))
    return replica.samples * np.broadcast_to(weight.transpose(..., *field.dims[-weight.ndim :]).values, field.shape)


def pool(replicas: Sequence[Replica], defaults: Mapping[str, Any] | None = None) -> xr.Dataset:
    """The results of `replicas` as one dataset like a run's.

    Means, with errors, and the `window_mean` of histories are of all of them; histories of what may go wrong
    have the worst of all at the rows of the first; other histories, snapshots and probes are those of the first.
    defaults: of the options of a case by dotted key, for replicas that an fbcouple without some of them made.

    Raises: CaseError if they are not replicas of one case, or one is there twice.
    """
    require_alike(replicas, defaults or {})
    first = replicas[0]
    blocks = float(first.case["averages"].get("blocks") or _BLOCKS)
    means = {name: pool_mean(replicas, name, blocks) for name in MEANS if name in first.data}
    changed: dict[str, Any] = {}
    for name, found in means.items():
        for full, values in ((name, found.mean), (f"{name}{STANDARD_ERROR}", found.error)):
            like = first.data[name]
            changed[full] = (like.dims, values, first.data[full].attrs if full in first.data else {})
    parts = [one.data for one in replicas]
    changed |= _pool_windows(replicas) | find_worst(parts) | join_blocks(parts)
    attributes = {name: value for name, value in first.data.attrs.items() if not _is_of_one(name)}
    kept = first.data.drop_dims(["quantity", "block"], errors="ignore")
    pooled = kept.assign(changed).set_coords("quantity")
    return _describe(pooled.assign_attrs(attributes), replicas)


def _is_of_one(name: str) -> bool:
    return name in _OF_ONE or name.startswith("predicted_")


def pool_mean(replicas: Sequence[Replica], name: str, blocks: float) -> Pooled:
    """The mean `name` of `replicas`; of a vector each component is a map of its own."""
    stderr = f"{name}{STANDARD_ERROR}"
    values = np.array([one.data[name].values.astype(float) for one in replicas])
    weights = np.array([weigh(one, name) for one in replicas])
    within = np.array(
        [one.data[stderr].values if stderr in one.data else np.full(values.shape[1:], np.nan) for one in replicas]
    ).astype(float)
    if "component" not in replicas[0].data[name].dims:
        return combine(values, weights, within, blocks)
    parts = [combine(values[:, n], weights[:, n], within[:, n], blocks) for n in range(values.shape[1])]
    return Pooled(np.array([part.mean for part in parts]), np.array([part.error for part in parts]))


def _pool_windows(replicas: Sequence[Replica]) -> dict[str, Any]:
    """`window_mean` and its standard error of each history that all have, over `quantity`, weighted with the samples as
    the means of maps are, however often each replica recorded."""
    names = [name for name in replicas[0].windows if all(name in one.windows for one in replicas)]
    found = []
    samples = np.array([one.samples for one in replicas], dtype=float)
    for name in names:
        means, errors, _ = np.array([one.windows[name] for one in replicas]).T
        found.append(combine(means, samples, errors, WINDOW_BLOCKS, scaled=False))
    about = {"long_name": "mean of a history over the averaging windows of all replicas, in the unit of the history"}
    values = np.array([[one.mean, one.error] for one in found], dtype=float).reshape(-1, 2)
    error = {"long_name": f"standard error of the {about['long_name']}"}
    return {
        "quantity": ("quantity", np.array(names, dtype=str), {"long_name": "name of a history"}),
        WINDOW_MEAN: ("quantity", values[:, 0], about),
        f"{WINDOW_MEAN}{STANDARD_ERROR}": ("quantity", values[:, 1], error),
    }


def _describe(data: xr.Dataset, replicas: Sequence[Replica]) -> xr.Dataset:
    """What the file says of the pool."""
    added: dict[str, Any] = {
        name: sum(float(one.about[name]) for one in replicas)
        for name in ADDED
        if all(name in one.about for one in replicas)
    }
    return data.assign_attrs(
        added
        | _pool_start_up(replicas)
        | {
            REPLICAS: len(replicas),
            REPLICAS_OF: json.dumps([one.about for one in replicas]),
            "averaging_start": min(one.window[0] for one in replicas),
            "averaging_end": max(one.window[1] for one in replicas),
            "averaging_samples": sum(one.samples for one in replicas),
            "averaged_seconds": sum(one.window[1] - one.window[0] for one in replicas),
            "simulated_seconds": sum(float(one.about["simulated"]) for one in replicas),
            "complete": int(all(one.about["complete"] for one in replicas)),
            "pooled_errors": tell_errors(len(replicas)),
        }
    )


def _pool_start_up(replicas: Sequence[Replica]) -> dict[str, Any]:
    """What those replicas found that looked for the end of their start-up: is it over in all, and the largest drift,
    nan where one of them is too short to tell; nothing if none looked."""
    looked = [one.about for one in replicas if OVER in one.about]
    if not looked:
        return {}
    drifts = [float("nan") if one.get(DRIFT) is None else float(one[DRIFT]) for one in looked]
    return {OVER: int(all(one[OVER] for one in looked)), DRIFT: float(np.max(drifts))}


def tell_errors(count: int) -> str:
    """A sentence on the standard errors of a pool of `count` replicas."""
    if count == 1:
        return "standard errors are the block errors of the one run"
    text = f"standard errors from between {count} replicas and from blocks within them"
    uncertain = 100.0 / np.sqrt(2.0 * (count - 1))
    told = f"{text}; those between are uncertain by {uncertain:.0f} % of themselves in one place"
    return f"{told}, which is little worth: they rest on one difference, so run three or more" if count == 2 else told
