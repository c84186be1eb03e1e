"""The numbers that the templates show: all arithmetic of the decks is here, none is in a template."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed import derived
from fbcouple.case.bed.contact_coefficients import find_pair, find_wall
from fbcouple.case.bed.gas_heat import is_inlet_hot_wall
from fbcouple.case.bed.outlets import find_depth, list_openings
from fbcouple.case.bed.particle_types import Kind, largest_diameter, list_kinds
from fbcouple.case.bed.region import Region, find_openings, find_region, read_mesh
from fbcouple.case.bed.streams import list_outlets, list_streams, list_tables
from fbcouple.case.schema.gas import Gas
from fbcouple.case.schema.particles import Contact, Particles
from fbcouple.case.schema.sections import Case
from fbcouple.decks.conduction import describe_conduction
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.sides import SIDES
from fbcouple.physics.contact import normal_damping

# DIC-preconditioned CG is fastest below this many cells, multigrid above (measured on the three Patil meshes).
_MULTIGRID_FROM = 10_000
# DEM steps after which particles are put in the order of the neighbour bins, so that neighbours lie together in memory.
_SORT_EVERY = 200
# Names in the adapter's table of LES models (turbulence.cpp).
_LES_MODELS = {
    "smagorinsky": "Smagorinsky",
    "keqn": "kEqn",
    "dynamic-lagrangian": "dynamicLagrangian",
    "localized-dynamic": "localizedDynamic",
}
# The Lagrangian averages of L:M and M:M start as those of gas at 1 mm/s with Smagorinsky's C_s = 0.16, which is
# C = sqrt(2) C_s^2 (Meneveau et al. 1996): once the gas moves nothing of it is left.
_START_MM = 1e-12
_START_LM = math.sqrt(2.0) * 0.16**2 * _START_MM


# Faces of the block in blockMeshDict at the low and the high end of an axis.
_SIDES = {"x": ("(0 4 7 3)", "(1 2 6 5)"), "y": ("(0 1 5 4)", "(3 7 6 2)")}


def build_context(case: Case, needs: dict[str, bool], folder: Path = Path()) -> dict[str, Any]:
    """Everything the templates of this case, whose own files lie in `folder`, may name."""
    context: dict[str, Any] = {"case": case, "needs": needs}
    if case.gas:
        context |= _gas_context(case, case.gas, find_region(case, folder), needs)
        context["oblique_faces"] = needs["mesh_of_polyhedra"] and not _is_rectilinear(case, folder)
        if needs["openings"]:
            context["streams"] = _list_streams(case, folder)
    if case.particles and case.contact:
        context |= _grains_context(case.particles, case.contact)
        context["boundary"] = " ".join("p" if wrapped else "f" for wrapped in derived.wraps(case.domain))
    if needs["contact_conduction"]:
        # With newton on LIGGGHTS' fix for conduction adds up an array that it does not have, and ends.
        context |= describe_conduction(case, folder) | {"newton": "off"}
    if needs["empty_start"]:
        mesh = None if case.domain.shape == "box" else read_mesh(case, folder)
        context["box"] = find_box(case, mesh).T.ravel().tolist()
    return context


def _is_rectilinear(case: Case, folder: Path) -> bool:
    """Is the mesh from a file one of bricks along the axes, for which the gas has the schemes of a box?"""
    return case.domain.shape == "file" and read_mesh(case, folder).is_rectilinear


def find_box(case: Case, mesh: PolyMesh | None) -> np.ndarray:
    """The box of the particles [m], (2, 3): the region's own, or one that holds all of the surface of `mesh`, with the
    space behind its openings."""
    openings = list_openings(case)
    if mesh is None or case.domain.shape == "box":
        box = np.array([np.zeros(3), case.domain.size])
        for outlet in openings:
            axis, end = SIDES[outlet.face or "floor"]
            level, depth = case.domain.size[axis] * end, find_depth(case, outlet)
            box[end, axis] = max(box[1, axis], level + depth) if end else min(box[0, axis], -depth)
        return box
    least = largest_diameter(case.particles) if case.particles else 0.0
    margin = max([least, *(find_depth(case, outlet) for outlet in openings)])
    return np.array([mesh.low - margin, mesh.high + margin])


def _gas_context(case: Case, gas: Gas, region: Region, needs: dict[str, bool]) -> dict[str, Any]:
    context: dict[str, Any] = {
        "kinematic_viscosity": gas.viscosity / gas.density,
        "open_velocity": derived.inlet_ramp(gas)[0][1] * derived.open_share(case),
        "start_velocity": _find_start_velocity(gas, region),
        "outlet": '"outlet[0-9]+"' if needs["openings"] and len(list_outlets(case)) > 1 else "outlet",
        "has_walls": needs["openings"] or len(case.domain.periodic) < len(_SIDES),
        "wall_faces": [face for axis, faces in _SIDES.items() if axis not in case.domain.periodic for face in faces],
        "cyclic_faces": {axis: faces for axis, faces in _SIDES.items() if axis in case.domain.periodic},
        "multigrid": region.cells >= _MULTIGRID_FROM,
        "first_step": 1e-6,
        "inlet_rows": list_tables(case)[0],
    }
    if gas.turbulence != "none":
        context |= {"les_model": _LES_MODELS[gas.turbulence], "start_lm": _START_LM, "start_mm": _START_MM}
    if needs["gas_heat"]:
        context["hot_inlet"] = is_inlet_hot_wall(case)
    if gas.top == "closed":
        context["top_point"] = _find_top_point(case)
    if gas.closed_nozzle:
        context["nozzle"] = _nozzle_box(case, gas.closed_nozzle)
    return context


def _list_streams(case: Case, folder: Path) -> list[dict[str, Any]]:
    """Rows of each stream through open faces, its part of each face of the inlet, and its temperature."""
    shares = find_openings(case, folder).shares.tolist()
    moving = [(stream, parts) for stream, parts in zip(list_streams(case), shares, strict=True) if not stream.is_closed]
    if not moving:  # an inlet without faces
        moving = [(list_streams(case)[0], [])]
    start = case.heat.gas_temperature if case.heat else None
    return [
        {"rows": stream.rows, "shares": parts, "temperature": stream.temperature or start} for stream, parts in moving
    ]


def _find_start_velocity(gas: Gas, region: Region) -> float:
    """Vertical velocity [m/s] that the gas starts with: the mean one of the column, 0 with an inlet in its side."""
    upward = region.direction[2] * region.inlet / region.section
    return derived.inlet_ramp(gas)[0][1] * (1.0 if region.surface is None else upward)


def _find_top_point(case: Case) -> tuple[float, ...]:
    """Centre [m] of a cell in the middle of the uppermost layer."""
    nx, ny, nz = case.domain.cells
    index = (nx // 2, ny // 2, nz - 1)
    return tuple(float((n + 0.5) * length) for n, length in zip(index, derived.cell_size(case), strict=True))


def _nozzle_box(case: Case, closed: tuple[int, int]) -> dict[str, float]:
    """Corners of a box [m] around the middle `closed` faces of the floor, half a cell off every face centre."""
    spacing = derived.cell_size(case)
    low = [(case.domain.cells[axis] - closed[axis]) // 2 * spacing[axis] for axis in (0, 1)]
    high = [low[axis] + closed[axis] * spacing[axis] for axis in (0, 1)]
    half = spacing[2] / 2
    return {"x0": low[0], "y0": low[1], "x1": high[0], "y1": high[1], "z0": -half, "z1": half}


def _grains_context(particles: Particles, contact: Contact) -> dict[str, Any]:
    """What every contact law shares: the step, neighbour lists as they are fastest with and without history, tables."""
    step = derived.dem_step(contact, particles)
    remembers = derived.tangential_law(contact) == "history"
    kinds = list_kinds(particles)
    skin = derived.neighbour_skin(contact, particles)
    context: dict[str, Any] = {
        "dem_step": step,
        "normal_model": "hertz" if contact.model == "hertz" else "hooke/stiffness",
        "tangential_model": "history" if remembers else "no_history",
        "newton": "off" if remembers else "on",
        "skin": skin,
        "bin_size": max(kind.diameter for kind in kinds) + skin,
        "sort_every": _SORT_EVERY,
        "types": len(kinds) + 1,
        "kinds": [(kind.diameter, kind.density) for kind in kinds],
        "rolling_frictions": [contact.rolling_friction] * (len(kinds) + 1) ** 2,
        "restitutions": _tabulate(
            kinds, lambda a, b: find_pair(contact, a, b).restitution, lambda a: find_wall(contact, a).restitution
        ),
        "frictions": _tabulate(
            kinds, lambda a, b: find_pair(contact, a, b).friction, lambda a: find_wall(contact, a).friction
        ),
    }
    if contact.model == "hertz":
        moduli = {"youngs_moduli": contact.youngs_modulus, "poisson_ratios": contact.poisson_ratio}
        return context | {name: [value] * (len(kinds) + 1) for name, value in moduli.items()}
    return context | _spring_context(particles, contact)


def _tabulate(kinds: list[Kind], pair: Callable[[Kind, Kind], float], wall: Callable[[Kind], float]) -> list[float]:
    """A symmetric LIGGGHTS table of all types, row by row: the kinds, and last the walls, which never meet."""
    rows = [[*(pair(one, other) for other in kinds), wall(one)] for one in kinds]
    rows.append([*(wall(kind) for kind in kinds), wall(kinds[0])])
    return [value for row in rows for value in row]


def _spring_context(particles: Particles, contact: Contact) -> dict[str, Any]:
    """Linear springs as LIGGGHTS wants them: gamman = 2 gamma_n [1/s] of each pair of kinds and of walls (eqs 17-18).

    Without history gammat is the viscous limit of Coulomb friction, with history the dashpot beside its spring.
    """

    def damp_pair(one: Kind, other: Kind) -> float:
        restitution, mass = find_pair(contact, one, other).restitution, derived.effective(one.mass, other.mass)
        return 2 * normal_damping(derived.find_spring(contact, one), mass, restitution)

    def damp_wall(kind: Kind) -> float:
        stiffness = derived.find_spring(contact, kind)
        return 2 * normal_damping(stiffness, kind.mass, find_wall(contact, kind).restitution)

    kinds = list_kinds(particles)
    damping, stiffness = _tabulate(kinds, damp_pair, damp_wall), derived.find_spring(contact, kinds[0])
    if derived.tangential_law(contact) == "history":
        ratio = derived.tangential_damping(contact)
        spring, tangential = derived.tangential_stiffness(contact) * stiffness, [ratio * g for g in damping]
    else:
        spring, tangential = 0.0, [derived.viscous_limit(contact, particles)] * len(damping)
    springs = {"stiffnesses": [stiffness] * len(damping), "tangential_springs": [spring] * len(damping)}
    return springs | {"dampings": damping, "tangential_dampings": tangential}
