"""A mesh of a real mesher passes the checks of the box: a held bed, and a bed that fluidizes.

meshes/column.msh is gmsh's: prisms below, tetrahedra above, about its own axis; column.geo beside it says how it came.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mpi4py import MPI

from fbcouple.case.bed.region import read_mesh
from fbcouple.case.schema.sections import Case
from fbcouple.verify.conservation import conserve
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS
from fbcouple.verify.held_mesh import HeldMesh, compare_losses
from fbcouple.verify.registry import Number, check

_FOLDER = Path(__file__).with_name("meshes")
_DOMAIN: dict[str, Any] = {
    "shape": "file",
    "mesh": "column.msh",
    "inlet": "bottom",
    "outlet": "top",
    "size": [0.02, 0.02, 0.044],
    "cells": [8, 8, 18],
}
_VOIDAGES = (0.5, 0.8)
_REACH = 4e-3
_CROWD = (1, 4)
_SPEEDS = (0.5, 2.0)
_BED: dict[str, Any] = {
    "domain": _DOMAIN,
    "gas": GAS | {"inlet_velocity": 1.5, "pressure_tolerance": 1e-12},
    "particles": GLASS | {"count": 1200},
    "contact": FRICTIONLESS | {"friction": 0.1, "wall_friction": 0.1},
    "start": {},
    "exchange": {"filter_passes": 1},
}


@check("gmsh-fixed-bed", fast=False)
def held_in_mesh(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Pressure per length of a held bed in a column that gmsh meshed, voidage 0.5 in its prisms and 0.8 in its
    tetrahedra, against Ergun, within 1 %."""
    case = Case.model_validate({"title": "verify", "end_time": 1.0, "domain": _DOMAIN})
    mesh = read_mesh(case, _FOLDER)
    bed = HeldMesh(folder, comm, "ergun", _DOMAIN, mesh, _VOIDAGES, _REACH, _FOLDER, {"correctors": 3}, _CROWD)
    yield from compare_losses(bed, _SPEEDS, 0.01)


@check("gmsh-conservation", ranks=(1, 2))
def conserve_in_mesh(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Largest errors over 60 coupled steps in that column: momentum 1e-10 of the drag, solids volume 1e-12, gas mass
    1e-8."""
    yield from conserve(folder, comm, _BED, steps=60, lively=1e-4, case_folder=_FOLDER)
