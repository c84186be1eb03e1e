"""Slabs of spheres that are held in a mesh of polyhedra while the gas passes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.geometry.polyhedra import find_centres, take_apart
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.tetrahedra import Tetrahedra, cut
from fbcouple.verify.harness import GAS, GLASS, Edit, blow, open_bench
from fbcouple.verify.published import PUBLISHED, Bed
from fbcouple.verify.registry import Number

INLET = 0.5
_STEPS = 12
_LINE = 0.5
"""Part of the way from the middle of a quarter to a corner that its spheres are spread along, to both sides."""


class HeldMesh:
    """Slabs of some `voidages` on each other, as high as each other; a sphere in the middle of each quarter of a
    tetrahedron that the cells are cut into, or some whose mean place that is.

    A quarter, from the cell's centre to a side, is where the weights are linear, so that its middle stands for all of
    it: spheres with the same part of the volume of their quarter give every cell the same voidage, to rounding, if
    weights and their transpose are right. They never move; a slip of their own makes up what the inlet does not give.
    """

    def __init__(
        self,
        folder: Path,
        comm: MPI.Comm,
        law: str,
        domain: dict[str, Any],
        mesh: PolyMesh,
        voidages: tuple[float, ...],
        reach: float,
        case_folder: Path = Path(),
        gas: dict[str, Any] | None = None,
        crowd: tuple[int, ...] | None = None,
    ) -> None:
        """reach: distance [m] from the middle of a slab within which nothing is known of the others.

        case_folder: where the mesh of `domain` lies, if it is a file. gas: options of [gas] in place of the bench's.
        crowd: spheres in a usual quarter of each slab, absent or 1: one in every quarter. Where quarters differ much,
        spheres of nearly one size are needed, or the gas finds ways between the small ones.
        """
        self.voidages, self._reach = np.array(voidages), reach
        self._low, self._height = float(mesh.low[2]), float(np.ptp(mesh.points[:, 2])) / len(voidages)
        parts = cut(take_apart(mesh, find_centres(mesh), np.arange(mesh.count), np.arange(len(mesh.points))))
        positions, quarter = self._place_spheres(parts, crowd or (1,) * len(voidages))
        sections: dict[str, Any] = {
            "domain": domain,
            "gas": GAS | {"inlet_velocity": INLET, "pressure_tolerance": 1e-12, "walls": "slip"} | (gas or {}),
            "exchange": {"drag": law},
        }
        edits: dict[str, Edit] = {
            "DEM/in.liggghts": lambda text: text.replace("fix             motion", "# fix             motion")
        }
        self.sim = open_bench(folder, comm, sections, positions, edits, case_folder=case_folder)
        liggghts = self.sim.liggghts
        assert liggghts is not None
        self._slab = self._find_slab(liggghts.positions[:, 2])
        own, shared = quarter[liggghts.numbers - 1], np.bincount(quarter)
        volumes = (1.0 - self.voidages)[self._slab] * (parts.volumes / shared)[own]
        liggghts.radii[:] = (volumes / (4.0 / 3.0 * np.pi)) ** (1.0 / 3.0)
        liggghts.masses[:] = GLASS["density"] * volumes
        self.sim.initialise()
        self._volumes, self._law = volumes, law

    def _place_spheres(self, parts: Tetrahedra, crowd: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
        """Positions [m] of the spheres, and the quarter that each is in: on a line through the quarter's middle."""
        corners = parts.nodes[parts.corners]
        middles = corners.mean(axis=1)
        slab = self._find_slab(middles[:, 2])
        usual = np.bincount(slab, parts.volumes) / np.bincount(slab)
        counts = np.maximum(1, np.round(parts.volumes / usual[slab] * np.array(crowd)[slab])).astype(int)
        counts[np.array(crowd)[slab] == 1] = 1
        quarter = np.repeat(np.arange(len(counts)), counts)
        turn = np.arange(len(quarter)) - np.repeat(np.cumsum(counts) - counts, counts)
        along = _LINE * ((turn + 0.5) / counts[quarter] - 0.5)
        return middles[quarter] + along[:, None] * (corners[:, 1] - middles)[quarter], quarter

    def flow(self, superficial: float) -> None:
        """Let the gas pass each slab with this superficial slip [m/s] for some coupled steps."""
        assert self.sim.liggghts is not None
        slip = (INLET - superficial) / self.voidages
        self.sim.liggghts.velocities[:, 2] = slip[self._slab]
        for _ in range(_STEPS):
            blow(self.sim)

    def _find_slab(self, height: np.ndarray) -> np.ndarray:
        return np.clip(np.floor((height - self._low) / self._height).astype(int), 0, len(self.voidages) - 1)

    def _find_middle(self, slab: int) -> np.ndarray:
        """This rank's cells in the middle of a slab."""
        assert self.sim.gas is not None
        middle = self._low + (slab + 0.5) * self._height
        return np.flatnonzero(np.abs(self.sim.gas.centres[:, 2] - middle) < self._reach)

    @property
    def pressure_losses(self) -> np.ndarray:
        """Pressure per length [Pa/m] in the middle of each slab."""
        gas = self.sim.gas
        assert gas is not None
        rows = [self._find_middle(slab) for slab in range(len(self.voidages))]
        return np.array([-np.polyfit(gas.centres[row, 2], gas.pressure[row], 1)[0] for row in rows])

    def find_published(self, superficial: float) -> np.ndarray:
        """What the paper of the drag law prints for each slab [Pa/m]: each sphere costs what it does in a bed of its
        like, so that it is the mean over the spheres in the middle of the slab, by their volumes (collective)."""
        liggghts, comm = self.sim.liggghts, self.sim.comm
        assert liggghts is not None
        losses = []
        for slab, eps in enumerate(self.voidages.tolist()):
            middle = self._low + (slab + 0.5) * self._height
            near = np.abs(liggghts.positions[:, 2] - middle) < self._reach
            volumes = self._volumes[near]
            beds = (
                Bed(eps, superficial, diameter, GAS["density"], GAS["viscosity"])
                for diameter in np.cbrt(6.0 / np.pi * volumes).tolist()
            )
            costs = volumes @ np.array([PUBLISHED[self._law](bed) for bed in beds])
            losses.append(comm.allreduce(float(costs)) / comm.allreduce(float(volumes.sum())))
        return np.array(losses)

    @property
    def voidage_error(self) -> float:
        """Of the cell in the middle of a slab that is farthest off."""
        assert self.sim.coupling is not None
        voidage = self.sim.coupling.voidage
        return max(
            float(np.abs(voidage[self._find_middle(slab)] - eps).max()) for slab, eps in enumerate(self.voidages)
        )


def compare_losses(bed: HeldMesh, speeds: tuple[float, ...], within: float) -> Iterator[Number]:
    """The voidage of cells, and the pressure per length of each slab at superficial slips `speeds` [m/s] against what
    the paper of the drag law prints (collective)."""
    for speed in speeds:
        bed.flow(speed)
        if speed == speeds[0]:
            yield Number("voidage, cell farthest off", bed.voidage_error, 0.0, 1e-12)
        published = bed.find_published(speed)
        for eps, loss, wanted in zip(bed.voidages.tolist(), bed.pressure_losses, published, strict=True):
            name = f"dP/L at voidage {eps}, {speed} m/s"
            yield Number(name, float(loss), float(wanted), within, "Pa m-1", relative=True)
