"""What a pooled file tells of each of its replicas: attribute `replicas_of`, as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from fbcouple.results.histories import count_lost
from fbcouple.results.steady_part import list_steady
from fbcouple.results.variables import HISTORIES

REPLICAS_OF = "replicas_of"
LATER = "told_later"
"""Says that an older file told nothing of the start-up of a replica, and the rows that it has were looked at."""
OVER, DRIFT = "start_up_over", "start_up_drift"
"""Attributes of a run that looked for the end of its start-up itself."""


def list_told(data: xr.Dataset) -> list[dict[str, Any]]:
    """What is told of each replica, in their order; nothing of a run that is none of a pool."""
    return list(json.loads(data.attrs[REPLICAS_OF])) if REPLICAS_OF in data.attrs else []


def complete_told(data: xr.Dataset) -> list[dict[str, Any]]:
    """The same, with what an older file leaves out of the first replica: its histories are those that the file has."""
    told = list_told(data)
    if told and "steady_from" not in told[0]:
        found = tell_start_up(data, told[0]["window"][0])
        told[0] = {"particles_lost": count_lost(data), LATER: True} | found | told[0]
    return told


def tell_start_up(data: xr.Dataset, begin: float) -> dict[str, Any]:
    """What a pool tells of the start-up of a run whose means begin at `begin` [s]: `steady_from`, from when on each
    history is steady, null if that is not seen; `first_row`, the time of the first row in the window; and what the run
    found, if it looked."""
    times = data["time"].values if data.sizes.get("time") else np.empty(0)
    inside = times[times >= begin]
    names = [name for name in HISTORIES if name in data and data[name].dims == ("time",)]
    found: dict[str, Any] = {
        "steady_from": list_steady(data, names),
        "first_row": float(inside[0]) if inside.size else None,
    }
    if OVER in data.attrs:
        drift = float(data.attrs.get(DRIFT, math.nan))
        found |= {OVER: int(data.attrs[OVER]), DRIFT: drift if math.isfinite(drift) else None}
    return found


def find_in_told(data: xr.Dataset) -> list[str]:
    """In what the attribute is not as a pool writes it."""
    if REPLICAS_OF not in data.attrs:
        return []
    try:
        told = list_told(data)
    except (TypeError, ValueError):
        return [f"its attribute {REPLICAS_OF} is not JSON"]
    if not told or not all(isinstance(one, dict) for one in told):
        return [f"its attribute {REPLICAS_OF} does not tell of each replica"]
    odd = {name: None for one in told for name in (*_NEEDED, *_OPTIONAL) if not _is_right(one, name)}
    return [f"its attribute {REPLICAS_OF} tells no proper {', '.join(odd)} of each replica"] if odd else []


def _is_right(one: dict[str, Any], name: str) -> bool:
    return name in _OPTIONAL if name not in one else (_NEEDED | _OPTIONAL)[name](one[name])


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _is_number_or_none(value: Any) -> bool:
    return value is None or _is_number(value)


_NEEDED: dict[str, Callable[[Any], bool]] = {
    "name": lambda value: isinstance(value, str),
    "window": lambda value: isinstance(value, list) and len(value) == 2 and all(map(_is_number, value)),
    "samples": _is_number,
    "simulated": _is_number,
}
_OPTIONAL: dict[str, Callable[[Any], bool]] = {
    "seeds": lambda value: isinstance(value, dict),
    "steady_from": lambda value: isinstance(value, dict) and all(map(_is_number_or_none, value.values())),
    "first_row": _is_number_or_none,
    "particles_lost": _is_number_or_none,
    OVER: _is_number,
    DRIFT: _is_number_or_none,
}
"""What is told since some version; older files are without it."""
