"""Frames of particles and gas whose places, speeds and sizes are known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.coupling.box.cells import BoxCells
from fbcouple.geometry.grid import Grid
from fbcouple.simulation.tasks.frames import Frames


def write_frames(
    run: Path,
    size: tuple[float, float, float],
    count: int = 3,
    gas: bool = True,
    cells: tuple[int, int, int] = (8, 3, 25),
    heat: bool = False,
    grain: float | None = None,
    drained: bool = False,
) -> None:
    """RUN/frames: a layer of 4000 particles at rest in the left half and one of as many at 1 m/s in the right half.

    Each frame they are 5 mm higher. The gas rises at 2 m/s, at voidage 0.4 in the lower half and 1 above. With `heat`
    those in the left half have 300 K and those in the right half 360 K, the gas 310 K. With
    `grain` they are parcels of grains of this diameter [m], `drained` they have all left in one more frame.
    """
    grid = Grid(cells, size)
    owned = np.stack(np.meshgrid(*(np.arange(n) for n in cells), indexing="ij"), axis=-1).reshape(-1, 3)
    frames = Frames(MPI.COMM_SELF, BoxCells(grid, owned), run / "frames", every=0.1)
    places = np.random.default_rng(4).random((8000, 3)) * [size[0], size[1], 0.06]
    velocities = np.zeros((8000, 3))
    velocities[places[:, 0] > size[0] / 2, 2] = 1.0
    fields = {}
    if gas:
        voidage = np.where(owned[:, 2] < cells[2] / 2, 0.4, 1.0)[:, None]
        fields = {"voidage": voidage, "gas_velocity": np.tile([0.0, 0.0, 2.0], (len(owned), 1))}
    marks = {"temperature": np.where(velocities[:, 2] > 0.0, 360.0, 300.0)} if heat else {}
    if gas and heat:
        fields["gas_temperature"] = np.full((len(owned), 1), 310.0)
    for number in range(count):
        particles = {
            "position": places + np.array([0.0, 0.0, 0.005 * number]),
            "velocity": velocities,
            "diameter": np.full(len(places), grain or 1e-3),
        }
        if grain:
            particles["parcel_diameter"] = np.full(len(places), 1e-3)
        frames.write(0.1 * number, np.arange(1, 8001), particles | marks, fields)
    if drained:
        frames.write(
            0.1 * count, np.arange(0), {name: values[:0] for name, values in (particles | marks).items()}, fields
        )
