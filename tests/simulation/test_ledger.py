"""The ledger of particles that come and go: what does not add up is seen, whichever of its parts it is."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.case.schema.output import Monitors
from fbcouple.errors import DivergedError
from fbcouple.simulation.ledger import Amount, Held, Ledger
from fbcouple.simulation.soundness import require_closed_ledger

MASS = 2e-6
BEFORE = Held(100, 100 * MASS, np.array([0.0, 0.0, -100 * MASS]), 100 * MASS)
FED = Amount(3, 3 * MASS, [0.0, 0.0, -6 * MASS])
REMOVED = Amount(1, MASS, [0.0, 0.0, -4 * MASS])


def find_error(count=102, mass=102 * MASS, momentum=-102 * MASS):
    """Error of a step after which so much is there; 102 particles and what they carry are right."""
    return Held(count, mass, np.array([0.0, 0.0, momentum]), 105 * MASS).find_error(BEFORE, FED, REMOVED)


def test_step_that_adds_up():
    assert find_error() < 1e-15


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        ({"count": 101}, 1.0),
        ({"count": 104}, 2.0),
        ({"mass": 103.03 * MASS}, 0.01),
        ({"momentum": -100.94 * MASS}, 0.01),
    ],
)
def test_step_that_does_not(wrong, error):
    assert find_error(**wrong) == pytest.approx(error, rel=1e-9)


def test_all_since_the_start():
    ledger = Ledger(Amount(100, 100 * MASS))
    ledger.enter(FED, REMOVED)
    ledger.enter(FED, REMOVED)
    assert ledger.count == 104 and ledger.fed.momentum == [0.0, 0.0, -12 * MASS]
    assert ledger.close(Held(104, 104 * MASS, np.zeros(3), 0.0)) < 1e-15
    assert ledger.close(Held(103, 103 * MASS, np.zeros(3), 0.0)) == pytest.approx(1.0 + 1.0 / 106)
    assert Ledger.load(ledger.save()) == ledger


@pytest.mark.parametrize("error", [1e-8, 1.0, float("nan")])
def test_run_ends_where_it_does_not_close(error):
    with pytest.raises(
        DivergedError, match=r"at t = 0\.5 s particles that came and went do not add up .*monitors\.ledger"
    ):
        require_closed_ledger(0.5, Monitors(), Ledger(error=error))
    require_closed_ledger(0.5, Monitors(), Ledger(error=1e-12))
