"""Size and sampling grid of a mesh from a file, where the case leaves them out: the mesh says both."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.region import find_imported, find_spacing
from fbcouple.case.problems import Problem
from fbcouple.case.schema.gas import FROM_MESH, Domain
from fbcouple.errors import CaseError
from fbcouple.geometry.polyhedra import find_centres
from fbcouple.geometry.polymesh import PolyMesh

_SAME_PLACE = 1e-6
"""Part of the box within which two coordinates of points are one."""
_EVEN = 1e-3
"""Part of a layer by which layers, and the centres of cells in them, may be off."""
_MOST_ALONG = 1000
"""Cells of the sampling grid along an axis: a mesh of a few cells in a large box is sampled no finer."""


def adopt_box(raw: dict[str, Any], base_folders: Sequence[Path]) -> list[Problem]:
    """Fill `domain.size` and `domain.cells` in `raw`, a case file's content, from the mesh that it names and that lies
    in the first of `base_folders` that has it; what the case gives itself stays, and what it gives wrongly is told
    elsewhere.

    Returns: what is wrong with the mesh; then nothing is filled in.
    """
    domain = raw.get("domain")
    if not isinstance(domain, dict) or domain.get("shape") != "file" or all(key in domain for key in FROM_MESH):
        return []
    name, scale = domain.get("mesh"), domain.get("scale")
    if not isinstance(name, str) or not (scale is None or (type(scale) in (int, float) and 0.0 < scale <= 1e9)):
        return []
    folder = next((base_folder for base_folder in base_folders if (base_folder / name).exists()), base_folders[0])
    try:
        mesh = find_imported(Domain.model_construct(mesh=name, scale=scale), folder).mesh
    except CaseError as error:
        return [Problem("domain.mesh", problem) for problem in error.problems]
    found = {"size": (mesh.high - mesh.low).tolist(), "cells": choose_cells(mesh)}
    raw["domain"] = {**{key: found[key] for key in FROM_MESH}, **domain}
    return []


def choose_cells(mesh: PolyMesh) -> list[int]:
    """Cells of the sampling grid along each axis: those of a block of cells in rows; of a mesh in equal layers these,
    and squares as large as a mean cell of a layer; else cubes as large as a mean cell of the mesh."""
    size = mesh.high - mesh.low
    rounded = np.rint((mesh.points - mesh.low) / (_SAME_PLACE * size))
    levels = [np.unique(rounded[:, axis]) for axis in range(3)]
    rows = [len(found) for found in levels]
    if int(np.prod(rows)) <= len(mesh.points) and int(np.prod(rows)) == len(np.unique(rounded, axis=0)):
        return [count - 1 for count in rows]
    cells = np.clip(np.rint(size / find_spacing(mesh.volume, mesh.count)), 1, _MOST_ALONG).astype(int)
    if _is_layered(mesh, levels[2]):
        layers = rows[2] - 1
        across = math.sqrt(mesh.volume * layers / (mesh.count * size[2]))
        cells[:2] = np.clip(np.rint(size[:2] / across), 1, _MOST_ALONG)
        cells[2] = layers
    return cells.tolist()


def _is_layered(mesh: PolyMesh, levels: np.ndarray) -> bool:
    """Are all cells prisms, of whatever base, between the equal steps of `levels`, (layers + 1,)?"""
    layers = len(levels) - 1
    if layers > _MOST_ALONG or mesh.count % layers or np.ptp(np.diff(levels)) > _EVEN * np.diff(levels).mean():
        return False
    height = mesh.high[2] - mesh.low[2]
    middles = layers * (find_centres(mesh)[:, 2] - mesh.low[2]) / height - 0.5
    return bool(np.abs(middles - np.rint(middles)).max() < _EVEN)
