"""The momentum check: a true imbalance is seen, the rounding of a drag that has died away is not taken for one."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.simulation.conservation import Conservation

MOMENTUM = 11.0
FORCES = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -0.25]])


def find_error(loss: float, drag: float) -> float:
    conservation = Conservation(MPI.COMM_SELF)
    conservation.give(np.array([0.0, 0.0, loss]), drag, 0.1)
    conservation.receive(FORCES, 0.1, lambda: MOMENTUM)
    return conservation.momentum_error


def test_what_arrives_is_no_error():
    assert find_error(0.75, 1.25) == 0.0


def test_a_weight_that_is_held_is_no_force_of_the_gas():
    conservation = Conservation(MPI.COMM_SELF)
    conservation.give(np.array([0.0, 0.0, 2.75]), 4.0, 0.1)
    conservation.receive(FORCES, 0.1, lambda: MOMENTUM, weight=2.0)
    assert (conservation.momentum_error, conservation.support) == (0.0, 2.75)


def test_the_weight_of_gas_that_is_carried_along_is_no_support():
    conservation = Conservation(MPI.COMM_SELF)
    conservation.give(np.array([0.0, 0.0, 2.75]), 4.0, 0.1)
    conservation.receive(FORCES, 0.1, lambda: MOMENTUM, weight=2.0, carried=0.5)
    assert (conservation.momentum_error, conservation.support) == (0.0, 2.25)


@pytest.mark.parametrize("share", [1e-6, 1e-9])
def test_imbalance_is_told_over_the_drag(share):
    assert find_error(0.75 + 1.25 * share, 1.25) == pytest.approx(share, rel=1e-5)


def test_rounding_of_a_drag_that_has_died_away_is_told_over_the_momentum():
    conservation = Conservation(MPI.COMM_SELF)
    conservation.give(np.array([0.0, 0.0, 3e-16]), 1e-9, 0.1)
    conservation.receive(np.zeros((2, 3)), 0.1, lambda: MOMENTUM)
    assert conservation.momentum_error == pytest.approx(3e-17 / (1e-4 * MOMENTUM))


def test_a_large_imbalance_of_a_small_drag_is_still_seen():
    conservation = Conservation(MPI.COMM_SELF)
    conservation.give(np.array([0.0, 0.0, 1e-6]), 1e-9, 0.1)
    conservation.receive(np.zeros((2, 3)), 0.1, lambda: MOMENTUM)
    assert conservation.momentum_error > 1e-5


def test_at_rest_without_drag_the_imbalance_itself_is_told():
    conservation = Conservation(MPI.COMM_SELF)
    conservation.give(np.array([0.0, 0.0, 1e-3]), 0.0, 1.0)
    conservation.receive(np.zeros((2, 3)), 1.0, lambda: 0.0)
    assert conservation.momentum_error == pytest.approx(1.0), "the loss is its own scale"
