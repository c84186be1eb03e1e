"""Inlets on the mesh: a face has one velocity, that of the gas which its inlets let in by it over all of its area, so
that what is narrower than the cells comes in slower than the case says."""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import numpy as np

from fbcouple.case.bed.derived import open_range
from fbcouple.case.bed.inlet_profile import read_profiles
from fbcouple.case.bed.openings import Openings, open_mesh
from fbcouple.case.bed.region import SHAPES, find_openings
from fbcouple.case.bed.streams import FLOOR, Rows, Stream, find_outline, list_streams
from fbcouple.case.schema.gas import Domain
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.block import make_hexahedra
from fbcouple.geometry.plane_cover import Circle, Shape
from fbcouple.geometry.sides import list_polygons
from fbcouple.geometry.velocity_profile import Profile
from fbcouple.results.inlet_speed import find_after, find_before

_TIMES_AT_ONCE = 1000
_LEAST = 1e-9
"""Part of a face below which an inlet does not have it, and of the width of a side within which it ends there."""
_PATCHES = 32
"""Parts along each side of a rectangle that the square of its profile is averaged over."""


def find_jet_range(case: Case, folder: Path | None) -> tuple[float, float]:
    """Least and largest superficial velocity [m/s] through a face of the inlet in the whole run: of inlets that have
    shapes as the faces of the mesh have it, otherwise that of open faces as the case says.

    folder: where the case's own files lie; without one inlets in sides, and those whose profile is in a file, count as
    the case says. Raises: CaseError (one text, without the key) if a file cannot be read.
    """
    assert case.gas is not None
    streams = list_streams(case)
    if not case.gas.inlets or all(stream.opening.shape is None for stream in streams):
        return open_range(case)
    on_floor = all(stream.opening.face == FLOOR for stream in streams)
    if folder is None and not (on_floor and all(inlet.profile_file is None for inlet in case.gas.inlets)):
        return open_range(case)
    streams = read_profiles(case, streams, folder or Path())
    openings = _open_floor(case.domain, streams) if on_floor else find_openings(case, folder or Path())
    return _find_range(openings, tuple(stream.rows for stream in streams))


@lru_cache(maxsize=2)
def _open_floor(domain: Domain, streams: tuple[Stream, ...]) -> Openings:
    """What streams through the floor have of its faces, of one layer of the mesh."""
    across, along, _ = domain.cells
    part = domain.model_copy(update={"cells": (across, along, 1)})
    mesh = make_hexahedra(part.size, part.cells) if domain.is_plain_box else SHAPES[domain.shape](part, Path())
    return open_mesh(mesh, streams, ())


@lru_cache(maxsize=2)
def _find_range(openings: Openings, rows: tuple[Rows, ...]) -> tuple[float, float]:
    shares = np.unique(openings.shares, axis=1)
    if not shares.size:  # all inlets are closed
        return 0.0, 0.0
    times = sorted({time for of_one in rows for time, _ in of_one})
    sides = [[find(of_one, time) for of_one in rows] for time in times for find in (find_before, find_after)]
    velocities = np.unique(np.array(sides), axis=0)
    parts = [velocities[first : first + _TIMES_AT_ONCE] @ shares for first in range(0, len(velocities), _TIMES_AT_ONCE)]
    return min(float(part.min()) for part in parts), max(float(part.max()) for part in parts)


def count_across(domain: Domain, streams: tuple[Stream, ...], openings: Openings, number: int) -> float:
    """Faces across the shape of stream `number` where it is narrowest; what reaches from side to side is not counted:
    inf of a shape that does so both ways."""
    opening = streams[number].opening
    assert opening.shape is not None
    outline = find_outline(domain, opening.face)
    room = _LEAST * np.ptp(outline, axis=0)
    low, high = opening.shape.bounds
    whole = (low <= outline.min(axis=0) + room) & (high >= outline.max(axis=0) - room)
    faces = openings.mesh.list_patch("inlet")[openings.shares[number] > _LEAST]
    polygons = list_polygons(openings.mesh, faces, opening.face)
    if whole.all() or not polygons:
        return math.inf
    widths = np.mean([np.ptp(polygon, axis=0) for polygon in polygons], axis=0)
    return float(((high - low) / widths)[~whole].min())


def compare_momentum(streams: tuple[Stream, ...], openings: Openings, number: int) -> float:
    """Momentum flux through the faces that stream `number` has a part of when it is fastest, over that which the case
    gives there."""
    faces = openings.shares[number] > _LEAST
    vectors = openings.mesh.find_vectors(openings.mesh.list_patch("inlet")[faces])
    areas, shares = np.linalg.norm(vectors, axis=1), openings.shares[:, faces]
    time, fastest = max(streams[number].rows, key=lambda row: abs(row[1]))
    velocities = np.array([find_after(stream.rows, time) for stream in streams])
    velocities[number] = fastest
    squares = np.array([_find_mean_square(stream) for stream in streams]) * velocities**2
    return float(areas @ (velocities @ shares) ** 2) / float(areas @ (squares @ shares))


def _find_mean_square(stream: Stream) -> float:
    """Mean square of the velocity over the shape of a stream, over the square of its mean."""
    shape = stream.opening.shape
    if stream.is_flat or shape is None:
        return 1.0
    if stream.profile == "parabolic":
        return 4.0 / 3.0 if isinstance(shape, Circle) else 1.44
    assert not isinstance(stream.profile, str)
    return _average_square(stream.profile, shape)


def _average_square(profile: Profile, shape: Shape) -> float:
    """Mean of the square of a profile over its shape, by small rectangles."""
    low, high = shape.bounds
    edges = (high - low) / _PATCHES
    corners = edges * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    places = [low + edges * (n, m) for n in range(_PATCHES) for m in range(_PATCHES)]
    flows = np.array([profile.integrate(place + corners) for place in places])
    return float((flows**2).sum()) / (shape.area * float(edges.prod()))
