"""One check in processes of its own: `mpirun -n RANKS python -m fbcouple.verify.process SCENE FOLDER [VARIANT]`."""

from __future__ import annotations

import json
import sys
import traceback
from dataclasses import asdict
from pathlib import Path

from mpi4py import MPI

from fbcouple.verify.registry import load_checks

NUMBERS = "numbers.json"


def main() -> None:
    """Run the check and write its numbers; a failure ends all ranks with its traceback."""
    name, folder = sys.argv[1], Path(sys.argv[2]).resolve()
    try:
        numbers = list(load_checks()[name].function(folder, MPI.COMM_WORLD, *sys.argv[3:]))
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        MPI.COMM_WORLD.Abort(3)
    if MPI.COMM_WORLD.rank == 0:
        (folder / NUMBERS).write_text(json.dumps([asdict(number) for number in numbers]), encoding="utf-8")


if __name__ == "__main__":
    main()
