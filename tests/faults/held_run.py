"""`fbcouple run` whose ranks are held somewhere until a signal comes: `python held_run.py WHERE NUMBER RUN [...]`."""

from __future__ import annotations

import sys
from pathlib import Path

import fbcouple.launcher.launch
from fbcouple.cli.main import main
from fbcouple.machine.launchers import mpi_command


def start_held(ranks: int, program: list[str]) -> list[str]:
    """The command of the job, with the worker that is held."""
    place = str(Path(__file__).with_name("held_worker.py"))
    assert program[1:3] == ["-m", "fbcouple.simulation.worker"]
    return mpi_command(ranks, [program[0], place, *held, *program[3:]])


if __name__ == "__main__":
    held = sys.argv[1:3]
    sys.argv[1:3] = ["run"]
    fbcouple.launcher.launch.mpi_command = start_held
    main()
