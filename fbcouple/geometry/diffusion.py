"""How fast diffusion goes in the cells of a mesh: what the Fourier number of a step counts."""

from __future__ import annotations

import numpy as np

from fbcouple.geometry.polymesh import PolyMesh


def find_box_rate(edges: np.ndarray, cells: tuple[int, int, int], wraps: tuple[bool, bool, bool]) -> float:
    """The largest of `measure_rates` [1/m2] of a box of `cells` of `edges` (3,) [m] that repeats itself along the axes
    that `wraps` says: of a cell in a corner, which has the centres of its outer faces half as far."""
    sides = [2.0 if around else 4.0 if count == 1 else 3.0 for count, around in zip(cells, wraps, strict=True)]
    return float((np.array(sides) / np.asarray(edges) ** 2).sum())


def measure_rates(mesh: PolyMesh) -> np.ndarray:
    """Of each cell the sum over its faces of their areas over the distance of the centres on both sides, over its
    volume, (cells,) [1/m2]: times viscosity and step its Fourier number, as the gas solver counts it.

    Of an outer face it is the distance from the cell's centre to the face's plane. No face may be periodic.
    """
    inner = len(mesh.neighbour)
    vectors = mesh.find_vectors(np.arange(len(mesh.owner)))
    places = _find_face_centres(mesh)
    centres, volumes = _find_centres(mesh, vectors, places)
    areas = np.linalg.norm(vectors, axis=1)
    gaps = np.empty(len(areas))
    gaps[:inner] = np.linalg.norm(centres[mesh.neighbour] - centres[mesh.owner[:inner]], axis=1)
    outward = np.einsum("ij,ij->i", vectors[inner:], places[inner:] - centres[mesh.owner[inner:]])
    gaps[inner:] = np.abs(outward) / areas[inner:]
    parts = areas / gaps
    return _add_up(mesh, parts, parts[:inner]) / volumes


def _find_face_centres(mesh: PolyMesh) -> np.ndarray:
    """Centre of gravity of each face [m], (faces, 3)."""
    triangles, which = mesh.list_triangles(np.arange(len(mesh.owner)))
    a, b, c = triangles.transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    middles = triangles.mean(axis=1)
    sums = [np.bincount(which, areas * middles[:, axis], len(mesh.owner)) for axis in range(3)]
    return np.stack(sums, axis=1) / np.bincount(which, areas, len(mesh.owner))[:, None]


def _find_centres(mesh: PolyMesh, vectors: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centre of gravity [m] of each cell, (cells, 3), and its volume [m3]: of the pyramids on its faces of area
    `vectors` [m2] and centres `places` [m], (faces, 3), about a point amid these."""
    inner = len(mesh.neighbour)
    faces = _add_up(mesh, np.ones(len(mesh.owner)), np.ones(inner))
    tips = np.stack([_add_up(mesh, axis, axis[:inner]) for axis in places.T], axis=1) / faces[:, None]
    volumes, moments = np.zeros(mesh.count), np.zeros((mesh.count, 3))
    for cells, size, sign in ((mesh.owner, len(mesh.owner), 1.0), (mesh.neighbour, inner, -1.0)):
        tip, place = tips[cells], places[:size]
        parts = sign * np.einsum("ij,ij->i", vectors[:size], place - tip) / 3.0
        volumes += np.bincount(cells, parts, mesh.count)
        middles = 0.75 * place + 0.25 * tip
        moments += np.stack([np.bincount(cells, parts * axis, mesh.count) for axis in middles.T], axis=1)
    return moments / volumes[:, None], volumes


def _add_up(mesh: PolyMesh, of_owners: np.ndarray, of_neighbours: np.ndarray) -> np.ndarray:
    """Of each cell the sum of what its faces have, those that it owns and those it neighbours, (cells,)."""
    sums = np.bincount(mesh.owner, of_owners, mesh.count)
    return np.asarray(sums + np.bincount(mesh.neighbour, of_neighbours, mesh.count))
