"""What a history row holds of the state as it is: numbers over all ranks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fbcouple.case.bed.particle_types import grains_per_parcel, list_species
from fbcouple.geometry.overlap import find_max_overlap
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.frames import track

# Dense bed of the paper: solids fraction above 0.2 (section 4.2).
_DENSE = 0.2
_CLOSEST_PACKING = 0.74048


def measure_particles(sim: Simulation) -> dict[str, Any]:
    """Count, centre, kinetic energy and worst overlap of all particles, and those that the case tracks (collective)."""
    liggghts, comm = sim.liggghts, sim.comm
    masses, z = liggghts.own_masses, liggghts.positions[:, 2]
    squares = np.einsum("ij,ij->i", liggghts.velocities, liggghts.velocities)
    totals = masses.sum(), masses @ z, 0.5 * masses @ squares
    sums = comm.allreduce(np.array(totals))
    tracked = {"tracked": track(sim)} if sim.case.output.tracked else {}
    overlap = find_max_overlap(liggghts.ghost_positions(), liggghts.ghost_radii(), liggghts.count)
    return {
        "particles": as_grains(sim, sim.conservation.particles),
        "solids_centre_z": float(sums[1] / sums[0]) - sim.grid.origin[2] if sums[0] else math.nan,
        "kinetic_energy": float(sums[2]),
        "max_overlap": comm.allreduce(overlap, max),
    } | tracked


def as_grains(sim: Simulation, count: int) -> float:
    """Particles as the case has them that `count` of LIGGGHTS stand for."""
    assert sim.case.particles is not None
    return count * grains_per_parcel(sim.case.particles) if sim.case.particles.coarse_graining else count


def measure_species(sim: Simulation) -> dict[str, Any]:
    """Height [m] above the floor of each species' centre of mass, nan of one that is not there; nothing where all
    particles are of one species (collective)."""
    particles, own = sim.case.particles, sim.liggghts
    if particles is None or not particles.mixture:
        return {}
    count = 1 + len(particles.mixture)
    species = np.array(list_species(particles))[own.types - 1] - 1
    masses = own.own_masses
    mine = [np.bincount(species, weights, count) for weights in (masses, masses * own.positions[:, 2])]
    mass, moment = sim.comm.allreduce(np.array(mine))
    centres = np.divide(moment, mass, out=np.full(count, math.nan), where=mass > 0.0)
    return {"species_centre_z": (centres - sim.grid.origin[2]).tolist()}


def measure_height(sim: Simulation) -> dict[str, Any]:
    """Bed height [m] above the floor, of a mesh its lowest point (collective)."""
    voidage = sim.coupling.voidage if sim.is_coupled else None
    rows, own = sim.rows_inside, sim.liggghts
    profile, heights = sim.cells.find_profile(sim.comm, own.positions[rows], own.radii[rows], voidage)
    return {"bed_height": find_bed_height(profile, heights)}


def measure_voidage(sim: Simulation) -> dict[str, Any]:
    """Solids that the gas sees, beside the particles' own, and the extremes of the voidage (collective)."""
    comm, voidage = sim.comm, sim.coupling.voidage
    solids = comm.allreduce(sim.cells.add_up(1.0 - voidage))
    volume = comm.allreduce(float((4.0 / 3.0 * np.pi * sim.liggghts.radii**3).sum()))
    return {
        "solids_volume": solids,
        "solids_error": abs(solids / volume - 1.0) if volume else abs(solids),
        "voidage_excess": comm.allreduce(float(voidage.max(initial=0.0)), max) - 1.0,
        "min_voidage": comm.allreduce(float(voidage.min(initial=1.0)), min),
        "cells_over_packed": comm.allreduce(int((voidage < 1.0 - _CLOSEST_PACKING).sum())),
    }


def find_weight(sim: Simulation) -> float:
    """Weight of all particles [N]; 1 without gravity."""
    return sim.comm.allreduce(float(sim.liggghts.own_masses.sum())) * sim.case.gravity or 1.0


def find_bed_height(profile: np.ndarray, centres: np.ndarray) -> float:
    """Height [m] of the uppermost layer whose mean solids fraction in `profile` exceeds 0.2, interpolated to the next.

    The paper's dense bed. It is no smooth function of the particles: where bubbles lift a layer off and it thins out to
    0.2, the height jumps down to the next layer that is denser (in a bed of slugs from 103 to 37 mm in one row). What
    must not jump is told by the centre of mass.

    0 if no layer is that dense; the top of the uppermost dense layer's centre if it is the last.
    """
    dense = np.flatnonzero(profile > _DENSE)
    if len(dense) == 0:
        return 0.0
    top = int(dense[-1])
    if top == len(profile) - 1:
        return float(centres[top])
    part = (profile[top] - _DENSE) / (profile[top] - profile[top + 1])
    return float(centres[top] + part * (centres[top + 1] - centres[top]))
