"""What was watched while a run went on: conservation, limits of the steps, whether the gas carries the bed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fbcouple.postproc.statistics import summarise
from fbcouple.results.inlet_speed import find_mean, is_constant
from fbcouple.results.reader import NotDrawableError, Results, depth_average


@dataclass(frozen=True)
class Watched:
    """A dimensionless number: in words what it is, its value over the run, and what is wanted of it."""

    monitor: str
    value: float
    wanted: str


FEW = 0.1
"""Mean inflow over the fastest below which nothing is put in proportion to it."""
Monitor = Callable[[Results], Watched]
MONITORS: dict[str, Monitor] = {}


def monitor(name: str) -> Callable[[Monitor], Monitor]:
    """Register a function under the variable of the results that it needs."""

    def register(function: Monitor) -> Monitor:
        MONITORS[name] = function
        return function

    return register


@monitor("particles")
def _lost(results: Results) -> Watched:
    count = results.history("particles").values
    return Watched("particles lost", float(count[0] - count[-1]), "0")


@monitor("solids_volume")
def _volume(results: Results) -> Watched:
    volume = results.history("solids_volume").values
    return Watched(
        "largest relative change of the solids volume", float(np.max(np.abs(volume / volume[0] - 1))), "1e-12"
    )


@monitor("momentum_error")
def _momentum(results: Results) -> Watched:
    return Watched(
        "momentum error of a step over its drag impulse, largest", _largest(results, "momentum_error"), "1e-10"
    )


@monitor("gas_mass_error")
def _mass(results: Results) -> Watched:
    words = "gas lost by continuity in a step over the fastest inflow or, without any, over all gas, largest"
    return Watched(words, _largest(results, "gas_mass_error"), "")


@monitor("gas_inflow_error")
def _asked_inflow(results: Results) -> Watched:
    words = "gas at the inlet against what the case asks for, over the fastest inflow, largest"
    return Watched(words, _largest(results, "gas_inflow_error"), "1e-6")


@monitor("displaced_gas_error")
def _displaced(results: Results) -> Watched:
    words = "gas that unequal steps displaced too much or too little between rows, over the solids, largest"
    return Watched(words, _largest(results, "displaced_gas_error"), "small: changes of the step are few")


@monitor("particles_at_outlet")
def _at_outlet(results: Results) -> Watched:
    words = "particles at the outlet, most: it is a wall for them"
    return Watched(words, int(_largest(results, "particles_at_outlet")), "0")


@monitor("gas_flux_error")
def _flux(results: Results) -> Watched:
    if not np.isfinite(results.history("gas_flux_error").values).any():
        raise NotDrawableError(["no inflow to compare with."])
    return Watched(
        "gas flux at a height against continuity over the inflow, largest", _largest(results, "gas_flux_error"), ""
    )


@monitor("max_courant")
def _courant(results: Results) -> Watched:
    limit = (results.case.get("gas") or {}).get("max_courant")
    return Watched("Courant number, largest", _largest(results, "max_courant"), "" if limit is None else f"{limit:g}")


@monitor("min_voidage")
def _voidage(results: Results) -> Watched:
    return Watched("voidage, least", float(np.nanmin(results.history("min_voidage").values)), "above 0.26")


@monitor("cells_over_packed")
def _packed(results: Results) -> Watched:
    wanted = "0; otherwise spread particles wider: exchange.filter_passes, or a kernel or diffusion_width"
    return Watched("cells over the closest packing, most", int(_largest(results, "cells_over_packed")), wanted)


@monitor("max_overlap")
def _overlap(results: Results) -> Watched:
    return Watched("overlap of two particles over the diameter, largest", _largest(results, "max_overlap"), "")


@monitor("pressure_drop")
def _support(results: Results) -> Watched:
    weight = results.weight_per_area
    if weight is None:
        raise NotDrawableError(["no weight to put the pressure drop in proportion to."])
    words = "mean steady pressure drop over weight less buoyancy a cross-section"
    steady = summarise(results, "pressure_drop")
    wanted = "1 within 3 % if the gas carries the bed"
    return Watched(words, steady.mean / weight, "no mean: start-up not over" if math.isnan(steady.start) else wanted)


@monitor("gas_flux")
def _inflow(results: Results) -> Watched:
    """Of a mesh from a file the velocity is that of the inlet patch, and the bed may be wider at another height."""
    if results.inlet_speed is None:
        raise NotDrawableError(["no inlet flow."])
    if results.case["domain"].get("shape") == "file":
        raise NotDrawableError(["a mesh has not the inlet's area at every height."])
    gas = results.case["gas"]
    mean = find_mean(gas, *results.span)
    if abs(mean) < FEW * results.inlet_speed:
        raise NotDrawableError(["as much gas flows down as up."])
    layers = results.mean("gas_flux").sel(component="z").mean(["x", "y"]).values / mean
    value = float(layers[np.argmax(np.abs(layers - 1.0))])
    if not is_constant(gas):
        return Watched("mean gas flux at a height over the mean inflow, farthest from 1", value, "near 1")
    return Watched("mean gas flux at a height over U_f, farthest from 1", value, "1 within 1 %")


@monitor("solids_flux")
def _net_flux(results: Results) -> Watched:
    upward = depth_average(results.mean("solids_flux").sel(component="z"))
    largest = float(np.abs(upward).max())
    net = float(np.abs(upward.mean("x")).max()) / largest if largest else 0.0
    return Watched(
        "net vertical solids flux at a height over the largest flux", net, "small: the time mean is long enough"
    )


@monitor("solids_flux_stderr")
def _settled(results: Results) -> Watched:
    """Bed height and pressure drop may be steady for seconds while the pattern of the flow still turns round."""
    upward, error = (
        depth_average(field.sel(component="z"))
        for field in (results.mean("solids_flux"), results.error("solids_flux_stderr"))
    )
    size = float(np.sqrt((upward**2).sum()))
    if not size or not bool(np.isfinite(error).any()):
        raise NotDrawableError(["no blocks of the vertical flux to compare."])
    words = "standard error of the map of vertical solids flux over the map, root mean square"
    return Watched(words, float(np.sqrt((error**2).sum())) / size, "below 0.3, or the pattern is not settled")


def _largest(results: Results, name: str) -> float:
    return float(np.nanmax(results.history(name).values))
