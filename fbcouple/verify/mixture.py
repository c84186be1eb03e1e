"""Beds of several sizes and materials: impacts of unequal spheres, and the drag of each in a bed of two sizes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.contact_coefficients import find_pair, find_wall
from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.schema.particles import Contact, Particles
from fbcouple.physics.drag.polydisperse import size_factor
from fbcouple.physics.jit import compiled
from fbcouple.physics.mixing import find_lacey_index
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, open_bench
from fbcouple.verify.impact import look, throw
from fbcouple.verify.lattice import VOIDAGES, HeldBed
from fbcouple.verify.published import PUBLISHED, Bed
from fbcouple.verify.registry import Number, check

_SPECIES: dict[str, Any] = GLASS | {
    "mixture": [[0.6e-3, 7800.0, 0.3], [1.5e-3, 900.0, 0.3]],
    "fractions": "number",
}
_CONTACT: dict[str, Any] = FRICTIONLESS | {
    "steps_per_contact": 200,
    "pairs": [[1, 1, 0.95, 0.0], [1, 2, 0.9, 0.0], [1, 3, 0.8, 0.0], [2, 3, 0.7, 0.0], [3, 3, 0.6, 0.0]],
    "walls": [[2, 0.85, 0.0], [3, 0.5, 0.0]],
}
_SPEED, _EDGE = 1.0, 0.02


@check("impact-mixture")
def impact_mixture(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Every pair of three species head on, and each against the floor: e of the pair, and momentum kept."""
    contact, particles = Contact.model_validate(_CONTACT), Particles.model_validate(_SPECIES | {"count": 15})
    kinds = list_kinds(particles)
    pairs = list(combinations_with_replacement(range(len(kinds)), 2))
    chosen = [*(kind for pair in pairs for kind in pair), *range(len(kinds))]
    positions, velocities = np.full((len(chosen), 3), _EDGE / 2), np.zeros((len(chosen), 3))
    for n, (a, b) in enumerate(pairs):
        positions[2 * n : 2 * n + 2, 0] = (n + 1) * _EDGE / (len(pairs) + 1)
        gap = 1e-6 + (kinds[a].diameter + kinds[b].diameter) / 2
        positions[2 * n : 2 * n + 2, 2] = [_EDGE / 2 - gap / 2, _EDGE / 2 + gap / 2]
        velocities[2 * n : 2 * n + 2, 2] = [_SPEED / 2, -_SPEED / 2]
    for n, kind in enumerate(kinds):
        positions[n - 3] = [(n + 1) * _EDGE / 4, _EDGE / 4, kind.diameter / 2 + 1e-6]
        velocities[n - 3, 2] = -_SPEED
    domain = {"size": [_EDGE] * 3, "cells": [4, 4, 4]}
    species = _SPECIES | {"mixture": _fit_shares(particles, np.bincount(chosen))}
    sections = {"gravity": 0.0, "domain": domain, "contact": _CONTACT, "particles": species}
    liggghts = open_bench(folder, comm, sections, positions, kinds=np.array(chosen)).liggghts
    assert liggghts is not None
    throw(liggghts, velocities)
    # The slowest contact, of the heaviest with the floor, takes 3.5 times as long as the shortest.
    liggghts.advance(round(4.5 * _CONTACT["steps_per_contact"]))
    found = look(liggghts).velocities[:, 2]
    for n, (a, b) in enumerate(pairs):
        low, high = found[2 * n : 2 * n + 2]
        expected = find_pair(contact, kinds[a], kinds[b]).restitution
        yield Number(f"restitution of species {a + 1} and {b + 1}", float(high - low) / _SPEED, expected, 0.002)
        before, after = kinds[a].mass - kinds[b].mass, kinds[a].mass * low + kinds[b].mass * high
        total = kinds[a].mass + kinds[b].mass
        name = f"velocity of their centre, {a + 1} and {b + 1}"
        yield Number(name, float(after / total), _SPEED / 2 * before / total, 1e-9, "m s-1")
    for n, kind in enumerate(kinds):
        expected = find_wall(contact, kind).restitution
        yield Number(f"restitution of species {n + 1} and floor", float(found[n - 3]) / _SPEED, expected, 0.002)


def _fit_shares(particles: Particles, counts: np.ndarray) -> list[list[float]]:
    """The rows of the mixture with the fractions that give these counts."""
    rows = zip(particles.mixture, counts[1:].tolist(), strict=True)
    return [[diameter, density, count / int(counts.sum())] for (diameter, density, _), count in rows]


_SMALLER = 0.6e-3
"""The second diameter of the held beds [m]."""


@check("fixed-bed-mixture")
def fixed_bed_mixture(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A held lattice of spheres of 1 and 0.6 mm: each adds the drag of its own size at the common voidage, 1 %."""
    law, sizes = "huilin-gidaspow", (GLASS["diameter"], _SMALLER)
    bed = HeldBed(folder, comm, law, 0.5, second=_SMALLER)
    off = np.abs(bed.found_voidages - bed.voidages[:, None]).max()
    yield Number("voidage, cell farthest off", float(off), 0.0, 1e-12)
    for speed in (0.1, 1.0):
        bed.flow(np.full(len(VOIDAGES), speed))
        for eps, parts, loss in zip(bed.voidages.tolist(), bed.parts, bed.pressure_losses, strict=True):
            beds = [Bed(eps, speed, size, GAS["density"], GAS["viscosity"]) for size in sizes]
            # Published is the loss of a bed of one size; a size that fills a part of the solids adds that part of it.
            expected = sum(
                PUBLISHED[law](one) * float(part) / (1.0 - eps) for one, part in zip(beds, parts, strict=True)
            )
            name = f"dP/L at voidage {eps:.3f}, {speed} m/s"
            yield Number(name, float(loss), expected, 0.01, "Pa m-1", relative=True)


@check("fixed-bed-polydisperse")
def fixed_bed_polydisperse(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """The same lattice under the drag at the mean diameter of its cells times the factor of Beetstra et al.: its
    pressure loss is the sum over both sizes of part/y^2 times factor of y, of what spheres of the mean lose."""
    law, sizes = "huilin-gidaspow", np.array([GLASS["diameter"], _SMALLER])
    bed = HeldBed(folder, comm, law, 0.5, second=_SMALLER, polydisperse="beetstra")
    for speed in (0.1, 1.0):
        bed.flow(np.full(len(VOIDAGES), speed))
        for eps, parts, loss in zip(bed.voidages.tolist(), bed.parts, bed.pressure_losses, strict=True):
            shares = parts / parts.sum()
            mean = 1.0 / float((shares / sizes).sum())
            y = sizes / mean
            factor = eps * y + (1.0 - eps) * y**2 + 0.064 * eps * y**3
            of_mean = PUBLISHED[law](Bed(eps, speed, mean, GAS["density"], GAS["viscosity"]))
            name = f"dP/L at voidage {eps:.3f}, {speed} m/s"
            yield Number(name, float(loss), of_mean * float((shares / y**2 * factor).sum()), 0.001, "Pa m-1", True)


@check("polydisperse-factor")
def polydisperse_factor(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """The factor at a voidage of 0.5 (numbers worked out by hand from its formula)."""
    for y, expected in ((0.5, 0.379), (0.8, 0.736384), (1.0, 1.032), (1.25, 1.46875), (2.0, 3.256)):
        yield Number(f"factor at d/<d> = {y}", float(_find_factor(0.5, y)), expected, 1e-12)


@compiled
def _find_factor(eps, ratio):
    return size_factor(eps, ratio)


@check("mixing")
def mixing(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Lacey's index of 20 000 particles in 1000 samples: apart, mixed by chance, and in samples of a quarter and three
    quarters in turn, for which Lacey's formula is worked out by hand."""
    samples = np.repeat(np.arange(1000), 20)
    yield Number("index of two halves apart", find_lacey_index(samples < 500, samples), 0.0, 1e-14)
    draw = np.random.default_rng(1).permuted(np.tile(samples < 500, (100, 1)), axis=1)
    found = [find_lacey_index(marked, samples) for marked in draw]
    yield Number("index of halves that are mixed by chance, mean of 100", float(np.mean(found)), 1.0, 1e-3)
    quarters = np.tile(np.arange(20), 1000) < np.where(samples % 2, 5, 15)
    by_hand = (0.25 - 0.0625) / (0.25 - 0.25 / 20.0)
    yield Number("index of quarters and three quarters in turn", find_lacey_index(quarters, samples), by_hand, 1e-4)
