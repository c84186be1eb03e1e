"""What figures and tables rely on in a results.nc: the options of its case, and the shape and kind of its variables."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from fbcouple.results.block_means import BLOCKS, REPLICA, SAMPLES, START
from fbcouple.results.probes import PROBED, find_dimensions, list_tables, name_variable
from fbcouple.results.told import find_in_told
from fbcouple.results.variables import (
    EXITS,
    HISTORIES,
    HISTORIES_OF_OUTLETS,
    HISTORIES_OF_SPECIES,
    HISTORY_VECTORS,
    MEANS,
)

SECTIONS = ("domain", "gas", "particles", "contact", "exchange", "averages", "output", "start")
Is = Callable[[Any], bool]


def is_number(value: Any) -> bool:
    """A finite number, and no truth value."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def is_size(value: Any) -> bool:
    """A number above zero."""
    return is_number(value) and value > 0


def is_start(value: Any) -> bool:
    """A finite number, or auto."""
    return value == "auto" or is_number(value)


def is_text(value: Any) -> bool:
    """A text."""
    return isinstance(value, str)


def are_sizes(value: Any) -> bool:
    """Three numbers above zero."""
    return isinstance(value, list) and len(value) == 3 and all(map(is_size, value))


def are_counts(value: Any) -> bool:
    """Three whole numbers above zero."""
    return are_sizes(value) and all(isinstance(count, int) for count in value)


def are_rows(value: Any) -> bool:
    """Rows of two numbers, one row at least."""
    return isinstance(value, list) and bool(value) and all(_is_row(row) for row in value)


def are_probes(value: Any) -> bool:
    """Tables with a name and quantities."""
    return isinstance(value, list) and all(map(_is_probe, value))


def _is_probe(value: Any) -> bool:
    quantities = value.get("quantities") if isinstance(value, dict) else None
    return (
        isinstance(quantities, list)
        and is_text(value.get("name"))
        and all(isinstance(name, str) and name in PROBED for name in quantities)
    )


def _is_row(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(map(is_number, value))


NEEDED: dict[str, Is] = {
    "title": is_text,
    "end_time": is_number,
    "gravity": is_number,
    "domain.size": are_sizes,
    "domain.cells": are_counts,
    "gas.density": is_size,
    "gas.viscosity": is_number,
    "particles.diameter": is_size,
    "particles.density": is_size,
    "averages.start": is_start,
}
"""Options that a case has if it has their section."""
OPTIONAL: dict[str, Is] = {
    "gas.inlet_velocity": is_number,
    "gas.inlet_ramp": are_rows,
    "gas.max_courant": is_size,
    "gas.max_fourier": is_size,
    "particles.mass": is_number,
    "particles.count": is_number,
    "contact.stiffness": is_size,
    "contact.steps_per_contact": is_number,
    "contact.wall_restitution": is_number,
    "output.particles_every": is_size,
    "output.probes": are_probes,
    "output.snapshots_every": is_size,
}
NUMBERS = (
    "averaging_start",
    "averaging_end",
    "averaging_error",
    "averaging_samples",
    "averaged_seconds",
    "simulated_seconds",
    "replicas",
    "reduced",
    "joined_rows",
    "start_up_over",
    "start_up_drift",
    "core_seconds",
    "cpu_seconds",
    "ranks",
    "complete",
    "predicted_end",
    "predicted_error",
    "predicted_error_factor",
    "predicted_factor",
    "predicted_seconds",
    "floor",
    "bed_section",
    "solids_mass",
    "solids_volume",
)
"""Attributes that are numbers."""
OF_PARTICLES = ("particles", "solids_fraction", "voidage_snapshots", "tracked_position")
"""Variables that no case without particles has."""
TIMES = ("time", "snapshot_time")
AXES = ("x", "y", "z")
VECTORS = ("solids_flux", "solids_velocity", "gas_velocity", "gas_flux")
"""Time means that have components."""


def find_faults(data: xr.Dataset, case: Mapping[str, Any]) -> list[str]:
    """Everything in which `data` and its `case` are not as a run writes them, a text each."""
    unfounded = "particles" not in case and any(name in data for name in OF_PARTICLES)
    alone = ["it has numbers of particles, and its case has no [particles]"] if unfounded else []
    broken = _find_in_case(case)
    variables = _find_in_axes(data) or _find_in_variables(data, {} if broken else case)
    return broken + alone + _find_in_attributes(data) + find_in_told(data) + variables


def _find_in_case(case: Mapping[str, Any]) -> list[str]:
    odd = [name for name in SECTIONS if not isinstance(case.get(name, {}), dict)]
    if odd or "domain" not in case:
        return [f"[{name}] of its case is no section" for name in odd or ["domain"]]
    faults = []
    for key, is_right in (NEEDED | OPTIONAL).items():
        section, _, name = key.rpartition(".")
        options = case.get(section) if section else case
        if options is None or (key in OPTIONAL and options.get(name) is None):
            continue
        if not is_right(options.get(name)):
            faults.append(f"{key} of its case is {_show(options.get(name))}, and not {_describe(is_right)}")
    gas = case.get("gas")
    if gas is not None and gas.get("inlet_velocity") is None and gas.get("inlet_ramp") is None:
        faults += _find_in_inlets(gas)
    return faults


def _find_in_inlets(gas: Mapping[str, Any]) -> list[str]:
    inlets = gas.get("inlets")
    if not inlets:
        return ["[gas] of its case has neither inlet_velocity nor inlet_ramp nor inlets"]
    tables = inlets if isinstance(inlets, list) else [None]
    right = is_size(gas.get("inlet_section")) and all(
        isinstance(table, dict)
        and is_number(table.get("area"))
        and (is_number(table.get("velocity")) or are_rows(table.get("ramp")))
        for table in tables
    )
    return [] if right else ["gas.inlets of its case are not tables with velocity or ramp and area"]


def _describe(is_right: Is) -> str:
    return str(is_right.__doc__).rstrip(".").lower()


def _show(value: Any) -> str:
    return "absent" if value is None else f"`{str(value)[:40]}`"


def _find_in_attributes(data: xr.Dataset) -> list[str]:
    found = {name: data.attrs[name] for name in NUMBERS if name in data.attrs}
    times = np.atleast_1d(data.attrs.get("inlet_changed_at", []))
    odd = [] if times.dtype.kind in "iuf" else [f"its attribute inlet_changed_at is {_show(times)}, and not times"]
    return odd + [
        f"its attribute {name} is {_show(value)}, and not a number"
        for name, value in found.items()
        if np.ndim(value) != 0 or np.asarray(value).dtype.kind not in "iufb"
    ]


def _find_in_axes(data: xr.Dataset) -> list[str]:
    faults = []
    for name in AXES:
        if name not in data.coords or data[name].dims != (name,) or not _is_even(data[name]):
            faults.append(f"its coordinate {name} is not the centres of equal cells")
    for name in TIMES:
        if name in data.dims and not (name in data.coords and _is_rising(data[name])):
            faults.append(f"its coordinate {name} is not rising times")
    if "component" in data.dims and ("component" not in data.coords or list(data["component"].values) != list(AXES)):
        faults.append("its coordinate component is not x, y, z")
    return faults


def _is_numeric(field: xr.DataArray) -> bool:
    return field.dtype.kind in "iufb"


def _is_rising(axis: xr.DataArray) -> bool:
    if not _is_numeric(axis) or not np.isfinite(axis.values).all():
        return False
    return bool((np.diff(axis.values.astype(float)) >= 0.0).all())


def _is_even(axis: xr.DataArray) -> bool:
    if not axis.size or not _is_rising(axis):
        return False
    steps = np.diff(axis.values.astype(float))
    return not steps.size or bool(steps[0] > 0.0 and np.allclose(steps, steps.mean(), rtol=1e-3))


def _find_in_variables(data: xr.Dataset, case: Mapping[str, Any]) -> list[str]:
    faults = []
    for name, dims in (_list_shapes(data) | _list_probes(data, case)).items():
        if name not in data:
            faults.append(f"it has no variable {name}")
            continue
        field = data[name]
        if sorted(map(str, field.dims)) != sorted(dims):
            faults.append(f"its variable {name} is over {_list(field.dims)}, and not over {_list(dims)}")
        elif not _is_numeric(field):
            faults.append(f"its variable {name} holds no numbers")
    if not faults and "sampled_cell" in data:
        faults += _find_in_cells(data)
    return faults


def _list(dims: Iterable[Any]) -> str:
    return f"({', '.join(map(str, dims))})"


def _list_shapes(data: xr.Dataset) -> dict[str, tuple[str, ...]]:
    """Variables that are there -> the dimensions that each has."""
    axes = ("cell",) if "sampled_cell" in data else ("z", "y", "x")
    known: dict[str, tuple[str, ...]] = {
        "wall_seconds": ("time", "stage"),
        "voidage_snapshots": ("snapshot_time", "z", "x"),
        "tracked_position": ("time", "tracked", "component"),
        "tracked_velocity": ("time", "tracked", "component"),
        "sampled_cell": ("z", "y", "x"),
        "drag_onset_velocity": ("packed_voidage",),
    }
    known |= dict.fromkeys(BLOCKS, ("block", "z", "x")) | dict.fromkeys((SAMPLES, START, REPLICA), ("block",))
    known["block_solids_flux"] = ("block", "component", "z", "x")
    known |= dict.fromkeys(HISTORIES, ("time",)) | dict.fromkeys(HISTORY_VECTORS, ("time", "component"))
    known |= dict.fromkeys(HISTORIES_OF_SPECIES, ("time", "species"))
    known |= dict.fromkeys(HISTORIES_OF_OUTLETS, ("time", "outlet"))
    known |= {f"exit_{name}": ("exit",) for name in EXITS}
    for name in MEANS:
        dims = ("component", *axes) if name in VECTORS else axes
        known |= {name: dims, f"{name}_stderr": dims}
    return {name: dims for name, dims in known.items() if name in data}


def _list_probes(data: xr.Dataset, case: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    """Variables of the probes of `case` -> the dimensions that each has."""
    known: dict[str, tuple[str, ...]] = {}
    for table in list_tables(case):
        name = table["name"]
        if (time := name_variable(name, "time")) in data:
            known |= {time: (time,)} | {name_variable(name, axis): (name_variable(name, "point"),) for axis in AXES}
            known |= {
                name_variable(name, quantity): find_dimensions(name, quantity) for quantity in table["quantities"]
            }
    return known


def _find_in_cells(data: xr.Dataset) -> list[str]:
    cells, count = data["sampled_cell"], data.sizes.get("cell", 0)
    if cells.dtype.kind in "iu" and cells.size and cells.min() >= -1 and cells.max() < count:
        return []
    return [f"its variable sampled_cell does not name cells from 0 to {count - 1}"]
