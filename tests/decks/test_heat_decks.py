"""Heat in the decks: nothing of it unless the case has [heat]."""

from __future__ import annotations

from fbcouple.case.load import load_case
from fbcouple.decks.needs import find_needs

HEAT = [
    *("heat.gas_temperature=293.15", "heat.gas_specific_heat=1010", "heat.prandtl=0.8"),
    *("heat.particle_temperature=363.15", "heat.particle_specific_heat=840"),
]


def test_heat_is_out_unless_asked_for():
    assert find_needs(load_case("patil/c2", HEAT))["heat"] and not find_needs(load_case("patil/c2"))["heat"]
