"""How long a fluid step the particles allow: none of them is to cross more than a cell, or to pass an outlet unseen."""

from __future__ import annotations

import math

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.outlets import find_longest_way
from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.schema.sections import Case
from fbcouple.solvers.liggghts import Liggghts
from fbcouple.solvers.openfoam.gas import Gas

CROSSED = 1.0
"""Cells that the fastest particle may cross in a fluid step: the gas sees it at the ends of the step alone."""


class ParticleStep:
    """Knows how far a particle may move in a step: `length` [m]."""

    def __init__(self, case: Case, comm: MPI.Comm, gas: Gas, liggghts: Liggghts) -> None:
        """A cell is as long as the edge of a cube of the smallest one, and counts as no shorter than the smallest
        particle, of which more than one cell lies under thinner ones (collective)."""
        assert case.particles is not None
        volume = comm.allreduce(float(np.min(gas.volumes, initial=math.inf)), MPI.MIN)
        smallest = min(kind.diameter for kind in list_kinds(case.particles))
        self.length = min(CROSSED * max(volume ** (1.0 / 3.0), smallest), find_longest_way(case))
        self._comm, self._liggghts = comm, liggghts

    def find_longest(self) -> float:
        """Longest step [s] for the particles as they move now (collective)."""
        squares = np.einsum("ij,ij->i", self._liggghts.velocities, self._liggghts.velocities)
        fastest = self._comm.allreduce(float(squares.max(initial=0.0)), MPI.MAX)
        return self.length / math.sqrt(fastest) if fastest > 0.0 else math.inf
