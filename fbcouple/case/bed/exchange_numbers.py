"""Pre-flight numbers of the exchange: the fluid step against response times, cells and kernels against particles."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fbcouple.case.bed.derived import cell_size, dem_step, fastest_inlet
from fbcouple.case.bed.drag_balance import find_drag
from fbcouple.case.bed.fluid_step import coupling_step, gas_step
from fbcouple.case.bed.number import Law, Number, judge
from fbcouple.case.bed.particle_types import find_ratio, largest_diameter, list_kinds, mean_volume
from fbcouple.case.bed.step_limits import Limits
from fbcouple.case.schema.sections import Case

PACKED = 0.42
"""Voidage of a packed bed, where the gas responds fastest."""
STABLE_EXPLICIT = 2.0
"""Step over response time above which an explicit source grows."""

COARSE, ABSURD = 100.0, 1000.0
"""Cell sizes over the diameter: above the first a cell tells little of a bed, above the second a length is no meter."""


def response_times(case: Case, law: Law | None = None, voidage: float = PACKED) -> dict[str, float]:
    """Response times [s] of the gas, tau_g = eps rho/(n beta), and of the particles, tau_p = m/beta, the shortest of a
    mixture, in a bed of `voidage` that the fastest inlet flows through."""
    assert case.gas is not None and case.particles is not None
    slip = fastest_inlet(case.gas) / voidage
    kinds = list_kinds(case.particles)
    drags = [find_drag(case, voidage, slip, law, kind) for kind in kinds]
    per_particle = sum(kind.share * beta for kind, beta in zip(kinds, drags, strict=True))
    return {
        "tau_g": voidage * case.gas.density * mean_volume(case.particles) / ((1.0 - voidage) * per_particle),
        "tau_p": min(kind.mass / beta for kind, beta in zip(kinds, drags, strict=True)),
    }


def time_exchange(case: Case, law: Law | None, limits: Limits | None) -> Iterator[Number]:
    assert case.gas is not None and case.particles is not None and case.exchange is not None
    step = coupling_step(case, limits) if case.contact else gas_step(case, limits=limits)
    for name, time in response_times(case, law).items():
        limit = f"below {STABLE_EXPLICIT:g} (explicit drag)" if case.exchange.scheme == "explicit" else None
        verdict = judge(step / time < STABLE_EXPLICIT, "unfit") if limit else None
        whose = "gas" if name == "tau_g" else "particles"
        meaning = f"Fluid step over the response time of the {whose} in a packed bed, {time:.3g} s."
        yield Number(f"fluid step/{name}", step / time, "1", limit, verdict, meaning)
    if case.contact:
        held = gas_step(case, limits=limits) / dem_step(case.contact, case.particles)
        meaning = "DEM steps in a fluid step; below 1 the step is a DEM step, longer than the gas wants it."
        if held < 2.0:
            meaning = f"{meaning} One: the gas, solved every DEM step, is what costs; larger cells let it take more."
        yield Number("DEM steps per fluid step", held, "1", "at least 1", judge(held >= 1.0), meaning)


def measure_cells(case: Case, cell: np.ndarray) -> Iterator[Number]:
    assert case.particles is not None and case.exchange is not None
    wanted = 1.0 if case.exchange.filter_passes else 3.0
    limit = f"{wanted:g} to {COARSE:g} ({'with' if case.exchange.filter_passes else 'without'} filter)"
    full = (math.pi / 6.0) ** (1.0 / 3.0)
    if width := case.exchange.kernel_width or case.exchange.diffusion_width:
        yield from _measure_spread(case, width)
        return
    for axis, size in zip("xyz", cell / largest_diameter(case.particles), strict=True):
        verdict = judge(wanted <= size <= COARSE, "warn" if full < size <= ABSURD else "unfit")
        meaning = (
            f"Cell size over diameter along {axis}; a cube of {full:.2f} is filled by one particle. Smaller: give "
            f"{_list_filters(case)}. Thousands: a length is not in m (domain.scale for a mesh)."
        )
        if axis != "x":
            meaning = f"Cell size over diameter along {axis}; as along x."
        if case.particles.coarse_graining:
            meaning = meaning.replace("over diameter", "over the diameter of the largest parcels")
        yield Number(f"cell size {axis}", float(size), "d", limit, verdict, meaning)


def _list_filters(case: Case) -> str:
    """What spreads particles over small cells of the case's region."""
    if case.domain.is_plain_box:
        return "exchange.filter_passes, exchange.diffusion_width or a gaussian kernel"
    return "exchange.filter_passes"


def _measure_spread(case: Case, width: float) -> Iterator[Number]:
    """The kernel, not the cell, says over what a particle is spread: cells may be small, and should be."""
    assert case.particles is not None
    diameter = find_ratio(case.particles) * case.particles.diameter
    for axis, size in zip("xyz", cell_size(case) / diameter, strict=True):
        meaning = (
            f"The bandwidth over the cell size along {axis}; below 1 the cells spread a particle more than it does."
        )
        verdict = judge(width >= size, "warn" if size <= ABSURD else "unfit")
        yield Number(f"width {axis}", width / float(size), "cells", "at least 1", verdict, meaning)
