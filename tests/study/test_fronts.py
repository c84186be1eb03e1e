"""Pareto front, slopes and orders, on numbers whose answer is known."""

from __future__ import annotations

import json
import math

import pytest

from fbcouple.case.load import load_case
from fbcouple.paths import CASES
from fbcouple.results.reader import open_results
from fbcouple.results.tables import write_tables
from fbcouple.study.error_vs_time import Done, tabulate
from fbcouple.study.measures import Finished
from fbcouple.study.members import REFERENCE, Member
from fbcouple.study.pareto import find_coordinate, find_excess, fit_slope, mark_pareto, tabulate_knobs
from fbcouple.study.picture import draw
from fbcouple.study.runs import Ending
from fbcouple.study.schema import Study


def test_front():
    costs = [1.0, 2.0, 3.0, 2.0, 4.0, math.nan, 0.1]
    errors = [0.5, 0.2, 0.2, 0.4, 0.1, 0.0, math.nan]
    assert mark_pareto(costs, errors) == [True, True, False, False, True, False, False]


def test_equal_members_are_both_on_the_front():
    assert mark_pareto([1.0, 1.0], [0.1, 0.1]) == [True, True]


def test_excess_is_over_the_cheapest_of_the_same_accuracy():
    costs, errors = [1.0, 2.0, 6.0, 3.0, math.nan], [0.4, 0.2, 0.1, 0.2, 0.05]
    assert find_excess(costs, errors, [0.0] * 5)[:4] == [1.0, 1.0, 1.0, 1.5]
    assert math.isnan(find_excess(costs, errors, [0.0] * 5)[4])
    bars = [0.0, 0.03, 0.04, 0.0, 0.0]
    assert find_excess(costs, errors, bars)[2] == 1.0, "0.2 is farther off than both bars together"
    assert find_excess(costs, errors, [0.0, 0.06, 0.09, 0.0, 0.0])[2] == 3.0, "0.2 cannot be told from 0.1"


def test_a_standard_error_that_is_not_known_makes_no_member_cheapest():
    """The second is of no known accuracy, and to the others of theirs only where its error is not larger."""
    found = find_excess([1.0, 2.0, 4.0], [0.3, 0.2, 0.25], [0.01, math.nan, 0.01])
    assert found[0] == 1.0 and math.isnan(found[1]) and found[2] == 2.0
    assert all(map(math.isnan, find_excess([1.0, 2.0], [0.1, 0.2], [math.nan, math.nan])))


PAPER = CASES.parent / "docs/results/paper"


def test_a_study_of_a_member_whose_window_is_too_short_ends_with_its_tables(tmp_path):
    """c5-0.0 averaged four correlation times, so that the error of its map is not known."""
    study = Study(title="s", base="patil/c2", knobs={"contact.friction": [0.0]}, measures=("maps:solids_flux",))
    done = []
    for cost, (member, name) in enumerate({"base": "c5-0.0", "b": "c4-0.1", REFERENCE: "c2"}.items(), start=1):
        finished = Finished(open_results(PAPER / f"{name}.nc"), load_case("patil/c2"))
        knobs = {"contact.friction": float(cost)}
        done.append(Done(Member(member, {}, knobs), Ending("complete", "", 1.0, 1), finished, float(cost)))
    rows, _ = tabulate(study, done)
    unsure, sure = rows
    assert math.isnan(unsure["stderr"]) and unsure["why"] == "its standard error is not known"
    assert unsure["over_cheapest"] is None and unsure["error"] > 0.0 and unsure["pareto"]
    assert sure["stderr"] > 0.0 and sure["over_cheapest"] is not None and not sure["why"]
    picture = draw(rows, ["contact.friction"], "title", tmp_path / "study.svg")
    assert "standard error" in picture.read_text()
    files = write_tables(tmp_path, "study", {"members": rows}, {})
    assert json.loads(files[0].read_text())["members"][0]["stderr"] is None


@pytest.mark.parametrize(
    ("value", "expected"), [(2.0, 2.0), (3, 3.0), ([2, 4, 8], 4.0), ("explicit", None), (True, None), (0.0, None)]
)
def test_coordinate(value, expected):
    assert find_coordinate(value) == (None if expected is None else pytest.approx(expected))


def test_slope_of_a_power_law():
    x = [1e-3, 2e-3, 4e-3]
    assert fit_slope(x, [5 * v**1.5 for v in x]) == pytest.approx(1.5)
    assert math.isnan(fit_slope([1.0, 1.0], [1.0, 2.0]))


def test_knobs_are_told_apart():
    """error = step^2 for one scheme and step for the other, cost = 1/step."""
    steps = (1.0, 2.0, 4.0)
    members = [Member(f"{s}{p}", {}, {"step": s, "scheme": p}) for p in ("a", "b") for s in steps]
    costs = [1 / m.knobs["step"] for m in members]
    errors = [m.knobs["step"] ** (2 if m.knobs["scheme"] == "a" else 1) for m in members]
    rows = list(tabulate_knobs(members, costs, errors))
    steps_rows = [row for row in rows if row["knob"] == "step"]
    assert [row["order"] for row in steps_rows] == pytest.approx([2.0, 1.0])
    assert [row["slope"] for row in steps_rows] == pytest.approx([-2.0, -1.0])
    assert [row["gain"] for row in rows if row["knob"] == "scheme"] == pytest.approx([1.0, 2.0, 4.0])
    assert all(row["order"] is None for row in rows if row["knob"] == "scheme")
