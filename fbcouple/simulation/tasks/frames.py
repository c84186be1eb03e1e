"""All particles, and the gas in every cell, at single moments: RUN/frames/frame-000000.nc and on, for 3-D views.

A file a moment: a run that is killed harms none that was written, and one that goes on from a checkpoint removes those
that came after it and writes them again.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from mpi4py import MPI

from fbcouple.case.bed.particle_types import find_ratio, list_species
from fbcouple.coupling.discretisation import Cells
from fbcouple.paths import FRAMES
from fbcouple.results.conventions import follow_conventions
from fbcouple.results.writer import write_dataset
from fbcouple.simulation.clock import Cadence
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.task import Saved, Task
from fbcouple.simulation.tasks.writing import writing
from fbcouple.solvers.liggghts import IDENTITY

Values = dict[str, np.ndarray]

# name -> unit, long name
PARTICLES: dict[str, tuple[str, str]] = {
    "position": ("m", "centre of the particle"),
    "velocity": ("m s-1", "velocity of the particle"),
    "diameter": ("m", "diameter of the particle"),
}
PARCELS: dict[str, tuple[str, str]] = {
    "parcel_diameter": ("m", "diameter of the parcel, which stands for particles of `diameter`")
}
"""Of a coarse-grained bed, beside the size of its grains."""
IDENTITIES: dict[str, tuple[str, str]] = {
    "entry_time": ("s", "time at which the particle came in; 0 of those of the start"),
    "feed": ("1", "feed by which the particle came in, counted from 1; 0: it was there at the start"),
}
"""Of particles that come and go, beside their numbers."""
SPECIES: dict[str, tuple[str, str]] = {"species": ("1", "species of the particle, counted from 1")}
"""Of particles of a mixture."""
TEMPERATURE: dict[str, tuple[str, str]] = {"temperature": ("K", "temperature of the particle")}
"""Of particles of a case with heat."""
_NUMBER = {"long_name": "number of the particle; no other one has it, in this frame or another"}
FIELDS: dict[str, tuple[str, str]] = {
    "voidage": ("1", "voidage that the gas has"),
    "gas_velocity": ("m s-1", "interstitial gas velocity"),
}
GAS_TEMPERATURE: dict[str, tuple[str, str]] = {"gas_temperature": ("K", "temperature of the gas")}
"""Of the gas of a case with heat."""


class Frames(Task):
    """Writes a frame on rank 0 when one is due; rows are particles in the order of their numbers."""

    def __init__(self, comm: MPI.Comm, cells: Cells, folder: Path, every: float) -> None:
        """`every` [s] of simulated time, from time 0 on (collective)."""
        self._comm, self._cells, self._folder = comm, cells, folder
        cells.prepare_samples(comm)
        self._cadence = Cadence(every)
        self.count = 0
        """Frames written so far."""

    def write(self, time: float, numbers: np.ndarray, particles: Values, fields: Values) -> None:
        """Write the frame of `time` [s] (collective).

        numbers: (n,) of this rank's particles; particles: name of `PARTICLES`, `PARCELS`, `IDENTITIES`, `SPECIES`,
        `TEMPERATURE` -> (n,) or (n, 3); fields: name of `FIELDS`, `GAS_TEMPERATURE` -> (cells, components) of this
        rank's cells; of a mesh of polyhedra the file has the cells at the places of the regular grid.
        """
        lean = [{name: values.astype(np.float32) for name, values in part.items()} for part in (particles, fields)]
        gathered = self._comm.gather((np.array(numbers, dtype=np.int64), self._cells.owned, *lean))
        if gathered is not None:
            all_numbers, cells, rows, values = zip(*gathered, strict=True)
            order = np.argsort(np.concatenate(all_numbers))
            data: dict[str, Any] = {}
            for name in particles:
                column = np.concatenate([part[name] for part in rows])[order]
                about = _describe((PARTICLES | PARCELS | IDENTITIES | SPECIES | TEMPERATURE)[name])
                data[name] = (("particle", "component")[: column.ndim], column, about)
            if IDENTITIES.keys() <= particles.keys():
                data["number"] = ("particle", np.concatenate(all_numbers)[order], _NUMBER)
            for name in fields:
                field = self._cells.sample([(owned, part[name]) for owned, part in zip(cells, values, strict=True)])
                data[name] = (
                    ("component", "z", "y", "x")[-field.ndim :],
                    field,
                    _describe((FIELDS | GAS_TEMPERATURE)[name]),
                )
            self._save(time, data)
        self.count += 1

    def _save(self, time: float, data: dict[str, Any]) -> None:
        self._folder.mkdir(exist_ok=True)
        coordinates: dict[str, Any] = {
            "component": ("component", ["x", "y", "z"], {"long_name": "component of a vector"}),
            "time": time,
        }
        grid = self._cells.grid
        for axis, name in enumerate("xyz"):
            coordinates[name] = (name, grid.centres(axis), {"units": "m", "long_name": f"cell centre {name}"})
        frame = xr.Dataset(data, coordinates, {"title": "Particles and gas at a single moment"})
        frame["time"].attrs = {"units": "s", "long_name": "simulated time"}
        encoding = {name: {"zlib": True, "complevel": 1} for name in data}
        write_dataset(self._folder / name_frame(self.count), follow_conventions(frame), encoding)

    def start(self, sim: Simulation) -> None:
        """The first is that of the start (collective)."""
        self.after_step(sim)

    def after_step(self, sim: Simulation) -> None:
        """Write a frame if one is due (collective)."""
        if self._cadence.due(sim.time):
            with sim.timers("record"), writing(self._folder.parent, FRAMES):
                self.write(sim.time, *look_at(sim))

    def save(self, sim: Simulation, folder: Path) -> Saved:
        """When the next is due, and how many there are."""
        return Saved({"next": self._cadence.next, "count": self.count})

    def load(self, sim: Simulation, saved: Saved, folder: Path) -> None:
        """Go on from `saved`: frames written later are removed."""
        self._cadence.next = saved.numbers["next"]
        self.cut(saved.numbers["count"])

    def cut(self, count: int) -> None:
        """Go on after `count` frames: those written after them are removed."""
        self.count = count
        if self._comm.rank == 0:
            for path in self._folder.glob("frame-*"):
                if path.name >= name_frame(count):
                    path.unlink()


def name_frame(number: int) -> str:
    """File of the frame `number`, counted from 0."""
    return f"frame-{number:06d}.nc"


def _describe(about: tuple[str, str]) -> dict[str, str]:
    return {"units": about[0], "long_name": about[1]}


def look_at(sim: Simulation) -> tuple[np.ndarray, Values, Values]:
    """Numbers and columns of this rank's particles, and fields of its cells if there is gas, as `write` takes them."""
    liggghts = sim.liggghts
    particles = {"position": liggghts.positions, "velocity": liggghts.velocities, "diameter": 2.0 * liggghts.radii}
    fields = {}
    if sim.case.particles and sim.case.particles.coarse_graining:
        particles["parcel_diameter"] = particles["diameter"]
        particles["diameter"] = particles["diameter"] / find_ratio(sim.case.particles)
    if sim.is_coupled:
        fields = {"voidage": sim.coupling.voidage[:, None], "gas_velocity": sim.gas.velocity}
    if liggghts.identifies:
        particles |= {name: liggghts.identity[:, IDENTITY.index(name)] for name in IDENTITIES}
    if sim.case.particles and sim.case.particles.mixture:
        particles["species"] = np.array(list_species(sim.case.particles))[liggghts.types - 1]
    if sim.heat:
        particles["temperature"] = liggghts.temperatures
        if sim.heat.gas:
            fields["gas_temperature"] = sim.heat.gas.temperatures[:, None]
    return liggghts.numbers, particles, fields


def track(sim: Simulation) -> dict[str, list[float]]:
    """Position [m] and velocity [m/s] of each tracked particle, by number: x, y, z, v_x, v_y, v_z, nan while it is not
    there (collective)."""
    liggghts, wanted = sim.liggghts, np.array(sim.case.output.tracked)
    index, row = np.nonzero(wanted[:, None] == liggghts.numbers)
    motion = np.zeros((len(wanted), 7))
    motion[index, :6] = np.hstack([liggghts.positions[row], liggghts.velocities[row]])
    motion[index, 6] = 1.0
    motion = sim.comm.allreduce(motion)
    motion[motion[:, 6] == 0.0] = np.nan  # not in yet, or gone
    return {str(number): values for number, values in zip(wanted, motion[:, :6].tolist(), strict=True)}
