"""Kinds of particles in the decks: a type each and one for the walls, and tables that meet every restitution."""

from __future__ import annotations

import numpy as np
import pytest
from test_render import build, numbers_after, read_particles

from fbcouple.case.bed.particle_types import count_kinds, list_kinds
from fbcouple.decks.needs import explain, find_needs
from fbcouple.decks.render import render_decks, set_up

MIXTURE = {
    "particles__mixture": [[0.8e-3, 1500.0, 0.3], [1.4e-3, 4000.0, 0.2]],
    "particles__fractions": "number",
    "contact__pairs": [[1, 1, 0.95, 0.3], [1, 2, 0.8, 0.5], [3, 2, 0.7, 0.25]],
    "contact__walls": [[3, 0.6, 0.4]],
}
# Species pairs as the rows above say them, 1.0 the walls: restitution and friction.
WANTED = {
    (1, 1): (0.95, 0.3), (1, 2): (0.8, 0.5), (1, 3): (0.97, 0.2), (2, 2): (0.97, 0.2), (2, 3): (0.7, 0.25),
    (3, 3): (0.97, 0.2), (1, 4): (0.9, 0.1), (2, 4): (0.9, 0.1), (3, 4): (0.6, 0.4),
}  # fmt: skip
MASSES = np.pi / 6 * np.array([1e-3, 0.8e-3, 1.4e-3, np.inf]) ** 3 * [2500.0, 1500.0, 4000.0, 1.0]


def restitution_of(rate, mass, stiffness=1000.0):
    """Restitution of a linear contact with damping rate 2 gamma [1/s] (eq. 18 solved for e)."""
    gamma = rate / 2
    return np.exp(-np.pi * gamma / np.sqrt(stiffness / mass - gamma**2))


@pytest.fixture(scope="module")
def deck():
    return render_decks(build(**MIXTURE))["DEM/in.liggghts"]


def table_of(deck, name):
    return np.array(numbers_after(deck, f"fix +{name} .* peratomtypepair 4 ")).reshape(4, 4)


@pytest.mark.parametrize(("pair", "wanted"), WANTED.items())
def test_every_pair_meets_its_restitution_and_friction(deck, pair, wanted):
    i, j = (number - 1 for number in pair)
    mass = MASSES[i] if pair[1] == 4 else MASSES[i] * MASSES[j] / (MASSES[i] + MASSES[j])
    damping, friction = table_of(deck, "gamman"), table_of(deck, "friction")
    assert restitution_of(damping[i, j], mass) == pytest.approx(wanted[0], rel=1e-9)
    assert friction[i, j] == wanted[1]
    assert damping[i, j] == damping[j, i] and friction[i, j] == friction[j, i]


def test_tables_of_many_kinds_are_symmetric_to_the_last_bit():
    """LIGGGHTS compares them so."""
    spread = {"spread": "normal", "deviation": 1e-4, "smallest": 0.7e-3, "largest": 1.3e-3, "classes": 20}
    deck = render_decks(build(**{f"particles__{key}": value for key, value in spread.items()}))["DEM/in.liggghts"]
    for name in ("gamman", "gammat", "kn", "friction"):
        table = np.array(numbers_after(deck, f"fix +{name} .* peratomtypepair 21 ")).reshape(21, 21)
        assert (table == table.T).all(), name


def test_the_step_is_of_the_shortest_contact(deck):
    """Two of the lightest, 4.02e-10 kg: T_C = pi sqrt(M/k) to 1e-4 with e = 0.97."""
    (step,) = numbers_after(deck, "timestep +")
    assert step == pytest.approx(np.pi * np.sqrt(MASSES[1] / 2 / 1000.0) / 6, rel=1e-4)


def test_walls_are_the_last_type_and_lists_reach_the_largest(deck):
    assert deck.count("primitive type 4 ") == 6 and "primitive type 2 " not in deck
    assert numbers_after(deck, "neighbor +") == pytest.approx([0.24e-3])
    assert numbers_after(deck, "neigh_modify .* binsize ") == pytest.approx([1.64e-3])


def test_hertz_has_a_row_for_each_type():
    hertz = {"model": "hertz", "youngs_modulus": 5e6, "poisson_ratio": 0.25, "impact_speed": 1.0}
    changes = {f"contact__{key}": value for key, value in hertz.items()} | {"contact__tangential": "history"}
    deck = render_decks(build(**MIXTURE, **changes))["DEM/in.liggghts"]
    assert numbers_after(deck, "fix +young .* peratomtype ") == [5e6] * 4
    assert table_of(deck, "rest")[2].tolist() == [0.97, 0.7, 0.97, 0.6]


def test_particles_have_the_type_size_and_density_of_their_kind(tmp_path):
    case = build(**MIXTURE, particles__count=20)
    set_up(case, tmp_path / "run")
    head, table = read_particles(tmp_path / "run/DEM/particles.data")
    assert "4 atom types" in head
    kinds = list_kinds(case.particles)
    assert np.bincount(table[:, 1].astype(int))[1:].tolist() == count_kinds(case.particles) == [10, 6, 4]
    for row in table:
        kind = kinds[int(row[1]) - 1]
        assert row[2:4].tolist() == [kind.diameter, kind.density]
    assert (np.diff(table[:, 1]) != 0).sum() > 5, "mixed, not in layers"


def test_a_spread_is_told_and_absent_without():
    spread = {"spread": "normal", "deviation": 1e-4, "smallest": 0.7e-3, "largest": 1.3e-3, "classes": 5}
    case = build(**{f"particles__{key}": value for key, value in spread.items()}, particles__count=1000)
    (why,) = [part.why for part in explain(case) if part.name == "mixture"]
    assert why.count("; ") == 4 and find_needs(case)["mixture"]
    assert "Types 1 to 5 are the particles" in render_decks(case)["DEM/in.liggghts"]
    assert not find_needs(build())["mixture"] and "Types" not in render_decks(build())["DEM/in.liggghts"]
