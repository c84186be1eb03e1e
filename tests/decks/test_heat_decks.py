"""Heat in the decks: a place for temperatures, contacts that conduct, walls; nothing unless the case has [heat]."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from test_render import NO_GAS, build, join, numbers_after

from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks, set_up
from fbcouple.paths import TEMPERATURES

GAS = {"gas_temperature": 293.15, "gas_specific_heat": 1010.0, "prandtl": 0.8}
PARTICLES = {"particle_temperature": 363.15, "particle_specific_heat": 840.0}
CONDUCTING = PARTICLES | {"particle_conductivity": 1.4, "contact_conduction": "liggghts"}
TRACES = r"Temp|thermal|heat|temperature|youngsModulusOriginal"
DECK = "DEM/in.liggghts"
PLACE = "fix             Temp all property/atom Temp scalar yes no no 363.15\n"


def test_no_trace_of_heat_where_there_is_none():
    assert not re.search(TRACES, join(render_decks(build())))
    needs = find_needs(build())
    assert not any(needs[part] for part in ("heat", "particle_heat", "contact_conduction"))


def test_temperatures_alone_are_one_line():
    case = build(heat=GAS | PARTICLES)
    deck = render_decks(case)[DECK]
    assert deck.replace(PLACE, "") == render_decks(build())[DECK] and PLACE in deck
    needs = find_needs(case)
    assert needs["heat"] and needs["particle_heat"] and not needs["contact_conduction"]


@pytest.mark.parametrize(("law", "factor"), [("liggghts", 1.0), ("batchelor-obrien", 1.0 / math.sqrt(math.pi))])
def test_laws_are_a_factor_of_the_conductivity(law, factor):
    case = build(**NO_GAS, heat=CONDUCTING | {"contact_conduction": law})
    deck = render_decks(case)[DECK]
    assert find_needs(case)["contact_conduction"]
    assert numbers_after(deck, "fix +conductivity .* peratomtype ") == pytest.approx([1.4 * factor] * 2, rel=1e-15)
    assert numbers_after(deck, "fix +capacity .* peratomtype ") == [840.0] * 2
    assert "heat/gran/conduction initial_temperature 363.15\n" in deck and "newton          off\n" in deck
    assert PLACE not in deck and "area_correction" not in deck


def test_a_mixture_conducts_by_every_type():
    deck = render_decks(build(**NO_GAS, heat=CONDUCTING, particles__mixture=[[0.8e-3, 1500.0, 0.3]]))[DECK]
    assert numbers_after(deck, "fix +conductivity .* peratomtype ") == [1.4] * 3


def test_hertz_contacts_are_corrected_by_liggghts():
    """What is left is Hertz's radius over that of the circle of overlap, 2^(-1/2)."""
    hertz = {"contact__model": "hertz", "contact__youngs_modulus": 1e7, "contact__poisson_ratio": 0.25}
    heat = CONDUCTING | {"conduction_modulus": 2e11}
    deck = render_decks(build(**NO_GAS, **hertz, contact__impact_speed=1.0, heat=heat))[DECK]
    assert numbers_after(deck, "fix +material .* youngsModulusOriginal peratomtype ") == [2e11] * 2
    assert "initial_temperature 363.15 area_correction yes\n" in deck
    assert numbers_after(deck, "fix +conductivity .* peratomtype ") == pytest.approx([1.4 / math.sqrt(2.0)] * 2)


def test_linear_springs_are_corrected_at_one_force():
    """The factor goes with the square root of the spring and the inverse cube root of the modulus."""

    def find(stiffness, modulus):
        heat = CONDUCTING | {"conduction_modulus": modulus}
        deck = render_decks(build(**NO_GAS, contact__stiffness=stiffness, heat=heat))[DECK]
        assert "youngsModulusOriginal" not in deck and "area_correction" not in deck
        return numbers_after(deck, "fix +conductivity .* peratomtype ")[0]

    base = find(100.0, 1e10)
    assert find(1e4, 1e10) / base == pytest.approx(10.0) and find(100.0, 8e10) / base == pytest.approx(0.5)


def test_a_bed_of_parcels_conducts_as_its_grains_do():
    """Overlap and radius of a contact grow with the parcel, and so does Hertz's radius: their ratio stays."""
    heat = CONDUCTING | {"conduction_modulus": 1e10}
    grains, parcels = (
        numbers_after(
            render_decks(build(**NO_GAS, **more, particles__count=16, heat=heat))[DECK],
            "fix +conductivity .* peratomtype ",
        )
        for more in ({}, {"particles__coarse_graining": 2.0})
    )
    assert parcels == pytest.approx(grains, rel=1e-12)


def test_walls_have_their_temperatures():
    walls = [{"face": "floor", "temperature": 280.0}, {"face": "left"}]
    deck = render_decks(build(**NO_GAS, heat=CONDUCTING | {"wall_temperature": 293.15, "walls": walls}))[DECK]
    found = dict(re.findall(r"fix +([xyz](?:lo|hi)) .*plane \S+(?: temperature (\S+))?\n", deck))
    assert found == {"xlo": "", "zlo": "280.0"} | dict.fromkeys(("xhi", "ylo", "yhi", "zhi"), "293.15")
    still = render_decks(build(**NO_GAS, heat=PARTICLES | {"wall_temperature": 293.15, "walls": walls}))[DECK]
    assert "temperature" not in still, "without contacts that conduct nothing meets a wall in LIGGGHTS"


def test_opened_walls_keep_theirs():
    opening = {"face": "floor", "rectangle": [[0.002, 0.001], [0.004, 0.004]], "depth": 0.012}
    heat = CONDUCTING | {"wall_temperature": 293.15}
    decks = render_decks(build(**NO_GAS, heat=heat, particles__outlets=[opening]))
    assert re.search(
        r"fix +zloPlate .* type 2 temperature 293.15 curvature_tolerant yes\n", decks["DEM/open-1.liggghts"]
    )


def test_start_temperatures_that_differ_have_a_file(tmp_path):
    case = build(heat=GAS | PARTICLES)
    values = np.linspace(300.0, 400.0, 20) / 3.0
    set_up(case, tmp_path / "run", read_temperatures=lambda case: values)
    assert np.array_equal(np.loadtxt(tmp_path / "run" / TEMPERATURES), values)
    set_up(case, tmp_path / "alike")
    assert not (tmp_path / "alike" / TEMPERATURES).exists()
