"""One measurement in processes of its own: `mpirun -n RANKS python -m fbcouple.bench.process KIND RUN NUMBER...`."""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mpi4py import MPI

from fbcouple.bench.measure import measure_dem, measure_overhead, measure_peer, measure_steps
from fbcouple.bench.memory import measure_memory
from fbcouple.bench.step_costs import measure_costs
from fbcouple.bench.traffic import count_traffic
from fbcouple.bench.variant import measure_variant
from fbcouple.case.load import load_case
from fbcouple.case.schema.sections import Case

FOUND = "bench.json"
KINDS: dict[str, Callable[..., dict[str, Any]]] = {
    "overhead": lambda case, comm, warm, seconds, steps: measure_overhead(case, comm, warm, seconds, int(steps)),
    "costs": measure_costs,
    "dem": lambda case, comm, warm, steps: measure_dem(case, comm, warm, int(steps)),
    "memory": measure_memory,
    "peer": lambda case, comm, warm, steps: measure_peer(case, comm, warm, int(steps)),
    "steps": lambda case, comm, steps, warm=0.0: measure_steps(case, comm, int(steps), warm),
    "traffic": lambda case, comm, ranks: count_traffic(case, int(ranks)),
    "variant": lambda case, comm, warm, steps: measure_variant(case, comm, warm, int(steps)),
}


def main() -> None:
    """Measure and write what was found; a failure ends all ranks with its traceback."""
    kind, run, numbers = sys.argv[1], Path(sys.argv[2]).resolve(), [float(word) for word in sys.argv[3:]]
    try:
        os.chdir(run)
        os.environ["PWD"] = str(run)
        case: Case = load_case("case.toml")
        found = KINDS[kind](case, MPI.COMM_WORLD, *numbers)
        if MPI.COMM_WORLD.rank == 0:
            Path(FOUND).write_text(json.dumps(found), encoding="utf-8")
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        MPI.COMM_WORLD.Abort(3)


if __name__ == "__main__":
    main()
