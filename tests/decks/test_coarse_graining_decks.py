"""Parcels in the decks: spheres l times as large, springs l times as stiff, damped for the restitution of parcels."""

from __future__ import annotations

import numpy as np
import pytest
from test_mixture_decks import restitution_of
from test_render import build, numbers_after, read_particles

from fbcouple.decks.needs import explain, find_needs
from fbcouple.decks.render import render_decks, set_up

RATIO = 2.0
MASS = np.pi / 6 * (RATIO * 1e-3) ** 3 * 2500.0


def find_table(deck, name):
    return np.array(numbers_after(deck, f"fix +{name} .* peratomtypepair 2 ")).reshape(2, 2)


@pytest.mark.parametrize(
    ("scale", "pair", "wall"), [(True, np.sqrt(1 - 2 * (1 - 0.97**2)), np.sqrt(0.62)), (False, 0.97, 0.9)]
)
def test_springs_and_dashpots_are_of_parcels(scale, pair, wall):
    case = build(particles__coarse_graining=RATIO, contact__scale_restitution=scale)
    deck = render_decks(case)["DEM/in.liggghts"]
    stiffness = RATIO * case.contact.stiffness
    assert find_table(deck, "kn")[0, 0] == stiffness
    damping, friction = find_table(deck, "gamman"), find_table(deck, "friction")
    assert restitution_of(damping[0, 0], MASS / 2, stiffness) == pytest.approx(pair, rel=1e-9)
    assert restitution_of(damping[0, 1], MASS, stiffness) == pytest.approx(wall, rel=1e-9)
    assert friction.tolist() == find_table(render_decks(build())["DEM/in.liggghts"], "friction").tolist()
    (plain,) = numbers_after(render_decks(build())["DEM/in.liggghts"], "timestep +")
    assert numbers_after(deck, "timestep +")[0] == pytest.approx(RATIO * plain, rel=1e-3)


def test_the_start_has_parcels(tmp_path):
    set_up(build(particles__coarse_graining=RATIO, particles__count=80), tmp_path / "run")
    _, table = read_particles(tmp_path / "run/DEM/particles.data")
    assert len(table) == 10 and set(table[:, 2]) == {2e-3} and set(table[:, 3]) == {2500.0}


def test_it_is_told_and_leaves_no_trace_without():
    case = build(particles__coarse_graining=RATIO, particles__count=80)
    (why,) = [part.why for part in explain(case) if part.name == "coarse_graining"]
    assert why == "10 parcels of 8 particles each, 2 times as wide" and find_needs(case)["coarse_graining"]
    assert not find_needs(build())["coarse_graining"]
    assert render_decks(build(particles__coarse_graining=1.0)) == render_decks(build())
