"""Where both solvers' parts are: `mpirun -n RANKS python columns_program.py WIDTH DEPTH ELEMENTS FOLDER`, in cells."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from mpi4py import MPI

from fbcouple.case.load import load_case
from fbcouple.decks.render import set_up
from fbcouple.launcher.openfoam_mesh import prepare_mesh
from fbcouple.simulation.simulation import Simulation

CASE = """
title = "columns"
end_time = 1.0
[domain]
size = [{width}, {depth}, 0.012]
cells = [{nx}, {ny}, 6]
{elements}
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 0.5
[particles]
diameter = 1e-3
density = 2500.0
count = 20
[contact]
restitution = 0.97
wall_restitution = 0.97
friction = 0.0
wall_friction = 0.0
[start]
[exchange]
"""


def main() -> None:
    """Leave the particles' box and the gas cells' outermost centres of each rank in FOLDER/columns.json."""
    comm, (nx, ny), elements, place = MPI.COMM_WORLD, map(int, sys.argv[1:3]), sys.argv[3], Path(sys.argv[4])
    if comm.rank == 0:
        words = f'elements = "{elements}"' if elements != "hexahedra" else ""
        (place / "case.toml").write_text(CASE.format(width=0.002 * nx, depth=0.002 * ny, nx=nx, ny=ny, elements=words))
        case = load_case(str(place / "case.toml"))
        set_up(case, place / "run")
        prepare_mesh(case, place / "run", comm.size)
    comm.Barrier()
    os.chdir(place / "run")
    sim = Simulation(load_case("case.toml"), Path("."), comm, 1.0)
    assert sim.gas and sim.liggghts
    centres = sim.gas.centres[:, :2]
    own = sim.liggghts.bounds[:, :2].tolist(), [centres.min(axis=0).tolist(), centres.max(axis=0).tolist()]
    if columns := comm.gather(own):
        Path("../columns.json").write_text(json.dumps(columns))


if __name__ == "__main__":
    main()
