"""Tables of inlets and outlets in a case file: what is refused and how it is told, what is filled in, what follows."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest

from fbcouple.case.bed import adopt_inlets, derived
from fbcouple.case.bed.gas_heat import is_inlet_closed
from fbcouple.case.bed.openings import _list_outlet_faces, find_outlet_faces
from fbcouple.case.bed.streams import Opening
from fbcouple.case.cost.work import count_fluid_steps
from fbcouple.case.load import load_case, write_case
from fbcouple.case.preflight import estimate
from fbcouple.decks.render import render_decks
from fbcouple.errors import CaseError
from fbcouple.geometry.plane_cover import Rectangle
from fbcouple.results.inlet_speed import find_fastest, find_mean, is_constant, list_rows, sum_rows, weigh_inlets

CASE = """
title = "a jet in a background"
end_time = 0.1
[domain]
size = [0.08, 0.02, 0.2]
cells = [16, 4, 40]
[gas]
density = 1.2
viscosity = 1.8e-5
[particles]
diameter = 1e-3
density = 2500.0
mass = 0.02
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
filter_passes = 1
"""
BACKGROUND = "[[gas.inlets]]\nrectangle = [[0.0, 0.0], [0.08, 0.02]]\nvelocity = 0.5\n"
JET = "[[gas.inlets]]\ncircle = [0.04, 0.01, 0.012]\nramp = [[0.0, 0.0], [0.05, 10.0]]\n"


def write(folder, *tables, text=CASE):
    (folder / "case.toml").write_text(text.replace("[particles]", "".join(tables) + "[particles]"))
    return str(folder)


def problems_of(folder, *tables, text=CASE, sets=()):
    with pytest.raises(CaseError) as caught:
        load_case(write(folder, *tables, text=text), sets)
    return caught.value.problems


def test_areas_and_the_velocity_of_the_whole_are_filled_in(tmp_path):
    case = load_case(write(tmp_path, BACKGROUND, JET))
    jet = np.pi * 0.012**2 / 4
    assert [inlet.area for inlet in case.gas.inlets] == pytest.approx([0.0016 - jet, jet], rel=1e-12)
    assert case.gas.inlet_section == 0.08 * 0.02
    whole = (0.5 * (0.0016 - jet) + 10.0 * jet) / 0.0016
    assert derived.inlet_ramp(case.gas)[-1] == (0.05, pytest.approx(whole, rel=1e-12))
    assert derived.fastest_inlet(case.gas) == pytest.approx(whole) and derived.open_velocity(case) == 10.0
    numbers = {number.name: number for number in estimate(case)}
    assert numbers["inlet 2"].value == pytest.approx(10.0 * jet) and "Circle on floor" in numbers["inlet 2"].meaning
    assert numbers["superficial velocity"].value == pytest.approx(whole)
    assert f"{whole:g}" in numbers["minimum fluidization"].limit


def test_written_case_is_the_same_and_results_read_its_velocity(tmp_path):
    (tmp_path / "jet.csv").write_text("time [ms],velocity [m/s]\n0,0\n50,10\n50,8\n")
    file = JET.replace("ramp = [[0.0, 0.0], [0.05, 10.0]]", 'ramp_file = "jet.csv"')
    case = load_case(write(tmp_path, BACKGROUND, file))
    assert case.gas.inlets[1].ramp == ((0.0, 0.0), (0.05, 10.0), (0.05, 8.0))
    write_case(case, tmp_path / "case.toml")
    assert load_case(str(tmp_path)) == case
    gas = case.model_dump(mode="json")["gas"]
    assert list_rows(gas) == list(derived.inlet_ramp(case.gas)) and len(list_rows(gas)) == 3 and not is_constant(gas)
    assert find_fastest(gas, 0.0, 0.1) == derived.fastest_inlet(case.gas)
    (tmp_path / "jet.csv").write_text("time,velocity\n0,0\n0.05,11\n")
    assert "ramp and ramp_file are both given and differ" in problems_of_file(tmp_path)[0]


def problems_of_file(folder):
    with pytest.raises(CaseError) as caught:
        load_case(str(folder))
    return caught.value.problems


def test_a_sum_of_ramps_jumps_where_one_of_them_does():
    steady, jump = [(0.0, 1.0)], [(0.1, 0.0), (0.2, 2.0), (0.2, 0.0), (0.4, 4.0)]
    rows = sum_rows([(0.5, steady), (0.25, jump), (1.0, [(0.0, 0.0), (0.3, 3.0)])])
    expected = [(0.0, 0.5), (0.1, 1.5), (0.2, 3.0), (0.2, 2.5), (0.3, 4.0), (0.4, 4.5)]
    assert np.array(rows) == pytest.approx(np.array(expected), rel=1e-14)
    assert sum_rows([(0.5, steady), (2.0, [(0.0, 3.0)])]) == [(0.0, 6.5)]
    assert find_mean({"inlets": [{"area": 2.0, "velocity": 3.0}], "inlet_section": 4.0}, 0.0, 1.0) == 1.5


LEFT = "[[gas.inlets]]\nrectangle = [[0.0, 0.0], [0.04, 0.02]]\nramp = [[0.0, 0.0], [0.05, 1.0]]\n"
RIGHT = LEFT.replace("[[0.0, 0.0], [0.04, 0.02]]", "[[0.04, 0.0], [0.08, 0.02]]")
HEATED = """[heat]
gas_temperature = 300.0
gas_specific_heat = 1010.0
prandtl = 0.7
particle_temperature = 300.0
particle_specific_heat = 840.0
wall_temperature = 350.0
"""


def test_what_goes_out_by_one_inlet_hides_not_what_comes_in_by_another(tmp_path):
    out = RIGHT.replace("1.0]", "-1.0]")
    case = load_case(write(tmp_path, LEFT, out, text=CASE + HEATED))
    assert derived.fastest_inflow(case.gas) == pytest.approx(0.0, abs=1e-15)
    assert derived.fastest_inlet(case.gas) == pytest.approx(1.0, rel=1e-12)
    assert find_fastest(case.model_dump(mode="json")["gas"], 0.0, 0.025) == pytest.approx(0.5, rel=1e-12)
    assert not is_inlet_closed(case.gas) and "inletOutlet" in render_decks(case)["CFD/0/T"].partition("outlet\n")[0]
    both = load_case(write(tmp_path, LEFT, RIGHT))
    assert count_fluid_steps(case, 0.1) == pytest.approx(count_fluid_steps(both, 0.1), rel=1e-12)
    closed = load_case(write(tmp_path, LEFT.replace("1.0]", "0.0]"), RIGHT.replace("1.0]", "0.0]")))
    assert is_inlet_closed(closed.gas) and derived.fastest_inlet(closed.gas) == 0.0


def test_the_fastest_is_of_one_time(tmp_path):
    """One inlet closes while the other opens: never more than half of the floor's gas comes in."""
    case = load_case(write(tmp_path, LEFT, RIGHT.replace("[[0.0, 0.0], [0.05, 1.0]]", "[[0.0, 1.0], [0.05, 0.0]]")))
    assert derived.fastest_inlet(case.gas) == pytest.approx(0.5, rel=1e-12)
    assert derived.inlet_speed(case.gas, 0.03) == pytest.approx(0.5, rel=1e-12)


def test_a_file_of_many_rows_is_in_the_deck_to_the_last_digit(tmp_path):
    rows = [(1e-3 * n, 5.0 + math.sin(0.1 * n)) for n in range(1000)]
    (tmp_path / "jet.csv").write_text("time,velocity\n" + "".join(f"{t!r},{u!r}\n" for t, u in rows))
    case = load_case(write(tmp_path, JET.replace("ramp = [[0.0, 0.0], [0.05, 10.0]]", 'ramp_file = "jet.csv"')))
    deck = render_decks(case, tmp_path)["CFD/0/U"]
    (table,) = re.findall(r"table1\s+\(\s*((?:\([^()]*\)\s*)+)\);", deck)
    assert [tuple(map(float, row.split())) for row in re.findall(r"\(([^()]*)\)", table)] == rows
    assert len(derived.inlet_ramp(case.gas)) == 1000


SHORT = CASE.replace("viscosity = 1.8e-5", "viscosity = 1.8e-5\ninlet_velocity = 1.0")
NOZZLE = SHORT.replace("inlet_velocity = 1.0", "inlet_velocity = 1.0\nclosed_nozzle_size = [0.02, 0.02]")
HALF = "[[gas.inlets]]\nrectangle = [[0.0, 0.0], [0.04, 0.02]]\nvelocity = 0.5\n"
MISTAKES = {
    "no place": ("[[gas.inlets]]\nvelocity = 1.0\n", CASE, "none of rectangle, circle and patches is given"),
    "patches": (HALF.replace("rectangle = [[0.0, 0.0], [0.04, 0.02]]", 'patches = ["a"]'), CASE, "patches is given"),
    "two places": (JET + "rectangle = [[0.0, 0.0], [0.01, 0.01]]\n", CASE, "rectangle and circle is given"),
    "outside": (HALF.replace("0.04", "0.09"), CASE, "sticks out of the face floor, which has x from 0 to 0.08 m"),
    "circle out": (JET.replace("[0.04, 0.01", "[0.004, 0.01"), CASE, "inlet 1: [0.004, 0.01, 0.012] sticks out"),
    "no area": (HALF.replace("[0.04, 0.02]", "[0.04, 0.0]"), CASE, "has no area; give two opposite corners"),
    "no velocity": (HALF.replace("velocity = 0.5\n", ""), CASE, "no velocity is given; give velocity, ramp or"),
    "velocity twice": (JET + "velocity = 1.0\n", CASE, "velocity and a ramp are both given"),
    "ramp": (JET.replace("[0.05, 10.0]", "[0.05, 10.0], [0.04, 1.0]"), CASE, "row 3 of its ramp is at 0.04 s, before"),
    "no file": (HALF.replace("velocity = 0.5", 'ramp_file = "a.csv"'), CASE, "a.csv cannot be read"),
    "short form": (HALF, SHORT, "it and inlets are both given; remove one"),
    "all covered": (HALF + BACKGROUND, CASE, "inlet 1: later ones cover all of it; put it behind them"),
    "area": (HALF + "area = 1e-3\n", CASE, "area = 0.001 m2 is given and it has 0.0008 m2"),
    "circles": (JET + JET.replace("[0.04,", "[0.045,"), CASE, "circles of inlets 1 and 2 cross each other"),
    "profile": (BACKGROUND + 'profile = "parabolic"\n' + JET, CASE, "and another inlet lies on it"),
    "repeats": (
        HALF + 'face = "front"\n',
        CASE.replace("[gas]", 'periodic = ["y"]\n[gas]'),
        'face = "front" is given and the bed repeats itself there',
    ),
    "lid": (HALF, CASE.replace("[gas]", '[gas]\ntop = "closed"'), "gas comes in and gas.top is closed"),
    "nozzle": (HALF, NOZZLE.replace("inlet_velocity = 1.0\n", ""), "a table with velocity = 0 closes what it covers"),
    "all closed": ("", NOZZLE.replace("[0.02, 0.02]", "[0.08, 0.02]"), "leaves nothing open or sticks out"),
    "outlet": (
        HALF + "[[gas.outlets]]\ncircle = [0.04, 0.01, 0.001]\n",
        CASE,
        "outlet 1: it holds the centre of no face of the mesh on top",
    ),
    "cylinder": (
        JET.replace("[0.04, 0.01,", "[0.04, 0.04,") + 'face = "left"\n',
        CASE.replace("[16, 4, 40]", "[16, 16, 40]")
        .replace("[0.08, 0.02", "[0.08, 0.08")
        .replace("[gas]", 'shape = "cylinder"\n[gas]'),
        "a cylinder has them on its floor and its top",
    ),
}


PROFILE = '[[gas.inlets]]\ncircle = [0.04, 0.01, 0.012]\nprofile_file = "jet.csv"\n'
SLOT = '[[gas.inlets]]\nrectangle = [[0.02, 0.0], [0.04, 0.02]]\nprofile_file = "jet.csv"\n'
RADII = "radius [mm],velocity\n0,3\n6,0\n"
"""A cone: its mean is a third of its top."""


def test_a_profile_is_as_its_file_says_or_scaled(tmp_path):
    (tmp_path / "jet.csv").write_text(RADII)
    case = load_case(write(tmp_path, PROFILE))
    (inlet,) = case.gas.inlets
    assert inlet.velocity == pytest.approx(1.0, rel=1e-14) and inlet.peak == pytest.approx(3.0, rel=1e-14)
    assert derived.open_velocity(case) == pytest.approx(3.0)
    write_case(case, tmp_path / "case.toml")
    assert load_case(str(tmp_path)) == case
    scaled = load_case(write(tmp_path, PROFILE + "ramp = [[0.0, 0.0], [0.1, 4.0]]\n"))
    assert scaled.gas.inlets[0].velocity is None and derived.open_velocity(scaled) == pytest.approx(12.0)


@pytest.mark.parametrize(
    ("table", "text", "words"),
    [
        (PROFILE, None, "inlet 1: jet.csv cannot be read"),
        (
            PROFILE,
            "radius,velocity\n0,3\n0.005,0\n",
            "jet.csv: radii from 0 to 0.005 m are given, and the circle has 0 to",
        ),
        (PROFILE, "radius [in],velocity\n0,3\n1,0\n", "units that are read: m, cm, mm"),
        (PROFILE, "x,velocity\n0,3\n1,0\n", "has no column radius"),
        (PROFILE, RADII.replace("6,0", "6,-1"), "jet.csv has a velocity of -1 m/s"),
        (PROFILE, RADII.replace("0,3", "0,0"), "jet.csv lets no gas in: its mean over the inlet is 0"),
        (PROFILE, RADII.replace("0,3", "0,x"), "jet.csv: line 2 has `x` for velocity; give a number"),
        (PROFILE + "peak = 2.0\n", RADII, "peak = 2 is given and it is 3; remove it"),
        (PROFILE + 'profile = "parabolic"\n', RADII, "profile_file are both given; give one of them"),
        (PROFILE.replace("circle = [0.04, 0.01, 0.012]", 'patches = ["a"]'), RADII, "patches is given"),
        (PROFILE + JET.replace("0.012", "0.004"), RADII, "inlet 1: it has a profile and another inlet lies on it"),
        (PROFILE + "velocity = 1.0\nramp = [[0.0, 1.0]]\n", RADII, "velocity and a ramp are both given"),
        (SLOT, "velocity\n1\n2\n", "jet.csv has no coordinate; a rectangle on floor takes x and y, or one of them"),
        (SLOT, "x,velocity\n0.02,1\n0.03,2\n", "the rectangle has 0.02 to 0.04 m; give the velocity on its edges"),
        (SLOT, "x,y,velocity\n0.02,0,1\n0.04,0,1\n0.02,0.02,1\n", "leave 0.5 of the rectangle without a velocity"),
        (SLOT, "x,velocity\n" + "".join(f"{n},1\n" for n in range(5001)), "has 5001 rows, at most 5000 are allowed"),
        (BACKGROUND + "peak = 2.0\n", None, "peak is given without profile_file"),
    ],
)
def test_a_mistake_in_the_file_of_a_profile_is_told(tmp_path, table, text, words):
    if text:
        (tmp_path / "jet.csv").write_text(text)
    problems = problems_of(tmp_path, table)
    assert [problem for problem in problems if words in problem], problems


@pytest.mark.parametrize(
    ("table", "text", "beyond"),
    [
        (PROFILE, RADII, None),
        (PROFILE, "radius,velocity\n0,3\n6,0\n", 5.994),
        (SLOT, "x,velocity\n0.02,1\n0.04,2\n", None),
        (SLOT, "x,velocity\n0,1\n0.045,2\n", 0.02),
        (SLOT, "x,y,velocity\n0.02,0,1\n0.04,0,1\n0.02,0.03,1\n0.04,0.03,1\n", 0.01),
    ],
)
def test_a_profile_that_goes_beyond_its_inlet_is_told(tmp_path, table, text, beyond):
    """Of a larger section, or in another unit: 6 mm taken for 6 m."""
    (tmp_path / "jet.csv").write_text(text)
    path = write(tmp_path, table)
    rows = [row for row in estimate(load_case(path), folder=tmp_path) if row.name == "profile beyond inlet 1"]
    assert [row.value for row in rows] == ([] if beyond is None else [pytest.approx(beyond)])
    assert all(row.verdict == "warn" for row in rows)


def test_the_file_of_a_ramp_is_read_once_a_load(tmp_path, monkeypatch):
    (tmp_path / "jet.csv").write_text("time,velocity\n0,0\n0.05,10\n")
    read, asked = adopt_inlets.read_table, []
    monkeypatch.setattr(adopt_inlets, "read_table", lambda *given: asked.append(given) or read(*given))
    load_case(write(tmp_path, JET.replace("ramp = [[0.0, 0.0], [0.05, 10.0]]", 'ramp_file = "jet.csv"')))
    assert len(asked) == 1


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_name_the_table_and_say_what_is_allowed(tmp_path, name):
    tables, text, words = MISTAKES[name]
    problems = problems_of(tmp_path, tables, text=text)
    assert [problem for problem in problems if words in problem], problems


def test_a_closed_nozzle_is_given_once(tmp_path):
    problems = problems_of(
        tmp_path, text=NOZZLE.replace("closed_nozzle_size", "closed_nozzle = [2, 2]\nclosed_nozzle_size")
    )
    assert [problem for problem in problems if "it and closed_nozzle_size are both given" in problem]


def test_a_circle_on_the_floor_of_a_cylinder(tmp_path):
    text = CASE.replace("[16, 4, 40]", "[16, 16, 40]").replace("[0.08, 0.02", "[0.08, 0.08")
    text = text.replace("[gas]", 'shape = "cylinder"\n[gas]')
    case = load_case(write(tmp_path, JET.replace("[0.04, 0.01,", "[0.04, 0.04,"), text=text))
    assert case.gas.inlets[0].area == pytest.approx(np.pi * 0.012**2 / 4, rel=1e-12)
    problems = problems_of(tmp_path, JET.replace("[0.04, 0.01,", "[0.04, 0.074,"), text=text)
    assert [problem for problem in problems if "within the circle" in problem]


def test_what_an_outlet_lacks_names_the_outlet_and_the_option(tmp_path):
    mesh = {"Inlet": [0], "OUTLET": [1], "walls": [2]}
    found = SimpleNamespace(surfaces=mesh, inner={}, loose={}, others=())
    given, usual = Opening(patches=("outlet",)), Opening(patches=("outlet",), key="domain.outlet")
    with pytest.raises(CaseError, match=r"outlet 2: there is no patch outlet with faces; give patches = one of: Inlet"):
        _list_outlet_faces(None, (Opening(patches=("OUTLET",)), given), found)
    with pytest.raises(CaseError, match=r"give domain\.outlet = one of: Inlet, OUTLET, walls"):
        find_outlet_faces(None, usual, found)


@pytest.mark.parametrize("shift", [0.0, 3.0, 1.99])
def test_rounding_does_not_decide_which_points_are_in_a_shape(shift):
    points = np.array([[0.001, 0.0035], [0.007, 0.0075], [0.0070001, 0.005]]) + shift
    rectangle = Rectangle((0.001 + shift, 0.0035 + shift), (0.007 + shift, 0.0075 + shift))
    assert rectangle.has(points).tolist() == [True, True, False]


@pytest.mark.parametrize(
    ("key", "file", "known"),
    [
        ("ramp_file", "time,velocity,temperature\n0,0,300\n0.05,10,500\n", "time, velocity"),
        ("profile_file", "radius,velocity,temperature\n0,2,500\n0.006,1,400\n", "radius, velocity"),
    ],
)
def test_a_column_of_a_file_of_an_inlet_that_nothing_looks_at_is_refused(tmp_path, key, file, known):
    (tmp_path / "jet.csv").write_text(file)
    table = JET.replace("ramp = [[0.0, 0.0], [0.05, 10.0]]", f'{key} = "jet.csv"')
    text = f"jet.csv has the columns 'temperature', which nothing looks at; remove them: {known} may be there."
    assert any(one.endswith(text) and "inlet 2: " in one for one in problems_of(tmp_path, BACKGROUND, table))


def test_an_inlet_of_an_ideal_gas_weighs_with_the_density_of_its_temperature():
    gas = {
        "inlet_section": 2.0,
        "inlets": [
            {"area": 1.0, "velocity": 0.5, "ramp": None, "temperature": None},
            {"area": 1.0, "velocity": 4.0, "ramp": None, "temperature": 600.0},
        ],
    }
    assert find_fastest(gas, 0.0, 1.0) == 2.25
    ideal = {"gas_density": "ideal", "gas_temperature": 300.0}
    assert find_fastest(weigh_inlets(gas, ideal), 0.0, 1.0) == 1.25
    assert weigh_inlets(gas, ideal | {"gas_density": "constant"}) is gas and weigh_inlets(gas, None) is gas
