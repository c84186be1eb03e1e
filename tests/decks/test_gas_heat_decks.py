"""Heat of the gas in the decks: a field of its temperature and how it is solved, and nothing of it without heat."""

from __future__ import annotations

import re

import pytest
from test_render import CYLINDER, NO_GAS, build

from fbcouple.case.bed.adopt_inlets import adopt_inlets
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks

GAS = {"gas_temperature": 293.15, "gas_specific_heat": 1010.0, "prandtl": 0.8}
HEAT = GAS | {"particle_temperature": 363.15, "particle_specific_heat": 840.0}
PARTS = ("gas_heat", "hot_gas_walls", "inlet_temperatures")
JET = {"circle": [0.04, 0.007, 0.006], "velocity": 4.0}
SOLVED = {"CFD/system/fvSchemes": "div(voidagePhi,T)", "CFD/system/fvSolution": "    T\n    {"}


def patches(**changes) -> dict[str, str]:
    text = render_decks(build(heat=HEAT | changes.pop("heat", {}), **changes))["CFD/0/T"]
    assert "internalField   uniform 293.15;" in text
    return {name: kind for name, kind in re.findall(r"^    (\w+)\n    \{[^}]*?type +(\w+);", text, re.MULTILINE)}


def test_gas_without_heat_has_no_temperature():
    decks, heated = render_decks(build()), render_decks(build(heat=HEAT))
    assert heated.keys() - decks.keys() == {"CFD/0/T"}
    for name, words in SOLVED.items():
        assert words in heated[name] and words not in decks[name]
    assert not any(find_needs(build())[part] for part in PARTS)
    assert find_needs(build(heat=HEAT))["gas_heat"] and not find_needs(build(heat=HEAT))["hot_gas_walls"]


def test_particles_alone_have_no_gas_to_heat():
    case = build(**NO_GAS, heat={"particle_temperature": 363.15, "particle_specific_heat": 840.0})
    assert not any(find_needs(case)[part] for part in PARTS)
    assert not any(name.startswith("CFD") for name in render_decks(case))


def test_openings_have_the_temperature_of_what_comes_in_and_walls_are_adiabatic():
    found = patches()
    assert found["inlet"] == found["outlet"] == "inletOutlet" and found["walls"] == "zeroGradient"


@pytest.mark.parametrize(
    "walls",
    [{"wall_temperature": 300.0}, {"walls": [{"face": "left", "temperature": 300.0}]}],
    ids=["all", "one"],
)
def test_hot_walls_are_left_to_the_adapter(walls):
    case = build(heat=HEAT | walls)
    assert find_needs(case)["hot_gas_walls"]
    found = patches(heat=walls)
    assert found["walls"] == "mixed" and found["inlet"] == "inletOutlet"


def test_an_inlet_that_never_opens_and_a_lid_are_walls():
    found = patches(gas__inlet_velocity=0.0, gas__top="closed", heat={"wall_temperature": 300.0})
    assert found["inlet"] == found["outlet"] == found["walls"] == "mixed"


@pytest.mark.parametrize(
    ("heat", "kind"),
    [
        ({}, "inletOutlet"),
        ({"walls": [{"face": "left", "temperature": 300.0}]}, "inletOutlet"),
        ({"wall_temperature": 300.0, "walls": [{"face": "floor"}]}, "inletOutlet"),
        ({"walls": [{"face": "floor", "temperature": 300.0}]}, "mixed"),
    ],
    ids=["no-hot-walls", "another-wall", "adiabatic-floor", "hot-floor"],
)
def test_an_inlet_without_gas_is_a_wall_where_its_floor_is_hot(heat, kind):
    """Elsewhere it is as good as one, and a run can go on with it open."""
    assert patches(gas__inlet_velocity=0.0, heat=heat)["inlet"] == kind


def open_inlets(*inlets, **heat):
    floor = {"rectangle": [[0.0, 0.0], [0.08, 0.015]], "velocity": 0.5}
    changes = {"gas__inlet_velocity": None, "gas__closed_nozzle": None, "gas__inlets": [floor, *inlets]}
    return adopt_inlets(build(heat=HEAT | heat, **changes))


def test_an_inlet_with_a_temperature_is_mixed_with_those_that_share_its_faces():
    case = open_inlets(JET | {"temperature": 500.0}, {"rectangle": [[0.0, 0.0], [0.01, 0.015]], "velocity": 0.0})
    text = render_decks(case)["CFD/0/T"]
    assert find_needs(case)["inlet_temperatures"] and "type            mixedInletTemperature;" in text
    assert re.findall(r"temperature(\d) +([\d.]+);", text) == [("1", "293.15"), ("2", "500.0")]
    assert "idealGas        no;" in text
    assert (
        "idealGas        yes;"
        in render_decks(open_inlets(JET | {"temperature": 500.0}, gas_density="ideal"))["CFD/0/T"]
    )


def test_inlets_of_one_temperature_have_the_condition_of_openfoam():
    case = open_inlets(JET)
    assert not find_needs(case)["inlet_temperatures"]
    assert "mixedInletTemperature" not in render_decks(case)["CFD/0/T"]


def test_gradients_of_the_temperature_are_limited_where_faces_are_oblique():
    words = "grad(T)         cellLimited leastSquares 1;"
    assert words in render_decks(build(heat=HEAT, **CYLINDER))["CFD/system/fvSchemes"]
    assert words not in render_decks(build(heat=HEAT))["CFD/system/fvSchemes"]
    assert words not in render_decks(build(**CYLINDER))["CFD/system/fvSchemes"]
