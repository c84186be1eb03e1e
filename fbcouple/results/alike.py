"""Whether replicas may be pooled: all are runs of one case, on one mesh, and each is there once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from fbcouple.errors import CaseError
from fbcouple.results.replicas import Replica
from fbcouple.results.variables import MEANS

_ANY = (
    "title",
    "end_time",
    "averages.start",
    "averages.blocks",
    "averages.until_error",
    "averages.earliest_end",
    "averages.error_of",
    "start.seed",
    "particles.positions_seed",
    "contact.skin",
)
"""Options in which replicas may differ: seeds, how long they are, and what is for speed alone."""
_ANY_SECTIONS = ("output", "monitors", "checkpoint")


def require_alike(replicas: Sequence[Replica], defaults: Mapping[str, Any]) -> None:
    """Raise CaseError unless all are of one case, on one mesh, and each is there once; `defaults` of options by dotted
    key: an option that is younger than a replica had its default in it."""
    if not replicas:
        raise CaseError(["no run is given to pool; give run folders, or a folder of replicas."])
    first, problems = replicas[0], []
    for number, one in enumerate(replicas[1:], start=1):
        name, differing = one.about["name"], _list_differences(first.case, one.case, defaults)
        if differing:
            problems.append(
                f"{name}: is another case than {first.about['name']} ({', '.join(differing)}); leave it out."
            )
        elif not all(np.array_equal(first.data[axis].values, one.data[axis].values) for axis in "xyz"):
            problems.append(f"{name}: has another grid than {first.about['name']}; leave it out.")
        elif _list_means(one.data) != _list_means(first.data):
            problems.append(f"{name}: has not the time means of {first.about['name']}; leave it out.")
        elif one.data.attrs.get("inlet_changes") != first.data.attrs.get("inlet_changes"):
            problems.append(
                f"{name}: its inlet was changed otherwise than that of {first.about['name']}; leave it out."
            )
        alike = [other for other in replicas[:number] if not _list_differences(other.case, one.case, defaults)]
        problems += [text for other in alike if (text := _find_same(one, other))]
    if problems:
        raise CaseError(problems)


def _find_same(one: Replica, other: Replica) -> str:
    """Why `one` tells nothing that is not in `other`, too, as it is the same run, then or at another of its times;
    nothing if it is another.

    A run that went on has other means, but its seeds, and the set-up or a part of the window are those of before.
    """
    name, known = one.about["name"], other.about["name"]
    if one.about["results"] == other.about["results"]:
        return f"{name}: is the same run as {known}; give it once."
    seeds = one.about.get("seeds")
    if seeds is None or seeds != other.about.get("seeds"):
        return ""
    shared = ""
    if one.about.get("set_up") and one.about["set_up"] == other.about.get("set_up"):
        shared = "the same set-up"
    elif max(one.window[0], other.window[0]) < min(one.window[1], other.window[1]):
        first, second = (f"{start:g} to {end:g} s" for start, end in (one.window, other.window))
        shared = f"windows that overlap ({first}, {second})"
    if not shared:
        return ""
    told = ", ".join(f"{key} = {value}" for key, value in seeds.items()) or "none"
    text = f"is the same run as {known}, maybe at another of its times: both have the same seeds ({told}) and {shared}"
    return f"{name}: {text}; give one of them, or set one up with another seed."


def _list_means(data: xr.Dataset) -> list[tuple[str, Any]]:
    return [(name, data[name].sizes) for name in MEANS if name in data]


def _list_differences(one: Mapping[str, Any], other: Mapping[str, Any], defaults: Mapping[str, Any]) -> list[str]:
    """Options in which two cases differ and replicas may not, and sections that one has alone."""
    before, now = _flatten(one), _flatten(other)
    before, now = ({key: defaults.get(key) for key in before | now} | told for told in (before, now))
    return sorted(key for key in before.keys() | now.keys() if before.get(key) != now.get(key))


def _flatten(case: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in case.items():
        if key in _ANY_SECTIONS:
            continue
        if isinstance(value, dict):
            found |= {key: True} | {f"{key}.{name}": given for name, given in value.items()}
        else:
            found[key] = value
    if feeds := found.get("particles.feeds"):
        found["particles.feeds"] = [{k: v for k, v in feed.items() if k != "seed"} for feed in feeds]
    return {key: value for key, value in found.items() if key not in _ANY}
