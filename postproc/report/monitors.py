"""What was watched while a run went on: conservation, limits of the steps, whether the gas carries the bed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fbcouple.postproc.statistics import summarise
from fbcouple.results.block_errors import compare_with_map
from fbcouple.results.depth_means import depth_average
from fbcouple.results.histories import count_lost
from fbcouple.results.inlet_speed import find_mean, is_constant
from fbcouple.results.reader import NotDrawableError, Results
from fbcouple.results.told import complete_told


@dataclass(frozen=True)
class Watched:
    """A dimensionless number: in words what it is, its value over the run, what is wanted of it, and whether it is."""

    monitor: str
    value: float
    wanted: str
    verdict: str = ""
    """`WITHIN`, `BEYOND`, or nothing where no limit is known."""


WITHIN, BEYOND = "within", "BEYOND"
CLOSEST = 0.26
"""Voidage of the closest packing of equal spheres."""
OVERLAP = 0.05
"""Overlap that `fbcouple check` wants, too: above it the bed is softer than the particles are."""
OVERSHOOT = 0.1
"""Part of `gas.max_courant` by which a step may be over it: a step follows from the velocities of the step before."""
FEW = 0.1
"""Mean inflow over the fastest below which nothing is put in proportion to it."""
Monitor = Callable[[Results], Watched]
MONITORS: dict[str, Monitor] = {}


def judge(words: str, value: float, wanted: str, is_within: bool) -> Watched:
    """A number with the verdict on it."""
    return Watched(words, value, wanted, WITHIN if is_within else BEYOND)


def hold_below(words: str, value: float, limit: float | None, reason: str = "") -> Watched:
    """A number that is at most `limit`; where none is known, without verdict."""
    if limit is None:
        return Watched(words, value, "")
    return judge(words, value, f"at most {limit:g}{reason}", value <= limit)


def monitor(name: str) -> Callable[[Monitor], Monitor]:
    """Register a function under the variable of the results that it needs."""

    def register(function: Monitor) -> Monitor:
        MONITORS[name] = function
        return function

    return register


@monitor("particles")
def _lost(results: Results) -> Watched:
    words, lost = "particles lost", count_lost(results.data)
    if lost is None:
        raise NotDrawableError([f"`particles` in {results.path} has rows that are not finite."])
    told = [one.get("particles_lost") for one in complete_told(results.data)]
    known = [float(count) for count in told if count is not None]
    if len(known) == len(told):
        lost = max(known or [lost], key=abs)
    elif len(told) > 1:
        words += ", of the first replica (an older pool does not tell of the others)"
    return judge(words, lost, "0", lost == 0.0)


@monitor("ledger_error")
def _ledger(results: Results) -> Watched:
    error = _largest(results, "ledger_error")
    return hold_below("mass or momentum lost as particles came and went, part of all, largest", error, 1e-9)


@monitor("particles_owed")
def _owed(results: Results) -> Watched:
    owed = float(results.history("particles_owed").values[-1])
    return Watched("particles that wait to be fed for lack of a free place, at the end", owed, "")


@monitor("solids_volume")
def _volume(results: Results) -> Watched:
    if "particles_fed" in results.data:
        raise NotDrawableError(["particles come and go: their ledger is watched."])
    volume = results.history("solids_volume").values
    change = float(np.max(np.abs(volume / volume[0] - 1)))
    return hold_below("largest relative change of the solids volume", change, 1e-12)


@monitor("momentum_error")
def _momentum(results: Results) -> Watched:
    words = "momentum error of a step over its drag impulse, largest"
    return hold_below(words, _largest(results, "momentum_error"), 1e-10)


@monitor("gas_mass_error")
def _mass(results: Results) -> Watched:
    words = "gas lost by continuity in a step over the fastest inflow or, without any, over all gas, largest"
    return Watched(words, _largest(results, "gas_mass_error"), "")


@monitor("gas_inflow_error")
def _asked_inflow(results: Results) -> Watched:
    words = "gas at the inlet against what the case asks for, over the fastest inflow, largest"
    return hold_below(words, _largest(results, "gas_inflow_error"), 1e-6)


@monitor("heat_error")
def _heat(results: Results) -> Watched:
    words = "heat that a step made or lost, over what gas and particles hold, largest"
    return hold_below(words, _largest(results, "heat_error"), _read_limit(results, "monitors", "heat"))


@monitor("displaced_gas_error")
def _displaced(results: Results) -> Watched:
    words = "gas that unequal steps displaced too much or too little between rows, over the solids, largest"
    return Watched(words, _largest(results, "displaced_gas_error"), "small: changes of the step are few")


@monitor("particles_at_outlet")
def _at_outlet(results: Results) -> Watched:
    words = "particles at the outlet, most: it is a wall for them"
    most = int(_largest(results, "particles_at_outlet"))
    return judge(words, most, "0", most == 0)


@monitor("gas_backflow")
def _backflow(results: Results) -> Watched:
    words = "gas that came in by the outlets, over all that passed them, largest between two rows"
    return Watched(words, _largest(results, "gas_backflow"), "0; what comes back has the voidage of the cell there")


@monitor("outlet_backflow")
def _outlet_backflow(results: Results) -> Watched:
    largest = results.history("outlet_backflow").max("time").values
    words = f"the same of outlet {int(largest.argmax()) + 1} alone, which has the largest part"
    parts = ", ".join(f"{part:.3g}" for part in largest.tolist())
    return Watched(words, float(largest.max()), f"0; it is {parts} of the outlets in their order")


@monitor("gas_flux_error")
def _flux(results: Results) -> Watched:
    if not np.isfinite(results.history("gas_flux_error").values).any():
        raise NotDrawableError(["no inflow to compare with."])
    words = "gas flux at a height against continuity over the inflow, largest"
    return hold_below(words, _largest(results, "gas_flux_error"), _read_limit(results, "monitors", "gas_flux"))


@monitor("max_courant")
def _courant(results: Results) -> Watched:
    limit = _read_limit(results, "gas", "max_courant")
    reason = "" if limit is None else f", gas.max_courant = {limit:g} and {OVERSHOOT:.0%}"
    most = None if limit is None else round((1.0 + OVERSHOOT) * limit, 6)
    return hold_below("Courant number, largest", _largest(results, "max_courant"), most, reason)


@monitor("min_voidage")
def _voidage(results: Results) -> Watched:
    least = float(np.nanmin(results.history("min_voidage").values))
    return judge("voidage, least", least, f"above {CLOSEST:g}", least > CLOSEST)


@monitor("cells_over_packed")
def _packed(results: Results) -> Watched:
    most = int(_largest(results, "cells_over_packed"))
    wanted = "0; otherwise spread particles wider: exchange.filter_passes, or a kernel or diffusion_width"
    return judge("cells over the closest packing, most", most, wanted, most == 0)


@monitor("max_overlap")
def _overlap(results: Results) -> Watched:
    words = "overlap of two particles over the diameter, largest"
    return hold_below(words, _largest(results, "max_overlap"), OVERLAP)


@monitor("pressure_drop")
def _support(results: Results) -> Watched:
    weight = results.weight_per_area
    if weight is None:
        raise NotDrawableError(["no weight to put the pressure drop in proportion to."])
    words = "mean steady pressure drop over weight less buoyancy a cross-section"
    steady = summarise(results, "pressure_drop")
    if math.isnan(steady.start):
        return Watched(words, steady.mean / weight, "no mean: start-up not over")
    part = steady.mean / weight
    return judge(words, part, "1 within 3 % if the gas carries the bed", abs(part - 1.0) <= 0.03)


@monitor("gas_flux")
def _inflow(results: Results) -> Watched:
    """Of a mesh from a file the velocity is that of the inlet patch, and the bed may be wider at another height."""
    if results.inlet_speed is None:
        raise NotDrawableError(["no inlet flow."])
    if results.case["domain"].get("shape") == "file":
        raise NotDrawableError(["a mesh has not the inlet's area at every height."])
    if words := _find_change_of_flow(results.case):
        raise NotDrawableError([f"the flow is not the inlet's at every height: {words}."])
    gas = results.case["gas"]
    mean = _find_inflow(results)
    if abs(mean) < FEW * results.inlet_speed:
        raise NotDrawableError(["as much gas flows down as up."])
    layers = results.mean("gas_flux").sel(component="z").mean(["x", "y"]).values / mean
    value = float(layers[np.argmax(np.abs(layers - 1.0))])
    if not is_constant(gas):
        return Watched("mean gas flux at a height over the mean inflow, farthest from 1", value, "near 1")
    words = "mean gas flux at a height over U_f, farthest from 1"
    return judge(words, value, "1 within 1 %", abs(value - 1.0) <= 0.01)


def _find_change_of_flow(case: dict[str, Any]) -> str | None:
    """What makes the flow of gas another one at some height than it is at the inlet: of openings in sides the gas that
    comes and goes there, of particles that come and go the gas they displace, of a gas that is warmed its volume."""
    gas, particles, heat = (case.get(name) or {} for name in ("gas", "particles", "heat"))
    if any(one.get("face", "floor") != "floor" for one in gas.get("inlets") or ()):
        return "gas comes in above the floor"
    if any(one.get("face", "top") != "top" for one in gas.get("outlets") or ()):
        return "gas leaves below the top"
    if particles.get("feeds") or particles.get("outlets"):
        return "particles come or go, and displace gas"
    return "the gas expands as it is warmed" if heat.get("gas_density") == "ideal" else None


def _find_inflow(results: Results) -> float:
    """Mean velocity [m/s] of the inflow over the averaging windows, of a run without any over all of it."""
    gas, windows = results.case["gas"], [window for window in results.windows if window[1] > window[0]]
    if not windows:
        return find_mean(gas, *results.span)
    return sum((end - start) * find_mean(gas, start, end) for start, end in windows) / results.averaged


@monitor("solids_flux")
def _net_flux(results: Results) -> Watched:
    upward = depth_average(results.mean("solids_flux").sel(component="z"))
    largest = float(np.abs(upward).max())
    net = float(np.abs(upward.mean("x")).max()) / largest if largest else 0.0
    return Watched(
        "net vertical solids flux at a height over the largest flux", net, "small: the time mean is long enough"
    )


def find_flux_error(results: Results) -> float:
    """Standard error of the depth-averaged map of vertical solids flux over the map, root mean square.

    Raises: NotDrawableError without blocks to tell it from.
    """
    upward, error = (
        depth_average(field.sel(component="z"))
        for field in (results.mean("solids_flux"), results.error("solids_flux_stderr"))
    )
    part = compare_with_map(upward.values, error.values)
    if math.isnan(part):
        raise NotDrawableError(["no blocks of the vertical flux to compare."])
    return part


@monitor("solids_flux_stderr")
def _settled(results: Results) -> Watched:
    """Bed height and pressure drop may be steady for seconds while the pattern of the flow still turns round."""
    part = find_flux_error(results)
    words = "standard error of the map of vertical solids flux over the map, root mean square"
    return hold_below(words, part, 0.3, ", or the pattern is not settled")


def _read_limit(results: Results, section: str, option: str) -> float | None:
    """A limit of the run's case; results.nc may come from anybody."""
    table = results.case.get(section)
    value = table.get(option) if isinstance(table, dict) else None
    return float(value) if isinstance(value, int | float) else None


def _largest(results: Results, name: str) -> float:
    return float(np.nanmax(results.history(name).values))
