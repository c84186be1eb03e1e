"""The fourteen cases of the paper: how long each runs, with which sub-grid model, and from which seed."""

from __future__ import annotations

import pytest

from fbcouple.case.load import load_case
from fbcouple.case.source import list_sets

LIMITS = {"patil/c1": (8.0, 0.15, 14.0), "patil/c3": (1.0, 0.25, 6.0)}
"""averages.start, until_error and earliest_end; of the others as of C2."""


@pytest.mark.parametrize("name", list_sets()["patil/all"])
def test_a_case_runs_until_it_is_sure_within_the_papers_20_s(name):
    case = load_case(name)
    assert case.end_time == 20.0
    given = case.averages.start, case.averages.until_error, case.averages.earliest_end
    assert given == LIMITS.get(name, (1.0, 0.15, 8.0))
    assert case.gas.turbulence == ("none" if name == "patil/a1" else "localized-dynamic")
    assert case.start.seed == (2 if name == "patil/c5-0.1" else 1)


def test_the_twins_differ_in_their_seed_alone():
    one, other = load_case("patil/c4-0.1"), load_case("patil/c5-0.1", ["start.seed=1"])
    assert one.model_copy(update={"title": ""}) == other.model_copy(update={"title": ""})


def test_the_demo_has_a_given_length():
    case = load_case("patil/demo")
    assert case.averages.until_error is None and case.end_time == 2.0 and case.gas.turbulence == "smagorinsky"
