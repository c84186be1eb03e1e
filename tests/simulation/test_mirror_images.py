"""Samples averaged with their mirror images, against a turned-round array; on one rank here."""

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.simulation.tasks.means import GAS_COLUMNS, HEAT_COLUMNS, SOLIDS_COLUMNS
from fbcouple.simulation.tasks.mirror import MirrorImages

SHAPE = (5, 4, 3)
CELLS = np.stack(np.meshgrid(*map(np.arange, SHAPE), indexing="ij"), axis=-1).reshape(-1, 3)
PHASES = {"solids": SOLIDS_COLUMNS, "gas": GAS_COLUMNS, "solids_heat": HEAT_COLUMNS}
TURNED = {
    "x": {"solids": [2], "gas": [1, 4], "solids_heat": []},
    "y": {"solids": [3], "gas": [2, 5], "solids_heat": []},
}


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("axes", [("x",), ("y",), ("x", "y")])
def test_rows_are_averaged_with_those_of_their_images(phase, axes):
    rng = np.random.default_rng(1)
    owned = rng.permutation(CELLS)
    field = rng.standard_normal((*SHAPE, PHASES[phase]))
    expected = field
    for axis in axes:
        image = np.flip(expected, "xy".index(axis)).copy()
        image[..., TURNED[axis][phase]] *= -1.0
        expected = 0.5 * (expected + image)
    found = MirrorImages(MPI.COMM_SELF, SHAPE, owned, axes).average(phase, field[tuple(owned.T)])
    assert found == pytest.approx(expected[tuple(owned.T)], rel=1e-15, abs=1e-15)


def test_a_flow_across_the_plane_is_none_on_it():
    rows = np.ones((len(CELLS), SOLIDS_COLUMNS))
    found = MirrorImages(MPI.COMM_SELF, SHAPE, CELLS, ("x",)).average("solids", rows)
    assert (found[:, 2] == 0.0).all() and (found[:, [0, 1, 3, 4, 5, 6]] == 1.0).all()
