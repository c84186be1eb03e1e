"""What a pooled file tells of each of its replicas: attribute `replicas_of`, as JSON."""

from __future__ import annotations

import json
import math
from typing import Any

import xarray as xr

REPLICAS_OF = "replicas_of"


def list_told(data: xr.Dataset) -> list[dict[str, Any]]:
    """What is told of each replica, in their order; nothing of a run that is none of a pool."""
    return list(json.loads(data.attrs[REPLICAS_OF])) if REPLICAS_OF in data.attrs else []


def find_in_told(data: xr.Dataset) -> list[str]:
    """In what the attribute is not as a pool writes it."""
    if REPLICAS_OF not in data.attrs:
        return []
    try:
        told = list_told(data)
    except (TypeError, ValueError):
        return [f"its attribute {REPLICAS_OF} is not JSON"]
    if told and all(isinstance(one, dict) and _is_name(one) and _is_window(one.get("window")) for one in told):
        return []
    return [f"its attribute {REPLICAS_OF} does not name each replica, and its averaging window"]


def _is_name(one: dict[str, Any]) -> bool:
    return isinstance(one.get("name"), str)


def _is_window(given: Any) -> bool:
    return (
        isinstance(given, list)
        and len(given) == 2
        and all(isinstance(time, int | float) and math.isfinite(time) for time in given)
    )
