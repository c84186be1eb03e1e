"""Options of the gas in the decks: no trace of one that is off, and the right words of one that is on."""

from __future__ import annotations

from typing import get_args

import pytest
from test_render import GAS_OPTIONS, build, join, numbers_after

from fbcouple.case.schema.gas import Gas
from fbcouple.coupling.forces import FORCES
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks
from fbcouple.verify.registry import load_checks

# Part -> the changes that put it in, words that then must be there (and are not without it), files of it.
OPTIONS = {
    "subgrid_energy": (
        {"gas__turbulence": "keqn"},
        ["LESModel        kEqn;", "div(voidagePhi,k)", '"k|flm|fmm"'],
        ["CFD/0/k"],
    ),
    "lagrangian_averages": (
        {"gas__turbulence": "dynamic-lagrangian"},
        ["LESModel        dynamicLagrangian;", "filter          simple;", "div(voidagePhi,flm)", "div(voidagePhi,fmm)"],
        ["CFD/0/flm", "CFD/0/fmm"],
    ),
    "viscous_force": ({"exchange__viscous_force": True}, ["viscousForceOnParticles yes;"], []),
    "lift_force": ({"exchange__lift_force": True}, [], []),
    "virtual_mass": ({"exchange__virtual_mass": True}, ["lastVelocity"], []),
    "accelerated_drag": ({"exchange__accelerated": True}, ["drivenVelocity"], []),
}
MODELS = get_args(Gas.model_fields["turbulence"].annotation)


def test_every_option_of_the_gas_is_looked_at():
    assert set(OPTIONS) == set(GAS_OPTIONS)


@pytest.mark.parametrize("part", OPTIONS)
def test_an_option_is_there_only_where_it_is_asked_for(part):
    changes, words, files = OPTIONS[part]
    assert find_needs(build(**changes))[part] and not find_needs(build())[part]
    with_it, without = render_decks(build(**changes)), render_decks(build())
    for word in words:
        assert word in join(with_it) and word not in join(without)
    assert set(with_it) - set(without) == set(files)


def test_the_lagrangian_averages_start_with_smagorinskys_coefficient():
    """C = flm/fmm = sqrt(2) 0.16^2."""
    decks = render_decks(build(gas__turbulence="dynamic-lagrangian"))
    (above,), (below,) = (numbers_after(decks[f"CFD/0/{name}"], "internalField +uniform ") for name in ("flm", "fmm"))
    assert above / below == pytest.approx(0.036204, rel=1e-4)


@pytest.mark.parametrize("walls", ["slip", "no-slip"])
def test_sub_grid_energy_is_zero_at_walls_that_hold_the_gas(walls):
    text = render_decks(build(gas__turbulence="keqn", gas__walls=walls))["CFD/0/k"]
    assert text.count("fixedValue") == (1 if walls == "slip" else 3)


@pytest.mark.parametrize("name", FORCES)
def test_every_force_has_an_anchor(name):
    assert name.replace("_", "-") in load_checks()


def test_a_force_that_lives_in_the_loop_leaves_the_decks_as_they_are():
    assert render_decks(build(exchange__lift_force=True)) == render_decks(build())


@pytest.mark.parametrize("model", [model for model in MODELS if model != "none"])
def test_every_model_has_an_anchor(model):
    assert f"turbulence-{model}" in load_checks()


@pytest.mark.parametrize("model", ["keqn", "dynamic-lagrangian"])
def test_fields_of_a_model_know_periodic_sides(model):
    decks = render_decks(build(gas__turbulence=model, domain__periodic=["x", "y"]))
    names = ["CFD/0/k"] if model == "keqn" else ["CFD/0/flm", "CFD/0/fmm"]
    for name in [*names, "CFD/0/nut"]:
        assert "cyclic;" in decks[name] and "walls" not in decks[name]
