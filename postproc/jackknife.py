"""Standard errors of numbers that are made of time means, by leaving out one block of the averaging window at a time.

The delete-block jackknife for blocks of unequal length (Busing, Meijer and van der Leeden 1999, Statistics and
Computing 9:3): with theta of the whole window and theta_j without the block j, which is one h_j-th of it, the
pseudo-values are h_j theta - (h_j - 1) theta_j, and the squared error is the mean of their squared deviations over
h_j - 1. It holds for blocks that do not know of each other; what neighbours share counts as it does for maps.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fbcouple.results.block_errors import find_gain
from fbcouple.results.block_means import REPLICA, SAMPLES, has_blocks, mirror, pack_blocks, unpack_means
from fbcouple.results.reader import NotDrawableError, Results

FEWEST = 3
_FLUX_Z = 4


def is_own_mirror_image(results: Results) -> bool:
    """Whether nothing that the case says tells the left half of the bed from the right one: a box with a uniform inlet
    or one around a closed nozzle in the middle, nothing that comes or goes at a side, and no side wall of a
    temperature of its own."""
    case = results.case
    gas, particles = case.get("gas") or {}, case.get("particles") or {}
    walls = [wall for wall in (case.get("heat") or {}).get("walls") or () if wall["face"] in ("left", "right")]
    sided = gas.get("inlets"), gas.get("outlets"), particles.get("feeds"), particles.get("outlets"), walls
    return results.is_box and case["domain"].get("shape", "box") == "box" and not any(sided)


def mirror_flux(results: Results, flux: np.ndarray) -> np.ndarray:
    """The mean of `flux`, its components x and z (2, z, x), and its mirror image, where the bed is its own."""
    if not is_own_mirror_image(results):
        return flux
    turned = flux[..., ::-1] * np.array([-1.0, 1.0]).reshape(2, 1, 1)
    return 0.5 * (flux + turned)


def estimate_number_error(results: Results, number: Callable[[Results], float]) -> float:
    """Standard error of `number`, which is the same of a bed and its mirror image, of the time means of `results`.

    Where the bed is its own mirror image, blocks count together with theirs, so that patterns that turn round slowly
    from one side to the other, and so mean nothing to the number, do not make the error unknown.
    `number` is given time means over the depth of solids fraction, flux, velocity and agitation, on one cell in y.

    Raises: NotDrawableError if there are no blocks, or they are too short to tell an error.
    """
    if not has_blocks(results.data):
        raise NotDrawableError([f"{results.path} has no blocks (`{SAMPLES}`), so no standard error; run it again."])
    rows, samples = pack_blocks(results.data), results.data[SAMPLES].values.astype(float)
    if is_own_mirror_image(results):
        rows = 0.5 * (rows + mirror(rows))
    gain = _find_gain(results, rows[:, _FLUX_Z], samples)
    if len(samples) < FEWEST or math.isnan(gain):
        text = f"{results.path} has no standard errors yet: the window is too short against the correlation"
        raise NotDrawableError([f"{text}; run longer."])
    share = samples / samples.sum()
    whole = np.tensordot(share, rows, 1)
    without = (whole - share[:, None, None, None] * rows) / (1.0 - share[:, None, None, None])
    value = number(_show(results, whole))
    others = np.array([number(_show(results, row)) for row in without])
    times = 1.0 / share
    pseudo = times * value - (times - 1.0) * others
    squared = float(np.mean((pseudo - pseudo.mean()) ** 2 / (times - 1.0)))
    return math.sqrt(squared * gain * len(samples))


def _find_gain(results: Results, flux: np.ndarray, samples: np.ndarray) -> float:
    """Squared standard error of a mean over the variance of the blocks, by the vertical `flux` (blocks, z, x) of the
    full blocks of all replicas."""
    full = samples >= samples.max() - 1.0 if REPLICA not in results.data else samples > 0.5 * np.median(samples)
    number = results.data[REPLICA].values if REPLICA in results.data else np.ones(len(samples))
    flux, number = flux[full].reshape(int(full.sum()), -1), number[full]
    apart = flux - flux.mean(axis=0)
    neighbours = np.diff(number) == 0
    if not neighbours.any():
        return math.nan
    products = float((apart[1:] * apart[:-1])[neighbours].sum()) * (len(flux) - 1) / neighbours.sum()
    return find_gain(products, float((apart**2).sum()), len(flux))


def _show(results: Results, row: np.ndarray) -> Results:
    y = results.data["y"].values.astype(float)
    axes = {axis: results.data[axis] for axis in ("x", "z", "component")}
    data = unpack_means(row, axes | {"y": [0.5 * (y[0] + y[-1])]})
    return replace(results, data=data.assign_attrs(results.data.attrs))
