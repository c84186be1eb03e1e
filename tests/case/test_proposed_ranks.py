"""Ranks that a run is worth: doubled as long as each doubling pays, and how sure that is."""

from __future__ import annotations

from dataclasses import replace

import pytest
from click.testing import CliRunner

from fbcouple.case.cost.coefficients import SHIPPED
from fbcouple.case.cost.prediction import predict
from fbcouple.case.cost.ranks import FEW_CELLS, Proposal, count_worked, propose_ranks
from fbcouple.case.load import load_case
from fbcouple.cli.main import cli
from fbcouple.cli.prediction import format_proposal

CASE = load_case("patil/c2")
CELLS = 23_100
FREE = replace(
    SHIPPED,
    **dict.fromkeys(
        ("particle", "neighbour", "rebuild", "dem_step", "corrector", "exchange_particle", "exchange_cell"), 0.0
    ),
    exchange_step=0.0,
    contact=dict.fromkeys(SHIPPED.contact, 0.0),
    subgrid=dict.fromkeys(SHIPPED.subgrid, 0.0),
    shared=dict.fromkeys(SHIPPED.shared, 1.0),
)
"""Only cells and the fluid step cost something."""


def propose(divided: float) -> Proposal:
    """For a run whose divided work takes `divided` as long as what every rank does, on one rank."""
    predicted = predict(CASE, 1, SHIPPED)
    alone = replace(predicted, stages=predicted.stages | {"start-up": 0.0})
    return propose_ranks(CASE, replace(FREE, cell=1e-3 * divided / CELLS, fluid_step=1e-3), alone)


@pytest.mark.parametrize(
    ("divided", "ranks", "least", "most"),
    [(0.5, 1, 1, 1), (1.4, 2, 1, 2), (9.3, 8, 4, 16), (12.0, 16, 8, 32), (1e6, 32, 16, 64)],
)
def test_ranks_are_doubled_as_long_as_it_pays(divided, ranks, least, most):
    """Wall time 1 + q/r: a doubling has the efficiency (1 + q/r)/(2 + q/r), 0.7 or more up to r = 0.75 q.

    0.77 (1.1 times 0.7) up to 0.426 q, 0.636 up to 1.33 q. The last has work for 23 100/500 = 46 ranks, 23 to 92.
    """
    found = propose(divided)
    assert (found.ranks, found.least, found.most) == (ranks, least, most)
    assert found.limit == CELLS // FEW_CELLS == 46
    assert found.gain == pytest.approx((1.0 + divided / ranks) / (1.0 + divided / (2 * ranks)))


def test_neighbours_that_ranks_share_cost_too():
    """Columns of ranks get thinner, and each looks at what is beside it: of particles alone 64 ranks are too many."""
    dem = replace(FREE, particle=1e-8, cell=0.0, fluid_step=0.0)
    found = propose_ranks(CASE, dem, predict(CASE, 1, SHIPPED))
    assert 1.0 < found.walls[16] / found.walls[32] < 2.0


def test_ranks_have_enough_of_one_phase():
    assert count_worked(0, 0) == count_worked(499, 2999) == 1
    assert count_worked(1000, 0) == 2 and count_worked(500, 9000) == 3


def test_what_is_said_of_it():
    assert format_proposal(propose(0.5)) == (
        f"1 rank is proposed, {_clock(propose(0.5), 1)}: 2 would be 1.2 times as fast, 1.4 is asked for"
    )
    assert format_proposal(propose(1e3)).startswith("32 ranks are proposed (16 to 64 within what is unsure), ")


def _clock(found: Proposal, ranks: int) -> str:
    return f"{found.walls[ranks]:.2g} s"


def test_check_proposes_ranks(tmp_path, monkeypatch):
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path))
    lines = CliRunner().invoke(cli, ["check", "patil/c2"]).output.splitlines()
    assert lines[-1].startswith("32 ranks are proposed (16 to 64 within what is unsure), ")
    assert CliRunner().invoke(cli, ["check", "patil/c2", "-n", "4"]).output.splitlines()[-1] == lines[-1]
