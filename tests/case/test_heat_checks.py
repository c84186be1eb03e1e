"""[heat] that lacks what its phases and laws need, or has what nothing looks at, is refused in words."""

from __future__ import annotations

import math
import re

import pytest

from fbcouple.case.load import load_case, write_case
from fbcouple.case.preflight import estimate
from fbcouple.errors import CaseError
from fbcouple.results.inlet_speed import find_fastest, weigh_inlets
from fbcouple.study.indicators import find_strange_temperature

GAS = {"gas_temperature": 293.15, "gas_specific_heat": 1010.0, "prandtl": 0.8}
PARTICLES = {"particle_temperature": 363.15, "particle_specific_heat": 840.0}
ALL = GAS | PARTICLES


def settings(values):
    return [f"heat.{key}={value!r}" for key, value in values.items()]


def problems_of(values, sets=(), case="patil/c2"):
    with pytest.raises(CaseError) as caught:
        load_case(case, [*sets, *settings(values)])
    return caught.value.problems


def test_heat_of_both_phases_is_written_and_read_again(tmp_path):
    walls = "[{face='top',temperature=326.15},{face='floor',temperature=293.15,coefficient=50.0},{face='left'}]"
    more = {"wall_temperature": 300.0, "wall_coefficient": 350.0}
    case = load_case("patil/c2", [*settings(ALL | more), f"heat.walls={walls}"])
    assert case.heat is not None and case.heat.nusselt == "gunn" and case.heat.contact_conduction == "none"
    assert case.heat.find_wall("top") == (326.15, None) and case.heat.find_wall("floor") == (293.15, 50.0)
    assert case.heat.find_wall("left") == (None, None) and case.heat.find_wall("right") == (300.0, 350.0)
    write_case(case, tmp_path / "case.toml")
    assert load_case(str(tmp_path)) == case


def test_a_case_without_heat_has_no_section_of_it():
    assert load_case("patil/c2").heat is None


@pytest.mark.parametrize("key", [*GAS, *PARTICLES])
def test_what_a_phase_needs_is_asked_for(key):
    (problem,) = problems_of({name: value for name, value in ALL.items() if name != key})
    name, words = (key, "nothing is given") if key != "prandtl" else ("gas_conductivity", "neither is given")
    assert f"heat.{name}: {words}" in problem and "; give" in problem


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({"gas_conductivity": 0.026}, "heat.gas_conductivity: both are given of gas_conductivity and prandtl"),
        (
            {"contact_conduction": "liggghts"},
            'heat.particle_conductivity: nothing is given and contact_conduction = "l',
        ),
        ({"bed_conduction": "zehner-schlunder"}, "heat.particle_conductivity: nothing is given and bed_conduction"),
        ({"conduction_modulus": 2e11}, "heat.conduction_modulus: 2e+11 Pa is given and contact_conduction"),
        ({"wall_coefficient": 350.0}, "heat.wall_coefficient: 350 W/(m2 K) is given and no wall has a temperature"),
        ({"wall_area": "gas"}, 'heat.wall_area: "gas" is given and no wall has a coefficient; give'),
        (
            {"contact_conduction": "liggghts", "particle_conductivity": 1e9},
            'heat.contact_conduction: "liggghts" is given and 12 contacts of 0.01 d would change a particle of 0.001 m',
        ),
        ({"gas_density": "perfect"}, 'heat.gas_density: "perfect" is given, "constant" or "ideal" is allowed'),
        ({"gas_temperature": -20.0}, "heat.gas_temperature: -20.0 is given, a number above 0"),
        ({"nusselt": "wakao"}, 'heat.nusselt: "wakao" is given, "gunn" or "ranz-marshall" or "own" is allowed'),
    ],
)
def test_laws_that_lack_a_number_and_numbers_without_a_law(values, problem):
    (found,) = problems_of(ALL | values)
    assert problem in found


@pytest.mark.parametrize(
    ("sets", "words"),
    [
        (["gas.top=closed"], 'with gas.top = "closed": the gas has nowhere to expand to; open the top'),
        (
            ["gas.turbulence=keqn"],
            'with gas.turbulence = "keqn", which carries its own fields at constant density; take',
        ),
        (["exchange.lift_force=true"], "with exchange.lift_force, which knows a constant density only; remove one"),
        (["exchange.polydisperse=beetstra"], "with exchange.polydisperse, which knows a constant density only"),
    ],
)
def test_an_ideal_gas_has_room_and_no_force_that_takes_its_density_for_constant(sets, words):
    assert any(
        f'heat.gas_density: "ideal" is given {words}' in text
        for text in problems_of(ALL | {"gas_density": "ideal"}, sets)
    )


@pytest.mark.parametrize(
    ("walls", "words"),
    [
        ("{face='top',temperature=300.0},{face='top'}", "face top is named 2 times; name it once"),
        ("{face='left',coefficient=10.0}", "wall 1: a coefficient of 10 W/(m2 K) is given and no temperature"),
        ("{face='roof'}", "face"),
    ],
)
def test_walls_of_heat(walls, words):
    (problem,) = problems_of(ALL, [f"heat.walls=[{walls}]"])
    assert "heat.walls" in problem and words in problem


@pytest.mark.parametrize(
    ("sets", "words"),
    [
        (["domain.periodic=['x']"], "face left is given, and the bed repeats itself there"),
        (["domain.shape='cylinder'", "domain.size=[0.044,0.044,0.1]", "domain.cells=[17,17,40]"], "floor and top"),
    ],
)
def test_walls_that_are_none(sets, words):
    problems = problems_of(ALL, [*sets, "heat.walls=[{face='left',temperature=300.0}]"])
    assert any("heat.walls: wall 1" in problem and words in problem for problem in problems)


def test_without_gas_nothing_of_gas_is_given():
    problems = problems_of(ALL | {"wall_temperature": 293.15}, case="single-impact")
    for key in GAS:
        assert any(f"heat.{key}: the case has no [gas]; remove it" in problem for problem in problems)
    assert any("heat.wall_temperature: a wall has one, but" in problem for problem in problems)
    assert len(problems) == len(GAS) + 1


CONDUCTING = ALL | {"contact_conduction": "batchelor-obrien", "particle_conductivity": 1.4}


@pytest.mark.parametrize(
    ("sets", "values", "problem"),
    [
        (["exchange.virtual_mass=true"], {}, "heat.contact_conduction: .batchelor-obrien. is given and exchange.virt"),
        (["gravity=0.0"], {"conduction_modulus": 2e11}, "heat.conduction_modulus: 2e.11 Pa .*, and gravity is 0; give"),
    ],
)
def test_conduction_that_liggghts_cannot_do(sets, values, problem):
    (found,) = problems_of(CONDUCTING | values, sets)
    assert re.search(problem, found)


@pytest.mark.parametrize("few", [["particles.mass=1e-9"], ["particles.mass=2e-6", "particles.coarse_graining=2"]])
def test_a_modulus_is_brought_in_by_a_bed_that_is_there(few):
    feed = "particles.feeds=[{low=[0.0,0.0,0.2],high=[0.044,0.01,0.22],rate=5.0}]"
    problems = problems_of(CONDUCTING | {"conduction_modulus": 2e11}, [*few, feed])
    assert any("force of the bed at rest, and there are no particles at the start" in problem for problem in problems)


def test_a_modulus_is_not_brought_in_by_a_bed_that_feeds_make():
    feed = "particles.feeds=[{low=[0.0,0.0,0.08],high=[0.044,0.01,0.1],rate=1e5}]"
    problems = problems_of(CONDUCTING | {"conduction_modulus": 2e11}, [feed])
    assert any("feeds bring" in problem and "more than the" in problem for problem in problems), problems


def test_a_surface_has_one_temperature_for_contacts():
    sets = ["domain.shape='cylinder'", "domain.size=[0.044,0.044,0.1]", "domain.cells=[17,17,40]"]
    problems = problems_of(CONDUCTING, [*sets, "heat.walls=[{face='top',temperature=300.0}]"])
    assert any("heat.contact_conduction: " in problem and "its walls are one" in problem for problem in problems)


def test_a_feed_has_a_temperature_with_heat_only():
    feed = "particles.feeds=[{low=[0.0,0.0,0.2],high=[0.044,0.01,0.22],rate=5.0,temperature=400.0}]"
    (problem,) = problems_of({}, [feed])
    assert "particles.feeds: feed 1: temperature = 400 K is given and the case has no [heat]" in problem
    case = load_case("patil/c2", [*settings(ALL), feed])
    assert case.particles.feeds[0].temperature == 400.0


def test_hertz_contacts_that_conduct_may_be_given_by_their_overlap():
    """What conduction adds in a DEM step is looked at where the spring is known."""
    contact = load_case("beaulieu/heated", ["contact.max_overlap=0.05"]).contact
    assert contact.max_overlap is None and contact.youngs_modulus > 1e7
    with pytest.raises(CaseError, match=r"12 contacts of 0.01 d would change a particle of 0.0064 m"):
        load_case("beaulieu/heated", ["contact.max_overlap=0.05", "heat.particle_conductivity=1e12"])


def test_conduction_in_a_step_is_looked_at_for_every_kind():
    """A light sphere that is a little larger than the smallest takes more than it has before that does."""
    of_contact = ALL | {"contact_conduction": "liggghts", "particle_conductivity": 1e9}
    (problem,) = problems_of(of_contact)
    found = re.search(r"0.001 m by ([\d.e+]+) of the difference", problem)
    assert found is not None
    stable = of_contact | {"particle_conductivity": 0.5e9 / float(found[1])}
    assert load_case("patil/c2", settings(stable)).heat is not None
    light = ["particles.mixture=[[1.2e-3,50.0,0.5]]"]
    assert any("would change a particle of 0.0012 m by " in problem for problem in problems_of(stable, light))
    large = ["particles.mixture=[[4e-3,2500.0,0.001]]"]
    assert load_case("patil/c2", [*large, *settings(stable)]).heat is not None, "few large ones touch a small one"


def write_inlets(folder, jet, heat, density="constant", sets=()):
    """`patil/c2` with a floor of 1.2 m/s, and a `jet` in it."""
    lines = [
        'base = "patil/c2"',
        'unset = ["gas.closed_nozzle", "gas.inlet_velocity"]',
        *(
            ["[heat]", f'gas_density = "{density}"', *(f"{key} = {value}" for key, value in heat.items())]
            if heat
            else []
        ),
        *("[[gas.inlets]]", "rectangle = [[0.0, 0.0], [0.08, 0.015]]", "velocity = 1.2"),
        *("[[gas.inlets]]", "circle = [0.04, 0.007, 0.01]", *jet),
    ]
    (folder / "case.toml").write_text("\n".join(lines))
    return load_case(str(folder), sets)


@pytest.mark.parametrize(
    ("velocity", "heat", "words"),
    [
        ("velocity = 2.0", {}, "the case has no [heat]; remove it, or add [heat]."),
        ("velocity = 0.0", ALL, "it lets no gas in; remove it"),
        ("ramp = [[0.0, 0.0], [0.1, -1.0]]", ALL, "it lets no gas in; remove it"),
    ],
)
def test_a_temperature_of_an_inlet_that_nothing_looks_at_is_refused(tmp_path, velocity, heat, words):
    with pytest.raises(CaseError) as caught:
        write_inlets(tmp_path, [velocity, "temperature = 500.0"], heat)
    (problem,) = caught.value.problems
    assert f"gas.inlets: inlet 2: temperature = 500 K is given and {words}" in problem


def find_weighed(case):
    told = case.model_dump(mode="json")
    return find_fastest(weigh_inlets(told["gas"], told["heat"]), 0.0, 1.0)


def test_an_inlet_of_another_temperature_is_told_and_counts_as_a_volume_at_the_density_of_the_case(tmp_path):
    jet = ["velocity = 2.0", "temperature = 586.3"]
    constant, ideal = (write_inlets(tmp_path, jet, ALL, density) for density in ("constant", "ideal"))
    (told,) = (number for number in estimate(ideal) if number.name == "inlet 2")
    assert told.meaning.endswith("2 m s-1 all the time, 586.3 K.")
    (density,) = (number for number in estimate(constant) if number.name == "density of warm gas")
    assert density.value == pytest.approx(0.5)
    section, circle = 0.08 * 0.015, math.pi * 0.01**2 / 4.0
    by_floor = 1.2 * (section - circle)
    assert find_weighed(constant) == pytest.approx((by_floor + 2.0 * circle) / section)
    assert find_weighed(ideal) == pytest.approx((by_floor + 1.0 * circle) / section)


def test_one_inlet_of_several_is_set_by_its_number(tmp_path):
    jet = ["velocity = 2.0", "temperature = 500.0"]
    case = write_inlets(tmp_path, jet, ALL, sets=["gas.inlets.2.temperature=400.0", "gas.inlets.1.velocity=1.5"])
    floor, own = case.gas.inlets
    assert (floor.velocity, floor.temperature, own.velocity, own.temperature) == (1.5, None, 2.0, 400.0)


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("gas.inlets.3.velocity=1.0", "gas.inlets.3.velocity: the case has 2 tables [[gas.inlets]], counted from 1"),
        ("gas.outlets.1.face=floor", "gas.outlets.1.face: the case has no tables [[gas.outlets]]; fix it"),
        ("gas.inlets.2.temperature=-5.0", "gas.inlets.temperature: [[gas.inlets]] 2: -5.0 is given, a number above 0"),
        ("gas.inlets.temperature=300.0", '"gas.inlets.temperature=300.0": is not a setting; write key=value'),
    ],
)
def test_a_wrong_setting_of_a_table_names_it(tmp_path, setting, words):
    with pytest.raises(CaseError) as caught:
        write_inlets(tmp_path, ["velocity = 2.0", "temperature = 500.0"], ALL, sets=[setting])
    (problem,) = caught.value.problems
    assert problem.startswith(f"--set: {words}"), problem


def test_a_temperature_in_degrees_celsius_is_told(tmp_path):
    cold = write_inlets(tmp_path, ["velocity = 2.0", "temperature = 25.0"], ALL)
    (number,) = (number for number in estimate(cold) if number.name == "lowest temperature")
    assert number.value == 25.0 and number.verdict == "warn" and "give 298.15." in number.meaning
    fit = write_inlets(tmp_path, ["velocity = 2.0", "temperature = 298.15"], ALL)
    assert not [number for number in estimate(fit) if number.name == "lowest temperature"]


def test_temperatures_of_inlets_and_feeds_are_none_that_are_strange(tmp_path):
    case = write_inlets(tmp_path, ["velocity = 2.0", "temperature = 500.0"], ALL)
    rows = [{"min_temperature": 293.15, "max_temperature": 499.0}]
    assert find_strange_temperature(case, rows) == 0.0
    assert find_strange_temperature(case, [rows[0] | {"max_temperature": 520.685}]) == pytest.approx(0.1)
    feed = "particles.feeds=[{low=[0.0,0.0,0.2],high=[0.08,0.015,0.24],rate=100.0,temperature=900.0}]"
    fed = load_case("patil/c2", [*settings(ALL), feed])
    assert find_strange_temperature(fed, [{"min_temperature": 293.15, "max_temperature": 900.0}]) == 0.0
