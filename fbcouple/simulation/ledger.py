"""The ledger of a run in which particles come and go: what came in is what went out and what is held."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.solvers.liggghts import Liggghts


@dataclass
class Amount:
    """Particles, their mass [kg], momentum [kg m/s] and, in a case with heat, heat m c T [J]."""

    count: int = 0
    mass: float = 0.0
    momentum: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    heat: float = 0.0

    def add(self, masses: np.ndarray, velocities: np.ndarray) -> None:
        """Particles of `masses` (n,) [kg] and `velocities` (n, 3) [m/s] more."""
        self.count += len(masses)
        self.mass += float(masses.sum())
        self.momentum = [before + float(more) for before, more in zip(self.momentum, masses @ velocities, strict=True)]


@dataclass
class Ledger:
    """Particles of the start, those that came in and those that went out; the same on all ranks."""

    start: Amount = field(default_factory=Amount)
    fed: Amount = field(default_factory=Amount)
    removed: Amount = field(default_factory=Amount)
    error: float = 0.0
    """How far the ledger was from closing when last held against the particles: of mass and momentum the part of what
    there is; a whole number and more where particles are missing, or too many."""

    @property
    def count(self) -> int:
        """Particles that there have to be."""
        return self.start.count + self.fed.count - self.removed.count

    def enter(self, fed: Amount, removed: Amount) -> None:
        """So much came in and so much went out."""
        for total, more in ((self.fed, fed), (self.removed, removed)):
            total.count, total.mass = total.count + more.count, total.mass + more.mass
            total.heat += more.heat
            total.momentum = [one + other for one, other in zip(total.momentum, more.momentum, strict=True)]

    def save(self) -> dict[str, Any]:
        """What `load` needs to go on."""
        return asdict(self)

    @classmethod
    def load(cls, saved: dict[str, Any]) -> Ledger:
        """The ledger that was saved."""
        start, fed, removed = (Amount(**saved[name]) for name in ("start", "fed", "removed"))
        return cls(start, fed, removed, saved["error"])

    def close(self, held: Held) -> float:
        """Hold the ledger against what is there; the error of count and mass."""
        scale = self.start.mass + self.fed.mass
        mass = scale - self.removed.mass
        return abs(self.count - held.count) + (abs(held.mass - mass) / scale if scale else abs(held.mass))


@dataclass(frozen=True)
class Held:
    """All particles of a moment: number, mass [kg], momentum (3,) [kg m/s] and the sum of its magnitudes."""

    count: int
    mass: float
    momentum: np.ndarray
    scale: float

    def find_error(self, before: Held, fed: Amount, removed: Amount) -> float:
        """How far this is from what was there `before`, with what was fed and without what was removed."""
        mass = before.mass + fed.mass - removed.mass
        momentum = before.momentum + np.array(fed.momentum) - np.array(removed.momentum)
        off = float(np.abs(self.momentum - momentum).max())
        scale = before.scale + float(np.abs(fed.momentum).max())
        missing = abs(self.count - before.count - fed.count + removed.count)
        off_mass = abs(self.mass - mass) / ((before.mass + fed.mass) or 1.0)
        return missing + max(off_mass, off / scale if scale else off)


def measure_held(comm: MPI.Comm, liggghts: Liggghts) -> Held:
    """All particles of all ranks (collective)."""
    masses, velocities = liggghts.own_masses, liggghts.velocities
    speeds = np.linalg.norm(velocities, axis=1)
    sums = comm.allreduce(np.array([len(masses), masses.sum(), *(masses @ velocities), masses @ speeds]))
    return Held(round(sums[0]), float(sums[1]), sums[2:5], float(sums[5]))
