"""The inlet of the decks: one velocity, or a ramp as an expression of time that says what the table says."""

from __future__ import annotations

import re

import pytest
from test_render import build

from fbcouple.case import derived
from fbcouple.decks.context import write_ramp
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks

RAMP = [[0.0, 0.3], [0.5, 0.3], [0.5, 0.0], [1.0, 0.8], [2.0, -0.4]]


def evaluate(expression, time):
    """Work an expression out as OpenFOAM does: min, max, pos0, time()."""
    names = {"min": min, "max": max, "pos0": lambda value: float(value >= 0.0), "time": lambda: time}
    return eval(expression, {"__builtins__": {}}, names)


@pytest.mark.parametrize(
    ("time", "velocity"),
    [(0.0, 0.3), (0.25, 0.3), (0.4999, 0.3), (0.5, 0.0), (0.75, 0.4), (1.0, 0.8), (1.5, 0.2), (2.0, -0.4), (9.0, -0.4)],
)
def test_the_expression_says_what_the_table_says(time, velocity):
    assert evaluate(write_ramp(RAMP, 1.0), time) == pytest.approx(velocity, abs=1e-14)
    assert evaluate(write_ramp(RAMP, 1.25), time) == pytest.approx(1.25 * velocity, abs=1e-14)


@pytest.mark.parametrize(
    ("ramp", "start"), [([[0.0, 0.7]], 0.7), ([[3.0, 0.7], [4.0, 0.0]], 0.7), ([[0.0, 0.0], [0.0, 0.7]], 0.7)]
)
def test_before_its_first_row_and_without_a_second_the_ramp_holds(ramp, start):
    assert evaluate(write_ramp(ramp, 1.0), 0.0) == start


def test_the_deck_divides_the_ramp_by_the_voidage_and_the_open_faces_carry_the_closed_ones():
    case = build(gas__inlet_velocity=None, gas__inlet_ramp=RAMP)
    text = render_decks(case)["fluid/0/U"]
    (expression,) = re.findall(r'valueExpr +"vector\(0, 0, \((.*)\)/voidage\)";', text)
    share = 15 / 14
    assert evaluate(expression, 1.0) == pytest.approx(0.8 * share, rel=1e-14)
    assert derived.open_velocity(case) == pytest.approx(0.8 * share, rel=1e-14)
    assert "type            exprFixedValue;" in text and "interstitialInletVelocity" not in text
    assert "internalField   uniform (0 0 0.3)" in text


def test_no_trace_of_a_ramp_that_is_not_given():
    assert find_needs(build(gas__inlet_velocity=None, gas__inlet_ramp=RAMP))["inlet_ramp"]
    assert not find_needs(build())["inlet_ramp"] and "expr" not in render_decks(build())["fluid/0/U"]


CLOSED = {"gas__top": "closed", "gas__inlet_velocity": 0.0}


@pytest.mark.parametrize(("walls", "word"), [("no-slip", "noSlip"), ("slip", "slip")])
def test_a_lid_is_a_wall_and_pressure_has_a_point(walls, word):
    decks = render_decks(build(**CLOSED, gas__walls=walls))
    velocity, pressure = (re.findall(r"outlet\s+\{\s+type +(\w+);", decks[f"fluid/0/{name}"])[0] for name in "Up")
    assert (velocity, pressure) == (word, "zeroGradient")
    (point,) = re.findall(r"pRefPoint +\((.*)\);", decks["fluid/system/fvSolution"])
    assert [float(number) for number in point.split()] == pytest.approx([0.005, 0.003, 0.019])
    assert re.search(r"outlet\s+\{\s+type    wall;", decks["fluid/system/blockMeshDict"])


def test_no_trace_of_a_lid_on_an_open_box():
    assert find_needs(build(**CLOSED))["lid"] and not find_needs(build())["lid"]
    decks = render_decks(build())
    assert "pRefPoint" not in decks["fluid/system/fvSolution"] and "zeroGradient" in decks["fluid/0/p"]
    assert re.findall(r"outlet\s+\{\s+type +(\w+);", decks["fluid/0/p"]) == ["fixedValue"]
