"""A sub-grid model gives the same gas on one rank and on two, cut through the closed nozzle."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fbcouple.machine.environment import mpi_environment
from fbcouple.machine.launchers import mpi_command

PROGRAM = Path(__file__).with_name("turbulence_program.py")


def run_gas(model: str, ranks: int, place: Path) -> np.ndarray:
    """Velocity (x, y, z, 3) after the program's steps."""
    place.mkdir()
    command = mpi_command(ranks, [sys.executable, str(PROGRAM), model, str(place)])
    done = subprocess.run(command, env=mpi_environment(), capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return np.load(place / "velocity.npy")


@pytest.mark.parametrize("model", ["keqn", "dynamic-lagrangian", "localized-dynamic"])
def test_two_ranks_see_the_same_turbulence(model, tmp_path):
    one, two = (run_gas(model, ranks, tmp_path / str(ranks)) for ranks in (1, 2))
    assert np.abs(one).max() > 1.2 and np.ptp(one[..., 2]) > 0.5, "a flow that the model has something to do with"
    assert np.abs(one - two).max() < 1e-9
