"""The inlet of the decks: one velocity by a level floor, or a table of times and velocities."""

from __future__ import annotations

import math
import re

import pytest
from test_render import build

from fbcouple.case.bed import derived
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks

RAMP = [[0.0, 0.3], [0.5, 0.3], [0.5, 0.0], [1.0, 0.8], [2.0, -0.4]]


def read_table(text):
    """Rows of the table of the inlet in the deck of the velocity."""
    (table,) = re.findall(r"inlet\s+\{[^{}]*?table\s+\(\s*((?:\([^()]*\)\s*)+)\);", text)
    return [tuple(map(float, row.split())) for row in re.findall(r"\(([^()]*)\)", table)]


def test_the_deck_has_every_row_of_the_ramp_and_the_open_faces_carry_the_closed_ones():
    case = build(gas__inlet_velocity=None, gas__inlet_ramp=RAMP)
    text = render_decks(case)["CFD/0/U"]
    share = 15 / 14
    times, velocities = zip(*read_table(text), strict=True)
    assert times == tuple(time for time, _ in RAMP)
    assert velocities == pytest.approx([velocity * share for _, velocity in RAMP], rel=1e-14)
    assert derived.open_velocity(case) == pytest.approx(0.8 * share, rel=1e-14)
    assert "type            superficialInletVelocity;" in text and "interstitialInletVelocity" not in text
    assert "internalField   uniform (0 0 0.3)" in text


def test_a_measured_inlet_of_many_rows_is_in_the_deck_to_the_last_digit():
    rows = [[0.0125 * n, 0.05 * math.sin(0.7 * n)] for n in range(1000)]
    case = build(gas__inlet_velocity=None, gas__inlet_ramp=rows, gas__closed_nozzle=None)
    assert read_table(render_decks(case)["CFD/0/U"]) == [tuple(row) for row in rows]


def test_no_trace_of_a_ramp_that_is_not_given():
    ramp = build(gas__inlet_velocity=None, gas__inlet_ramp=RAMP)
    assert find_needs(ramp)["inlet_ramp"] and find_needs(ramp)["superficial_inlet"]
    assert not find_needs(build())["inlet_ramp"] and not find_needs(build())["superficial_inlet"]
    assert "table" not in render_decks(build())["CFD/0/U"]


CLOSED = {"gas__top": "closed", "gas__inlet_velocity": 0.0}


@pytest.mark.parametrize(("walls", "word"), [("no-slip", "noSlip"), ("slip", "slip")])
def test_a_lid_is_a_wall_and_pressure_has_a_point(walls, word):
    decks = render_decks(build(**CLOSED, gas__walls=walls))
    velocity, pressure = (re.findall(r"outlet\s+\{\s+type +(\w+);", decks[f"CFD/0/{name}"])[0] for name in "Up")
    assert (velocity, pressure) == (word, "zeroGradient")
    (point,) = re.findall(r"pRefPoint +\((.*)\);", decks["CFD/system/fvSolution"])
    assert [float(number) for number in point.split()] == pytest.approx([0.005, 0.003, 0.019])
    assert re.search(r"outlet\s+\{\s+type    wall;", decks["CFD/system/blockMeshDict"])


def test_no_trace_of_a_lid_on_an_open_box():
    assert find_needs(build(**CLOSED))["lid"] and not find_needs(build())["lid"]
    decks = render_decks(build())
    assert "pRefPoint" not in decks["CFD/system/fvSolution"] and "zeroGradient" in decks["CFD/0/p"]
    assert re.findall(r"outlet\s+\{\s+type +(\w+);", decks["CFD/0/p"]) == ["fixedValue"]
