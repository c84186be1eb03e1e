"""The parts of the exchange that an option adds: out unless asked for, and never in the decks."""

from __future__ import annotations

import pytest

from fbcouple.case.load import load_case
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks

PARTS = {
    "satellite_points": ["exchange.voidage=divided"],
    "gaussian_kernel": ["exchange.voidage=gaussian", "exchange.kernel_width=3"],
    "diffusion": ["exchange.diffusion_width=6"],
    "polydisperse_drag": ["exchange.polydisperse=beetstra"],
}


@pytest.mark.parametrize("part", PARTS)
def test_a_scene_has_the_parts_that_it_asks_for(part):
    asked, plain = load_case("patil/c2", PARTS[part]), load_case("patil/c2")
    assert find_needs(asked)[part] and not find_needs(plain)[part]
    assert render_decks(asked) == render_decks(plain)
