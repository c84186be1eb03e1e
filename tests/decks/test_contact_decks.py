"""Contact options in the deck: no trace of one that is off, and the right numbers of one that is on."""

from __future__ import annotations

import pytest
from test_render import CONTACT_OPTIONS, build, join, numbers_after

from fbcouple.case.bed.derived import hertz_contact_time, particle_mass
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks
from fbcouple.physics.contact import normal_damping

HERTZ = {
    "contact__model": "hertz",
    "contact__youngs_modulus": 5e6,
    "contact__poisson_ratio": 0.25,
    "contact__impact_speed": 2.0,
    "contact__tangential": "history",
}
# Part -> the changes that put it in, words that then must be there (and are not without it), words that must be gone.
OPTIONS = {
    "tangential_history": (
        {"contact__tangential": "history"},
        ["tangential history", "newton          off"],
        ["no_history", "newton          on"],
    ),
    "rolling_friction": (
        {"contact__rolling_friction": 0.02},
        ["rolling_friction cdt", "coefficientRollingFriction"],
        [],
    ),
    "hertz": (
        HERTZ,
        ["model hertz", "youngsModulus", "poissonsRatio", "coefficientRestitution", "hard_particles", "soft_particles"],
        ["hooke", " kn ", " kt ", "gamman", "gammat"],
    ),
}


def deck_of(**changes):
    return render_decks(build(**changes))["DEM/in.liggghts"]


def test_every_contact_option_is_looked_at():
    assert set(OPTIONS) == set(CONTACT_OPTIONS)


@pytest.mark.parametrize("part", OPTIONS)
def test_a_contact_option_is_there_only_where_it_is_asked_for(part):
    changes, there, gone = OPTIONS[part]
    assert find_needs(build(**changes))[part] and not find_needs(build())[part]
    with_it, without = join(render_decks(build(**changes))), join(render_decks(build()))
    for word in there:
        assert word in with_it and word not in without
    for word in gone:
        assert word not in with_it and word in without


def test_history_goes_only_where_friction_is():
    """Pairs without friction get no tangential model while the walls have theirs."""
    deck = deck_of(contact__tangential="history", contact__friction=0.0)
    assert "pair_style      gran model hooke/stiffness\n" in deck
    assert deck.count("wall/gran model hooke/stiffness tangential history primitive") == 6


def test_friction_has_history_where_the_case_says_nothing():
    assert deck_of(contact__tangential=None) == deck_of(contact__tangential="history")
    smooth = {"contact__friction": 0.0, "contact__wall_friction": 0.0}
    assert deck_of(contact__tangential=None, **smooth) == deck_of(**smooth)


def test_the_dem_step_follows_from_what_a_packed_bed_needs():
    low = {"contact__tangential": "history", "contact__restitution": 0.3, "contact__wall_restitution": 0.3}
    (step,) = numbers_after(deck_of(**low), "timestep +")
    (six,) = numbers_after(deck_of(**low, contact__steps_per_contact=6), "timestep +")
    assert six / step == pytest.approx(9 / 6)


def test_numbers_of_the_tangential_spring():
    """k_t = ratio k_n; its dashpot is the ratio times the normal one, for pairs and walls by their own e."""
    deck = deck_of(contact__tangential="history", contact__tangential_stiffness=0.75, contact__tangential_damping=7.0)
    mass = particle_mass(build().particles)
    pair, wall = 2 * normal_damping(1000.0, mass / 2, 0.97), 2 * normal_damping(1000.0, mass, 0.9)
    assert numbers_after(deck, "fix +kt .* peratomtypepair 2 ") == [750.0] * 4
    assert numbers_after(deck, "fix +gamman .* peratomtypepair 2 ") == pytest.approx([pair, wall, wall, wall])
    assert numbers_after(deck, "fix +gammat .* peratomtypepair 2 ") == pytest.approx([7 * pair] + [7 * wall] * 3)
    assert numbers_after(deck, "neighbor +") == [4e-4] and numbers_after(deck, "neigh_modify .* binsize ") == [1.4e-3]


def test_the_tangential_spring_is_two_sevenths_and_half_as_damped_by_default():
    deck = deck_of(contact__tangential="history")
    assert numbers_after(deck, "fix +kt .* peratomtypepair 2 ") == pytest.approx([2000 / 7] * 4)
    normal = numbers_after(deck, "fix +gamman .* peratomtypepair 2 ")
    assert numbers_after(deck, "fix +gammat .* peratomtypepair 2 ") == pytest.approx([rate / 2 for rate in normal])


def test_numbers_of_hertz():
    deck = deck_of(**HERTZ)
    assert numbers_after(deck, "fix +young .* peratomtype ") == [5e6] * 2
    assert numbers_after(deck, "fix +poisson .* peratomtype ") == [0.25] * 2
    assert numbers_after(deck, "fix +rest .* peratomtypepair 2 ") == [0.97, 0.9, 0.9, 0.9]
    contact_time = hertz_contact_time(5e6 / (2 * (1 - 0.25**2)), particle_mass(build().particles) / 2, 2.5e-4, 2.0)
    assert numbers_after(deck, "timestep +") == pytest.approx([contact_time / 6])


def test_number_of_rolling_friction():
    deck = deck_of(contact__rolling_friction=0.02)
    assert numbers_after(deck, "fix +rolling .* peratomtypepair 2 ") == [0.02] * 4
    assert deck.count("rolling_friction cdt") == 7
