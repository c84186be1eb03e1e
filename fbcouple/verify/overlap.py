"""The spring that a case asks for by `contact.max_overlap`: spheres of LIGGGHTS overlap so far at the speed meant, and
get so fast."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.adopt_spring import adopt_spring
from fbcouple.case.bed.derived import dem_step
from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.speeds import list_speeds
from fbcouple.case.schema.particles import Contact
from fbcouple.case.schema.sections import Case
from fbcouple.verify.harness import BOX, FRICTIONLESS, GLASS, open_bench, open_case
from fbcouple.verify.impact import look, throw
from fbcouple.verify.registry import Number, check

_STEPS = 200
_GAP = 1e-9
_FALL, _LOOK = 0.1, 20
"""Time [s] in which a lattice of 36 mm falls, and DEM steps between two looks at it."""
_HERTZ: dict[str, Any] = {"model": "hertz", "poisson_ratio": 0.25, "restitution": 1.0, "wall_restitution": 1.0}
_MODELS: dict[str, dict[str, Any]] = {"hooke": {"restitution": 0.8}, "hertz": _HERTZ}
"""Contacts; of Hertz an elastic one, for which the largest overlap has a formula."""


def _join(found: dict[str, list[Number]]) -> Iterator[Number]:
    for numbers in found.values():
        yield from numbers


@check("max-overlap", variants=("hooke 0.02", "hooke 0.1", "hertz 0.02", "hertz 0.1"), judge=_join)
def max_overlap(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """A head-on contact at the speed of a fall over the bed's height, within 0.5 % of the overlap asked for."""
    model, wanted = variant.split()
    contact = FRICTIONLESS | _MODELS[model] | {"max_overlap": float(wanted), "steps_per_contact": _STEPS}
    bed = {"title": "verify", "end_time": 1.0, "domain": BOX, "particles": GLASS | {"count": 5000}, "start": {}}
    case, _ = adopt_spring(Case.model_validate(bed | {"contact": contact}))
    assert case.contact is not None
    ((_, speed, _),) = list_speeds(case, find_region(case), None, Path())
    found = _collide(folder, comm, case.contact, speed)
    yield Number(f"{model}, overlap over diameter", found, float(wanted), 0.005, relative=True)


def _collide(folder: Path, comm: MPI.Comm, contact: Contact, speed: float) -> float:
    """Largest overlap, over the diameter, of two spheres that meet head on at the relative `speed` [m/s]."""
    diameter = GLASS["diameter"]
    positions = np.array([[0.01, 0.01, 0.01], [0.01, 0.01, 0.01 + diameter + _GAP]])
    sections = {"gravity": 0.0, "contact": contact.model_dump(exclude_none=True)}
    liggghts = open_bench(folder, comm, sections, positions).liggghts
    assert liggghts is not None
    throw(liggghts, np.array([[0.0, 0.0, speed / 2], [0.0, 0.0, -speed / 2]]))
    largest = 0.0
    for _ in range(_STEPS):
        liggghts.advance(1)
        lower, upper = look(liggghts).positions[:, 2]
        largest = max(largest, diameter - (upper - lower))
    return largest / diameter


@check("lattice-fall")
def lattice_fall(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A start lattice of three diameters falls together: its fastest particle gets as fast as is meant, within 5 %."""
    column = {"size": [0.004, 0.004, 0.04], "cells": [1, 1, 10]}
    particles = GLASS | {"count": 12}
    contact = FRICTIONLESS | {"restitution": 0.3, "wall_restitution": 0.3}  # what bounces could throw others up
    sections = {"domain": column, "particles": particles, "contact": contact, "start": {"spacing": 3.0, "jitter": 0.9}}
    case = Case.model_validate({"title": "verify", "end_time": 1.0} | sections)
    ((_, speed, _),) = list_speeds(case, find_region(case), None, Path())
    liggghts = open_case(folder, comm, case).liggghts
    assert liggghts is not None and case.contact is not None and case.particles is not None
    fastest = 0.0
    for number in range(math.ceil(_FALL / dem_step(case.contact, case.particles) / _LOOK)):
        liggghts.advance(_LOOK, first=not number)
        fastest = max(fastest, float(np.linalg.norm(liggghts.velocities, axis=1).max()))
    yield Number("speed of the fastest particle", fastest, speed, 0.05, "m s-1", relative=True)
