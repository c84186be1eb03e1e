"""A task of the time loop: what looks at every finished step, and what it goes on from after a restart.

To add one of your own: a class of `Task` with the methods that it needs.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.simulation.simulation import Simulation


@dataclass
class Saved:
    """What a task goes on from."""

    numbers: dict[str, Any] = field(default_factory=dict)
    """Values that JSON has; those of rank 0 are kept."""
    cells: dict[str, np.ndarray] = field(default_factory=dict)
    """Name -> rows of this rank's cells; a run on other ranks gets those of its own cells."""
    files: list[str] = field(default_factory=list)
    """Files that rank 0 wrote into the folder of the checkpoint, called task-NAME, as task-probe.npz."""


class Task:
    """Does nothing. All methods are collective: every rank calls them, at the same step."""

    def start(self, sim: Simulation) -> None:
        """Look at the simulation as it is before its first step, and before the first step after a restart."""

    def after_step(self, sim: Simulation) -> None:
        """Look at the step just taken."""

    def finish(self, sim: Simulation) -> None:
        """Look at the simulation after its last step."""

    def save(self, sim: Simulation, folder: Path) -> Saved:
        """What `load` needs to go on from here; `folder` is that of the checkpoint being written."""
        return Saved()

    def load(self, sim: Simulation, saved: Saved, folder: Path) -> None:
        """Go on from what `save` gave; `folder` is that of the checkpoint."""


def name_task(task: Task) -> str:
    """The name of a task in a checkpoint: that of its class."""
    return type(task).__name__
