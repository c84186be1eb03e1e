"""How the rows of each history are joined to fewer, and which of the replicas' values a pool has of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
import xarray as xr


class Join(StrEnum):
    """What becomes of several values of a history; `FARTHEST`: from its first row."""

    LAST = "last"
    MEAN = "mean"
    SUM = "sum"
    LARGEST = "largest"
    LEAST = "least"
    FARTHEST = "farthest"


@dataclass(frozen=True)
class Rule:
    """`rows`: what one row has in place of several; `replicas`: which value of all replicas a pool has, None where it
    has that of the first."""

    rows: Join
    replicas: Join | None = None


STATE, AVERAGE = Rule(Join.LAST), Rule(Join.MEAN)
MOST, LEAST, OFF = (Rule(how, how) for how in (Join.LARGEST, Join.LEAST, Join.FARTHEST))
RULES: dict[str, Rule] = {
    "bed_height": STATE,
    "pressure_drop": AVERAGE,
    "averages_start": STATE,
    "averages_error": STATE,
    "expected_end": STATE,
    "inlet_velocity": AVERAGE,
    "gas_support": AVERAGE,
    "solids_volume": OFF,
    "solids_centre_z": STATE,
    "particles": STATE,
    "particles_fed": STATE,
    "particles_removed": STATE,
    "particles_owed": Rule(Join.LAST, Join.LARGEST),
    "mass_fed": STATE,
    "mass_removed": STATE,
    "heat_fed": STATE,
    "heat_removed": STATE,
    "ledger_error": MOST,
    "momentum_error": MOST,
    "kinetic_energy": STATE,
    "gas_mass_error": MOST,
    "gas_inflow_error": MOST,
    "displaced_gas_error": MOST,
    "gas_flux_error": MOST,
    "gas_backflow": MOST,
    "particles_at_outlet": MOST,
    "max_courant": MOST,
    "min_voidage": LEAST,
    "cells_over_packed": MOST,
    "max_overlap": MOST,
    "substeps": STATE,
    "mean_gas_temperature": STATE,
    "mean_particle_temperature": STATE,
    "min_temperature": LEAST,
    "max_temperature": MOST,
    "heat_given": AVERAGE,
    "heat_by_walls": AVERAGE,
    "heat_by_inlets": AVERAGE,
    "heat_by_outlets": AVERAGE,
    "heat_by_contacts": AVERAGE,
    "heat_by_continuity": AVERAGE,
    "heat_error": MOST,
    "momentum_fed": STATE,
    "momentum_removed": STATE,
    "species_centre_z": STATE,
    "outlet_backflow": MOST,
    "wall_seconds": Rule(Join.SUM),
}
"""Of every history that a run writes."""


def find_rule(name: str, data: xr.Dataset) -> Rule:
    """The rule of the history `name` of a run: where particles come and go, their volume is no constant to watch."""
    return STATE if name == "solids_volume" and "particles_fed" in data else RULES[name]


def join_rows(how: Join, values: np.ndarray, begins: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Rows (groups, ...) in place of `values` (rows, ...), of which the groups begin at the rows `begins`, the first
    at row 0; `start`: the first row of the history. Of extremes nan are left out."""
    if how is Join.LAST:
        return values[np.append(begins[1:], len(values)) - 1]
    if how in (Join.SUM, Join.MEAN):
        total = np.add.reduceat(values, begins, axis=0)
        counts = np.diff(np.append(begins, len(values))).reshape(-1, *[1] * (values.ndim - 1))
        return total / counts if how is Join.MEAN else total
    high, low = (extreme.reduceat(values, begins, axis=0) for extreme in (np.fmax, np.fmin))
    if how is Join.FARTHEST:
        return _choose(how, high, low, start)
    return high if how is Join.LARGEST else low


def _choose(how: Join, one: np.ndarray, other: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Of two values at each place the worse."""
    if how is Join.FARTHEST:
        return np.where((np.abs(other - start) > np.abs(one - start)) | np.isnan(one), other, one)
    return np.fmax(one, other) if how is Join.LARGEST else np.fmin(one, other)


def find_worst(parts: Sequence[xr.Dataset]) -> dict[str, Any]:
    """Histories of what may go wrong: the worst of all replicas that have them, of each up to each row of the first
    since its last one, what came after its end in its last row."""
    first, found = parts[0], dict[str, Any]()
    if not first.sizes.get("time"):
        return found
    for name in RULES:
        owners = [part for part in parts if name in part and part.sizes.get("time")]
        rule = find_rule(name, first)
        if not owners or rule.replicas is None:
            continue
        like = owners[0][name].transpose("time", ...)
        values = np.full((first.sizes["time"], *like.shape[1:]), np.nan)
        for part in owners:
            own = part[name].transpose("time", ...).values.astype(float)
            laid = own if part is first else _lay_out(rule, own, part, first, like.values[0])
            values = _choose(rule.replicas, values, laid, like.values[0])
        about = like.attrs | {"comment": "the worst of all replicas"}
        found[name] = (like.dims, values, about)
    return found


def _lay_out(rule: Rule, own: np.ndarray, part: xr.Dataset, first: xr.Dataset, start: np.ndarray) -> np.ndarray:
    """The rows `own` of another replica joined at the rows of the first one, nan where it has none; `start`: the first
    row of the pool, from which on it counts how far it is off."""
    times, rows = part["time"].values, first["time"].values
    if rule.replicas is Join.FARTHEST:
        own = np.divide(own * start, own[0], out=np.full_like(own, np.nan), where=own[0] != 0.0)
    if rule.rows is Join.LAST:
        places = (np.searchsorted(times, rows, side="right") - 1).clip(min=0)
        places[-1] = len(times) - 1
        return own[places]
    places = np.searchsorted(rows, times).clip(max=len(rows) - 1)
    begins = np.flatnonzero(np.diff(places, prepend=-1))
    laid = np.full((len(rows), *own.shape[1:]), np.nan)
    laid[places[begins]] = join_rows(rule.rows, own, begins, start)
    return laid


def count_lost(data: xr.Dataset) -> float | None:
    """Particles that are missing at the end of a run, negative if there are too many; None if they are not counted."""
    if "particles" not in data or not data.sizes.get("time"):
        return None
    count = data["particles"].values.astype(float)
    lost = float(count[0] - count[-1])
    if "particles_fed" in data and "particles_removed" in data:
        lost += float(data["particles_fed"].values[-1] - data["particles_removed"].values[-1])
    return float(round(lost)) if np.isfinite(lost) else None  # of parcels a product with their grains, to rounding
