"""Both solvers cut the region into the same columns, numbered alike, and they are those that fbcouple reckons with."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fbcouple.bench.traffic import cut_box
from fbcouple.geometry.grid import Grid
from fbcouple.geometry.partition import find_rank_grid
from fbcouple.machine.environment import mpi_environment
from fbcouple.machine.launchers import mpi_command

PROGRAM = Path(__file__).with_name("columns_program.py")


@pytest.mark.parametrize(
    ("cells", "elements", "ranks", "grid"),
    [
        ((12, 12), "hexahedra", 4, (2, 2)),
        ((12, 12), "hexahedra", 2, (2, 1)),
        ((12, 4), "hexahedra", 4, (4, 1)),
        ((6, 9), "hexahedra", 6, (2, 3)),
        ((12, 12), "tetrahedra", 4, (2, 2)),
    ],
)
def test_both_solvers_have_the_same_columns(tmp_path, cells, elements, ranks, grid):
    size = (0.002 * cells[0], 0.002 * cells[1], 0.012)
    assert find_rank_grid(size, ranks) == grid
    command = mpi_command(ranks, [sys.executable, str(PROGRAM), *map(str, cells), elements, str(tmp_path)])
    done = subprocess.run(command, env=mpi_environment(), capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    columns = json.loads((tmp_path / "columns.json").read_text())
    reckoned = cut_box(Grid((*cells, 6), size), ranks)
    for (box, centres), (low, high) in zip(columns, reckoned, strict=True):
        assert np.allclose(box, [low[:2], high[:2]], atol=1e-12)
        assert np.all(np.array(centres[0]) > box[0]) and np.all(np.array(centres[1]) < box[1])


def test_a_shallow_bed_is_cut_across_only():
    assert [find_rank_grid((0.08, 0.015, 0.25), n) for n in (1, 2, 4, 8, 12, 16)] == [
        (1, 1),
        (2, 1),
        (4, 1),
        (8, 1),
        (6, 2),
        (8, 2),
    ]
