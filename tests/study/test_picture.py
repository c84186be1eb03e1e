"""Numbers at the points of a study's picture keep clear of points and of each other."""

import math
import re

import numpy as np
import pytest

from fbcouple.study.picture import draw, measure_points, place_numbers


def test_numbers_of_points_close_together_do_not_meet():
    """Four points in a row, 10 pt apart: a number to the upper right of each alone would lie on the next mark."""
    points = np.array([[100.0, 100.0], [110.0, 103.0], [120.0, 106.0], [112.0, 112.0]])
    offsets = place_numbers(points)
    numbers = points + np.array(offsets)
    for place, number in enumerate(numbers):
        others = [*np.delete(points, place, axis=0), *np.delete(numbers, place, axis=0)]
        assert min(math.dist(number, other) for other in others) >= 6.0
    assert len(set(offsets)) > 1


def test_a_point_alone_has_its_number_to_the_upper_right():
    assert place_numbers(np.array([[3.0, 4.0]])) == [(7.0, 5.0)]


def test_points_lie_in_the_panel_by_their_logarithms():
    found = measure_points([(10.0, 1e-3), (100.0, 1e-1)], ((1.0, 100.0), (1e-3, 1e-1)))
    assert found[0] == pytest.approx([0.5 * 4.6 * 72, 0.0]) and found[1] == pytest.approx([4.6 * 72, 2.2 * 72])


def test_names_are_broken_between_members_only(tmp_path):
    names = [f"scheme-semi-implicit-of-number-{number}" for number in range(7)]
    rows = [
        {"measure": "m", "member": name, "a.b": name, "error": 0.1 * 2.0**n, "stderr": 0.0, "pareto": n == 0}
        | {"core_seconds_per_second": 10.0 + n}
        for n, name in enumerate(names)
    ]
    file = draw(rows, ["a.b"], "title", tmp_path / "study.svg")
    text = file.read_text()
    assert all(f"{number + 1}\u00a0{name}" in text or name in text for number, name in enumerate(names))


def test_a_measure_that_no_member_has_says_why(tmp_path):
    row = {"measure": "m", "member": "base", "a.b": 1, "error": None, "core_seconds_per_second": 10.0}
    file = draw([row | {"why": "not mixed to 0.9: it has come to 0.17"}], ["a.b"], "title", tmp_path / "study.svg")
    words = " ".join(re.findall("<!-- (.*) -->", file.read_text()))
    assert "not mixed to 0.9: it has come to 0.17" in words
